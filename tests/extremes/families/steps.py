"""Very many increments, and ones within rounding; cycles without end; tolerances down to rounding's floor."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from solving import DISSIMILAR, LOAD, SIMILAR

from fretsolve.errors import NotConvergedError

from .driving import Family, Parts, Probe, Run, by, led
from .limits import again, of_hertz, of_mindlin, off, worst
from .pairs import BODIES, FLAT_RIGID

PEAK = 2106.491
"""Of Hertz's pressure (MPa)."""


def sheared(increments: int, force: float = 36.0) -> list[Parts]:
    """Pressed, then sheared in so many increments."""
    return [{"P": LOAD, "increments": 2}, {"Qx": force, "increments": increments}]


def of_one_increment(run: Run) -> float:
    """Against loading at once: without influence across, slip is along the load, and the path does not matter."""
    once = again(run, load_path=sheared(1))
    shear = np.abs(run.last.fields.shear - once.last.fields.shear).max() / (0.1 * PEAK)
    work = off(run.end.work_total, once.end.work_total)
    return max(float(shear), off(run.end.delta_x, once.end.delta_x), 0.01 * work)


def of_before(stages: int) -> Callable[[Run], float]:
    """Largest change of the shear over the last so many increments, over the largest mu p."""

    def distance(run: Run) -> float:
        before, after = run.states[-1 - stages].fields.shear, run.last.fields.shear
        return float(np.abs(after - before).max()) / (0.1 * PEAK)

    return distance


def of_steady(per_cycle: int) -> Callable[[Run], float]:
    """Change of the work from the last cycle but one to the last one."""

    def distance(run: Run) -> float:
        work = np.array([state.summary.work for state in run.states])
        return off(work[-per_cycle:].sum(), work[-2 * per_cycle : -per_cycle].sum())

    return distance


def of_no_work(per_cycle: int) -> Callable[[Run], float]:
    """Work of the last cycle over that of the first: after shakedown everything sticks."""

    def distance(run: Run) -> float:
        work = np.array([state.summary.work for state in run.states])
        return float(work[-per_cycle:].sum() / work.sum())

    return distance


def reversal(name: str, value: float, part: float) -> list[Parts]:
    """Up to a value, back by a part of it, up again and as far beyond."""
    steps = (value, value * (1.0 - part), value, value * (1.0 + part))
    return [{"P": LOAD, "increments": 2}, *({name: step, "increments": 1} for step in steps)]


def cycles(first: Parts, *stages: Parts, times: int, increments: int = 2) -> list[Parts]:
    """Pressed, moved, then back and forth."""
    split = {"increments": increments}
    cycle = {"times": times, "stages": [stage | split for stage in stages]}
    return [{"P": LOAD, "increments": 4}, first | split, {"cycle": cycle}]


TINY = Family(
    "thousands of tiny increments",
    "1 to 2000 for 0.9 mu P, equal bodies without in-plane coupling",
    "one increment: shear traction, delta_x, 100 times the dissipated energy",
    tuple(
        Probe(
            f"{count} increments",
            led(points=24, load_path=sheared(count), coupling="none"),
            of_one_increment,
            1e-5,
            quick=count == 100,
            seconds=90.0,
        )
        for count in (10, 100, 1000, 2000)
    ),
)

UNLIKE_TINY = Family(
    "thousands of tiny increments, dissimilar bodies",
    "1000 of P, 1000 of Q",
    "certified",
    (
        Probe("P", led(by(1000, P=LOAD), points=24, bodies=DISSIMILAR), quick=False, seconds=90.0),
        Probe("Q", led(points=24, load_path=sheared(1000), bodies=DISSIMILAR), quick=False, seconds=90.0),
        Probe("50 of each", led(by(50, P=LOAD), by(50, Qx=36.0), points=16, bodies=DISSIMILAR)),
    ),
)

AT_ONCE = Family(
    "everything in one increment",
    "P, Qx, Qy, Mz together",
    "certified",
    tuple(Probe(name, led(by(1, P=LOAD, Qx=20.0, Qy=10.0, Mz=2.0), bodies=bodies)) for name, bodies in BODIES.items()),
)

REVERSED = Family(
    "reversal within rounding",
    "1e-3 to 4e-16 of Qx, P, delta_x, and none",
    "shear traction as before",
    tuple(
        Probe(
            f"{name} {component} {part:g}",
            led(load_path=reversal(component, value, part), bodies=bodies),
            of_before(3),
            1e-5 + 20.0 * part,
            quick=part == 4e-16,
        )
        for name, bodies in BODIES.items()
        for component, value in (("Qx", 30.0), ("delta_x", 7e-4), ("delta_y", 1e-2))
        for part in (1e-3, 1e-6, 1e-9, 1e-12, 4e-16, 0.0)
    ),
)

