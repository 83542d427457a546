"""Compare wear with certified values, and show its error against the jumps and its costs.

    python benchmarks/wear.py                             # about 40 minutes
    python benchmarks/wear.py --into docs/verification.md

Worn surfaces are known in closed form, or certified by rings. A rigid sphere of 10 mm is pressed on a half-space with
nu = 0: contact radius a0 = 0.3 mm, approach d0, V0 = pi a0^4/4R. T counts cycles: 4 k mu N E* a0/R in partial slip, k P
S N/V0 in gross slip with a path of slip S in a cycle.
"""

from __future__ import annotations

import itertools
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from helpers import parser_of, report

from fretsolve import run
from fretsolve.case.models import Case
from fretsolve.reference.worn_contact import WornLimit, worn_limit_at_displacement, worn_limit_at_force
from fretsolve.result.state import State
from fretsolve.system.arrays import FloatArray

Shift = tuple[float, float]

RADIUS, MODULUS, A0 = 10.0, 1e5, 0.3
P0, D0, V0 = 4.0 / 3.0 * MODULUS * A0**3 / RADIUS, A0**2 / RADIUS, np.pi * A0**4 / (4.0 * RADIUS)
ALPHA = 1e-7
"""In mm^3/mJ."""

FRICTION = 0.2
"""Of partial slip."""

PARTIAL_SIZES = {("P", 0.1): 2.6, ("P", 1.0): 2.7, ("P", 10.0): 3.5, ("d", 0.1): 2.6, ("d", 1.0): 2.7, ("d", 10.0): 3.0}
"""Side of the grid over a0."""

GROSS_SIZES = {1.0: 2.8, 10.0: 4.1, 100.0: 7.0}

CENTRED: Shift = (0.0, 0.0)
"""The sphere's axis lies where four cells meet, so that by symmetry eight cells go from stick to slip at once."""


@dataclass(frozen=True)
class Worn:
    """A run with wear: its states and its processor time (s)."""

    states: list[State]
    seconds: float

    @property
    def last(self) -> State:
        """The last increment."""
        return self.states[-1]

    @property
    def volume(self) -> float:
        """The worn volume over V0."""
        return self.last.summary.wear_volume / V0

    @property
    def jumps(self) -> int:
        """The number of solved cycles that stand for more than themselves."""
        return sum(state.summary.jump > 1.0 for state in self.states)


def solved(case: Case) -> Worn:
    """Run a case with wear."""
    began = time.process_time()
    return Worn(list(run(case)), time.process_time() - began)


def sphere(points: int, size: float, friction: float, stages: list[Any], shift: Shift = CENTRED) -> Case:
    """Return the sphere on a grid of `size` (mm) with its middle at `shift` (cells) under a load path."""
    center = [part * size / points for part in shift]
    return Case.model_validate(
        {
            "bodies": ["rigid", {"young_modulus": MODULUS, "poisson_ratio": 0.0}],
            "surface": {"sphere": {"radius": RADIUS}},
            "grid": {"points": points, "size": size, "center": center},
            "coupling": "none",
            "friction": friction,
            "wear": {"law": "energy", "alpha": ALPHA},
            "load_path": stages,
            "output": {"every": 10**6, "fields": ["pressure", "wear_depth"]},
        }
    )


def partial_slip(held: str, time_: float, points: int, jumps: int = 0, shift: Shift = CENTRED) -> Case:
    """Return partial slip with c/a0 = 0.5 and P or d held; jumps: equal ones, 0 for automatic ones."""
    return slipping_outside(0.5, held, time_, points, PARTIAL_SIZES[held, time_] * A0, jumps, shift)


def slipping_outside(c: float, held: str, time_: float, points: int, size: float, jumps: int, shift: Shift) -> Case:
    """Return partial slip outside of the radius c (over a0), with P or d held, on a grid of `size` (mm)."""
    cycles = round(time_ / (4.0 * ALPHA * FRICTION**2 * MODULUS * A0 / RADIUS))
    press = {"P": P0} if held == "P" else {"delta_z": D0}
    name, most = ("Qx", most_force(c)) if held == "P" else ("delta_x", most_displacement(c))
    path = [press, {name: most, "increments": 4}, _cycle(name, most, cycles, jumps)]
    return sphere(points, size, FRICTION, path, shift)


def most_force(c: float) -> float:
    return FRICTION * P0 * (1.0 - c**3)


def most_displacement(c: float) -> float:
    return FRICTION * D0 * (1.0 - c**2)


def gross_slip(time_: float, points: int) -> Case:
    """Return gross slip under P; the path of slip in a cycle is 4 (delta_x - mu d0) in the mean."""
    mu, most = 0.01, 0.01
    cycles = round(time_ * V0 / (ALPHA * mu * P0 * 4.0 * most))
    return sphere(
        points,
        GROSS_SIZES[time_] * A0,
        mu,
        [{"P": P0}, {"delta_x": most, "increments": 1}, _cycle("delta_x", most, cycles, 0)],
    )


def _cycle(name: str, most: float, cycles: int, jumps: int) -> dict[str, Any]:
    stages = [{name: -most, "increments": 2}, {name: most, "increments": 2}]
    return {
        "cycle": {
            "represents": cycles,
            "jump": -(-cycles // jumps) if jumps else "auto",
            "tolerance": 0.01,
            "stages": stages,
        }
    }


def base_case(points: int) -> Worn:
    """Run steel on steel, nu = 0.3, P = 400 N, Q = 36 N, over 75555 cycles."""
    steel = {"young_modulus": 200e3, "poisson_ratio": 0.3}
    cycle = {"represents": 75555, "stages": [{"Qx": -36.0, "increments": 2}, {"Qx": 36.0, "increments": 2}]}
    case = {
        "bodies": [steel, steel],
        "surface": {"sphere": {"radius": RADIUS}},
        "grid": {"points": points, "size": 0.8},
        "friction": 0.1,
        "wear": {"law": "energy", "alpha": ALPHA},
        "load_path": [{"P": 400.0}, {"Qx": 36.0}, {"cycle": cycle}],
        "output": {"every": 10**6},
    }
    return solved(Case.model_validate(case))


PARTIAL: dict[tuple[str, float], tuple[float, float]] = {
    ("P", 0.1): (0.01182, 1.00321),
    ("P", 1.0): (0.13139, 1.03158),
    ("P", 10.0): (1.834, 1.306),
    ("d", 0.1): (0.01175, 0.99524),
    ("d", 1.0): (0.12334, 0.95361),
    ("d", 10.0): (0.913, 0.7047),
}
"""V/V0, and d/d0 where P is held, P/P0 where d is held, by rings; c/a0 = 0.5."""

GROSS: dict[float, tuple[float, float, float]] = {
    1.0: (1.1538, 1.2135, 0.31907),
    10.0: (1.9799, 1.8385, 1.5010),
    100.0: (5.2272, 3.1804, 4.9587),
}
"""d/d0, a/a0 and the depth in the middle over d0, by rings."""

LIMIT_WIDTHS = (2.2, 2.26, 2.32, 2.38, 2.44, 2.5)
"""Sides of the grid over the radius of the scar."""

LIMIT_STICK = (0.2, 0.464159, 0.5, 0.8)
"""c/a0 of the worn limits that are reached by wear."""

LIMIT_TIME, LIMIT_JUMPS = 100.0, 10
"""T that reaches the limit, and the equal jumps to it, on which the limit does not depend."""

EDGE_SIZES = (3.3, 3.35, 3.4, 3.45, 3.5)
"""Sides of the grid over a0, on which the edge of the stick zone cuts the cells each time elsewhere."""

SHIFTS: tuple[Shift, ...] = ((0.31, 0.17), (0.02, 0.12), (0.03, 0.22), (0.37, 0.26))
"""Other places of the grid's middle, in cells, drawn at random before any of them was tried. All are shown."""

POINTS = 128
"""Of a side, where one grid is shown."""


def partial() -> None:
    """Print partial slip against rings."""
    columns = "held | T | V/V0, d/d0 or P/P0: rings | V | V, shifted: mean, rms | d or P | d or P, shifted | jumps"
    print(f"| {columns} | c/a0 (0.5) |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for (held, time_), known in PARTIAL.items():
        centred = solved(partial_slip(held, time_, POINTS))
        shifted = [solved(partial_slip(held, time_, POINTS, shift=shift)) for shift in SHIFTS]
        errors = np.array([_errors(one, held, *known) for one in (centred, *shifted)]).T
        volume, other = (f"{one[0]:+.2%} | {_mean_and_rms(one[1:])}" for one in errors)
        stick = centred.last.summary.stick_radius / A0
        print(
            f"| {held} | {time_:g} | {known[0]:g}, {known[1]:g} | {volume} | {other} | {centred.jumps} | {stick:.4f} |",
            flush=True,
        )


def _errors(one: Worn, held: str, volume: float, other: float) -> tuple[float, float]:
    """Return the relative errors of V/V0, and of d/d0 or P/P0 if `held` is the other one."""
    row = one.last.summary
    return one.volume / volume - 1.0, (row.delta_z / D0 if held == "P" else row.P / P0) / other - 1.0


def _mean_and_rms(errors: FloatArray) -> str:
    return f"{errors.mean():+.2%}, {np.sqrt(np.mean(errors**2)):.2%}"


def base() -> None:
    """Print the base case."""
    modulus = 200e3 / (2.0 * (1.0 - 0.3**2))
    contact_radius = (0.75 * 400.0 * RADIUS / modulus) ** (1.0 / 3.0)
    volume = np.pi * contact_radius**4 / (4.0 * RADIUS)
    print("| solver | V/V0 | delta_z, um | estimated error of V |")
    print("| --- | --- | --- | --- |")
    print("| rings | 0.19248 | 9.4646 | |")
    print("| cells, small jumps | 0.1924 | 9.464 | |")
    for points in (64, 128):
        row = base_case(points).last.summary
        error = row.wear_error / row.wear_volume
        print(f"| {points} x {points} | {row.wear_volume / volume:.5f} | {1e3 * row.delta_z:.4f} | {error:.1%} |")


def gross() -> None:
    """Print gross slip against rings."""
    print("| T | d/d0, a/a0, w0/d0: rings | 65 x 65 | 129 x 129 | V/V0 | jumps |")
    print("| --- | --- | --- | --- | --- | --- |")
    for time_, known in GROSS.items():
        texts = []
        for points in (65, 129):
            one = solved(gross_slip(time_, points))
            row, middle = one.last.summary, one.last.fields.wear_depth
            assert middle is not None
            values = row.delta_z / D0, row.contact_radius / A0, middle[points // 2, points // 2] / D0
            texts.append(", ".join(f"{value:.4f}" for value in values))
        print(f"| {time_:g} | {', '.join(map(str, known))} | {' | '.join(texts)} | {one.volume:.4f} | {one.jumps} |")


def jumps() -> None:
    """Print the error of the worn volume against the number of equal jumps, and its estimate."""
    print("| T | jumps | error of V | estimated |")
    print("| --- | --- | --- | --- |")
    for time_, counts in ((1.0, (5, 10, 20, 40)), (10.0, (20, 40, 80))):
        exact = solved(partial_slip("P", time_, 64, 4 * counts[-1])).volume
        for count in counts:
            one = solved(partial_slip("P", time_, 64, count))
            estimated = one.last.summary.wear_error / one.last.summary.wear_volume
            print(f"| {time_:g} | {count} | {one.volume / exact - 1.0:+.1e} | {estimated:.1e} |")


def costs() -> None:
    """Print processor times of 10^5 cycles and more."""
    print("| scene | cells | cycles | jumps | increments | processor time, s |")
    print("| --- | --- | --- | --- | --- | --- |")
    solved(partial_slip("P", 0.1, 64))  # compiles
    for points in (64, 128):
        for name, case in (
            ("partial slip, T = 10", partial_slip("P", 10.0, points)),
            ("gross slip, T = 10", gross_slip(10.0, points)),
        ):
            one = solved(case)
            cycles = f"{one.last.summary.cycles:.3g}"
            print(f"| {name} | {points} x {points} | {cycles} | {one.jumps} | {len(one.states)} | {one.seconds:.1f} |")


def limit() -> None:
    """Print the errors of the worn limit of partial slip, given as a height map and pressed."""
    exact = worn_limit_at_force(P0, most_force(0.5), FRICTION, RADIUS, MODULUS)
    print("| cells | force | approach | scar radius |")
    print("| --- | --- | --- | --- |")
    with tempfile.TemporaryDirectory() as folder:
        for points in (32, 64, 128, 256):
            found = [_limit_errors(exact, points, width * exact.scar_radius, Path(folder)) for width in LIMIT_WIDTHS]
            errors = np.sqrt(np.mean(np.square(found), axis=0))
            print(f"| {points} x {points} | {' | '.join(f'{error:.1e}' for error in errors)} |")


def _limit_errors(exact: WornLimit, points: int, size: float, folder: Path) -> list[float]:
    """Return the relative errors of force, approach and scar radius on a grid of this size (mm)."""
    x = (np.arange(points) - 0.5 * (points - 1)) * size / points
    r = np.hypot(x[:, None], x)
    np.save(folder / "limit.npy", exact.profile(r))
    case = {
        "bodies": ["rigid", {"young_modulus": MODULUS, "poisson_ratio": 0.0}],
        "surface": {"heights": {"file": str(folder / "limit.npy"), "spacing": size / points}},
        "grid": {"points": points, "size": size},
        "friction": 0.0,
        "output": {"fields": ["gap"]},
    }
    pressed, loaded = (
        list(run(Case.model_validate(case | {"load_path": [load]})))[-1]
        for load in ({"delta_z": exact.delta_z}, {"P": P0})
    )
    outside = (r > exact.scar_radius) & (r < 1.08 * exact.scar_radius)
    begins = np.polynomial.Polynomial.fit(pressed.fields.gap[outside], r[outside], 2)(0.0)
    return [
        pressed.summary.P / P0 - 1.0,
        loaded.summary.delta_z / exact.delta_z - 1.0,
        float(begins) / exact.scar_radius - 1.0,
    ]


def reached() -> None:
    """Print the errors of the worn limits of partial slip, reached by wear."""
    print("| held | c/a0 | limit: V/V0, d/d0 or P/P0 | V: mean, rms | V, shifted | d or P | d or P, shifted |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for held in ("P", "d"):
        for c in LIMIT_STICK:
            exact = _limit_reached(held, c)
            volume, other = exact.volume / V0, exact.delta_z / D0 if held == "P" else exact.load / P0
            begin = f"| {held} | {c:.4g} | {volume:.5f}, {other:.5f}"
            errors = []
            for shifts in ([CENTRED] * len(LIMIT_WIDTHS), itertools.cycle(SHIFTS)):
                places = [
                    (width * exact.scar_radius, shift) for width, shift in zip(LIMIT_WIDTHS, shifts, strict=False)
                ]
                cases = (
                    slipping_outside(c, held, LIMIT_TIME, POINTS, size, LIMIT_JUMPS, shift) for size, shift in places
                )
                errors.append([_errors(solved(case), held, volume, other) for case in cases])
            texts = [_mean_and_rms(one) for each in np.array(errors).T.swapaxes(1, 2) for one in each]
            print(f"{begin} | {' | '.join(texts)} |", flush=True)


def stick_edge() -> None:
    """Print how the worn volume depends on where the edge of the stick zone cuts the cells, P held."""
    known = PARTIAL["P", 10.0][0]
    print("| cells | middle, in cells | mean | root mean square | worst |")
    print("| --- | --- | --- | --- | --- |")
    for points in (32, 64, 128):
        shifted = []
        for shift in (CENTRED, *SHIFTS):
            cases = (slipping_outside(0.5, "P", 10.0, points, size * A0, 40, shift) for size in EDGE_SIZES)
            errors = np.array([solved(case).volume for case in cases]) / known - 1.0
            print(f"| {points} x {points} | {shift[0]:g}, {shift[1]:g} | {_summary(errors)} |", flush=True)
            if shift != CENTRED:
                shifted.append(errors)
        print(f"| {points} x {points} | all four shifted | {_summary(np.ravel(shifted))} |", flush=True)


def _summary(errors: FloatArray) -> str:
    worst = errors[np.abs(errors).argmax()]
    return f"{errors.mean():+.2%} | {np.sqrt(np.mean(errors**2)):.2%} | {worst:+.2%}"


def _limit_reached(held: str, c: float) -> WornLimit:
    if held == "P":
        return worn_limit_at_force(P0, most_force(c), FRICTION, RADIUS, MODULUS)
    return worn_limit_at_displacement(D0, most_displacement(c), FRICTION, RADIUS, MODULUS, 4.0 / MODULUS)


def main() -> None:
    """Print the tables, or put them into a page."""
    page = parser_of(__doc__).parse_args().into
    parts = {
        "limit": limit,
        "limit reached": reached,
        "partial slip": partial,
        "stick edge": stick_edge,
        "base case": base,
        "gross slip": gross,
        "jumps": jumps,
        "costs": costs,
    }
    report({f"wear {name}": part for name, part in parts.items()}, page)


if __name__ == "__main__":
    main()