HELD = Family(
    "loads held, at tight tolerance",
    "tolerance 1e-6 to 1e-12",
    "shear traction as before",
    tuple(
        Probe(
            f"{name} tolerance {tolerance:g}",
            led(by(3, P=LOAD), by(2, Qx=20.0), by(2, Qx=20.0), bodies=bodies, solver={"tolerance": tolerance}),
            of_before(2),
            1e-5,
            quick=tolerance in (1e-6, 1e-9),
        )
        for name, bodies in BODIES.items()
        for tolerance in (1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-12)
    ),
)

TIGHT = Family(
    "tolerance",
    "0.9 to 1e-13",
    "Hertz, Mindlin to the grid or the tolerance",
    tuple(
        Probe(
            f"{name} tolerance {tolerance:g}",
            led(load_path=sheared(2), bodies=bodies, solver={"tolerance": tolerance}),
            worst(of_hertz, of_mindlin) if name == "equal" else None,
            0.01 + tolerance,
            quick=tolerance in (0.9, 1e-13),
        )
        for name, bodies in BODIES.items()
        for tolerance in (0.9, 0.1, 1e-2, 1e-9, 1e-12, 1e-13)
    ),
)

FLOOR = Family(
    "tolerance at rounding's floor",
    "1e-14, 2e-15; heights 1e9 mm off",
    "certified, or refused with rounding named",
    (
        *(
            Probe(
                f"{name} tolerance {tolerance:g} {load}",
                led(by(5, P=LOAD), stage | {"increments": 2}, bodies=bodies, solver={"tolerance": tolerance}),
                refused=NotConvergedError,
                says="rounding",
                may_solve=True,
                quick=tolerance == 2e-15 and load == "delta_x",
            )
            for name, bodies in BODIES.items()
            for tolerance in (1e-14, 2e-15)
            for load, stage in (("Qx", {"Qx": 39.996}), ("delta_x", {"delta_x": 0.01}))
        ),
        *(
            Probe(
                f"heights {offset:g} mm off",
                {"grid": {"points": 32, "size": 0.8}},
                refused=NotConvergedError,
                says="rounding",
                heights=partial(np.full, (101, 101), offset),
                quick=offset == 1e9,
            )
            for offset in (1e9, 1e12)
        ),
    ),
)

STEADY = Family(
    "shakedown and steady cycles",
    "1000 increments of Qx, Mz, delta_x, P",
    "dissipated energy per cycle steady, or none",
    (
        *(
            Probe(
                f"{name} Qx, 250 cycles",
                led(
                    points=24,
                    load_path=cycles(
                        {"Qx": 0.6 * mu * LOAD}, {"Qx": -0.6 * mu * LOAD}, {"Qx": 0.6 * mu * LOAD}, times=250
                    ),
                    bodies=bodies,
                    friction=mu,
                ),
                of_steady(4),
                1e-6,
                quick=False,
                seconds=90.0,
            )
            for name, bodies, mu in (
                ("equal", SIMILAR, 0.1),
                ("unlike", DISSIMILAR, 0.5),
                ("rigid on nu 0", FLAT_RIGID, 0.3),
            )
        ),
        Probe(
            "equal Qx, 15 cycles",
            led(points=16, load_path=cycles({"Qx": 24.0}, {"Qx": -24.0}, {"Qx": 24.0}, times=15)),
            of_steady(4),
            1e-6,
        ),
        Probe(
            "unlike Mz, 100 cycles",
            led(points=24, load_path=cycles({"Mz": 4.0}, {"Mz": -4.0}, {"Mz": 4.0}, times=100), bodies=DISSIMILAR),
            of_steady(4),
            1e-6,
            quick=False,
            seconds=60.0,
        ),
        Probe(
            "unlike delta_x to gross slip, 10 cycles",
            led(
                points=20,
                load_path=cycles({"delta_x": 2.5e-3}, {"delta_x": -2.5e-3}, {"delta_x": 2.5e-3}, times=10),
                bodies=DISSIMILAR,
            ),
            of_steady(4),
            1e-6,
        ),
        *(
            Probe(
                f"equal P at Qx held, {times} cycles",
                led(points=20, load_path=cycles({"Qx": 15.0}, {"P": 0.75 * LOAD}, {"P": LOAD}, times=times)),
                of_no_work(4),
                1e-6,
                quick=times == 10,
                seconds=60.0,
            )
            for times in (10, 250)
        ),
    ),
)

FAMILIES = (TINY, UNLIKE_TINY, AT_ONCE, REVERSED, HELD, TIGHT, FLOOR, STEADY)
