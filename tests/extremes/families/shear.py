"""A shear force from next to nothing to gross slip, and torques, and both at once along the limit surface."""

from __future__ import annotations

import math
from functools import cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from solving import DISSIMILAR, FRICTION, LOAD, SIMILAR

from fretsolve.contact.solvers.rigid_modes import TangentialModes, load_factor
from fretsolve.errors import SlidingError
from fretsolve.problem.model.load_control import LoadControl

from .driving import Family, Parts, Probe, Run, by, led, solve_parts
from .limits import (
    again,
    cattaneo_cells,
    lubkin_cells,
    of_dissipation,
    of_lubkin,
    of_mindlin,
    of_sliding,
    of_stick_compliance,
    off,
    worst,
)
from .pairs import BODIES, FLAT_RIGID

LIMIT = FRICTION * LOAD


def sheared(share: float, increments: int = 3, **parts: object) -> Parts:
    """Pressed, then sheared by a share of mu P."""
    return led(by(2, P=LOAD), by(increments, Qx=share * LIMIT)) | parts


def transverse_growth(run: Run) -> float:
    """delta_x against that at a hundred times the distance from mu P, times ten.

    While everything slides the slip is delta_x along the load and the elastic uy across it, so a part of about
    <uy^2>/2 delta_x^2 of mu P is lost: delta_x grows like (1 - Q/mu P)^(-1/2), but for terms of the order of 1.
    """
    nearer = 1.0 - run.end.Qx / LIMIT
    farther = again(run, load_path=sheared(1.0 - 100.0 * nearer)["load_path"]).end.delta_x
    return off(run.end.delta_x, 10.0 * farther)


@cache
def capacity(load: tuple[float, float, float], points: int = 32) -> float:
    """Factor on Qx, Qy, Mz at which the frictional contact on so many cells slides, by limit analysis."""
    with TemporaryDirectory() as folder:
        found = solve_parts(led(points=points, friction=0.0), Path(folder))
    pressure = FRICTION * found.last.fields.pressure
    return load_factor(pressure, LoadControl((True, True, True), load), TangentialModes(found.setup.grid))


def combined(angle: float, share: float) -> Parts:
    """Qx, Qy, Mz at `angle` (degrees) between force and torque, to a share of what is carried."""
    force, torque = LIMIT * math.cos(math.radians(angle)), 7.0 * math.sin(math.radians(angle))
    direction = (0.8 * force, 0.6 * force, torque)
    loads = share * capacity(direction) * np.array(direction)
    stage = dict(zip(("Qx", "Qy", "Mz"), map(float, loads), strict=True))
    nearly = {name: 0.99 * value for name, value in stage.items()}
    return led({"P": LOAD}, nearly | {"increments": 2}, stage | {"increments": 1})


def twisted(share: float, limit: float) -> Parts:
    """Pressed, then twisted by a share of the limit, free to move sideways."""
    return led({"P": LOAD}, by(2, Mz=share * limit, Qx=0.0, Qy=0.0))


SMALL = Family(
    "mode I, small force",
    "Q/mu P 1e-12 to 1e-3, friction 0.1 to 1e6",
    "Mindlin's compliance S/8a",
    tuple(
        Probe(
            f"Q/mu P {share:g} friction {mu:g}",
            led({"P": LOAD}, by(2, Qx=share * mu * LOAD), friction=mu),
            of_stick_compliance,
            0.01,  # a cell at the edge
            quick=share != 1e-6 and mu != 10.0,
        )
        for share in (1e-12, 1e-6, 1e-3)
        for mu in (0.1, 10.0, 1e6)
    ),
)

CATTANEO = Family(
    "mode I, partial slip",
    "Q/mu P 0.1 to 1 - 1e-8, without in-plane coupling",
    "Mindlin's delta_x, c within a cell",
    tuple(
        Probe(
            f"Q/mu P 1 - {1.0 - share:.0e}",
            sheared(share, coupling="none"),
            worst(of_mindlin, lambda run: 0.01 * cattaneo_cells(run)),
            0.012,  # at least four cells stick about the centre, 1.13 cells' radius
            quick=share in (0.5, 0.999, 1.0 - 1e-6),
        )
        for share in (0.1, 0.5, 0.9, 0.99, 0.999, 1.0 - 1e-4, 1.0 - 1e-6, 1.0 - 1e-8)
    ),
)

TRANSVERSE = Family(
    "mode I, near mu P, all terms",
    "Q/mu P 1 - 1e-6 to 1 - 2e-9",
    "delta_x grows like (1 - Q/mu P)^-1/2",
    tuple(
        Probe(f"Q/mu P 1 - {gap:.0e}", sheared(1.0 - gap), transverse_growth, 600.0 * math.sqrt(gap), quick=gap == 1e-8)
        for gap in (1e-6, 1e-7, 1e-8, 2e-9)
    ),
)

AT_THE_LIMIT = Family(
    "mode I, at mu P and beyond",
    "Q/mu P 1 - 1e-10 to 1e6",
    "gross slip: exit 3",
    tuple(
        Probe(
            f"{name} Q/mu P {share!r}",
            sheared(share, bodies=bodies),
            refused=SlidingError,
            says="mu P = 40 N.*delta_x",
            quick=share in (1.0 - 1e-10, 1e6),
        )
        for name, bodies in BODIES.items()
        for share in (1.0 - 1e-10, 1.0 - 1e-12, 1.0, 1.0 + 1e-12, 2.0, 1e6)
    ),
)

DRAGGED = Family(
    "gross slip by delta_x",
    "delta_x 0.1 to 1e9 mm, mu |beta| 0 to 5",
    "|q| = mu p, Q = mu P",
    tuple(
        Probe(
            f"{name} friction {mu:g} delta_x {motion:g}",
            led(
                by(2, P=LOAD),
                by(2, delta_x=motion),
                points=40,
                size=3.0 if bodies == FLAT_RIGID and mu == 10.0 else 1.2,
                bodies=bodies,
                friction=mu,
            ),
            of_sliding,
            1e-5 if motion > 0.5 else 1e-3,
            quick=motion == 1.0 or (motion == 1e9 and mu == 0.1),
        )
        for name, bodies, mu in (
            ("equal", SIMILAR, 0.1),
            ("unlike", DISSIMILAR, 0.1),
            ("unlike", DISSIMILAR, 5.0),
            ("unlike", DISSIMILAR, 10.0),
            ("rigid on nu 0", FLAT_RIGID, 1.0),
            ("rigid on nu 0", FLAT_RIGID, 10.0),
        )
        for motion in (1.0, 1e3, 1e6, 1e9)
    ),
)

SHAKEN = Family(
    "partial slip at large friction",
    "Q = mu P/2 and torque, mu |beta| 0.2 to 5",
    "certified; a solution exists for every mu",
    tuple(
        Probe(
            f"{name} friction {mu:g} {load}",
            led(by(5, P=LOAD), stage | {"increments": 5}, points=40, size=1.2, bodies=bodies, friction=mu),
            quick=mu in (1.0, 10.0) and load == "Q",
        )
        for name, bodies in (("unlike", DISSIMILAR), ("rigid on nu 0", FLAT_RIGID))
        for mu in (1.0, 2.0, 3.0, 5.0, 10.0)
        for load, stage in (("Q", {"Qx": 0.5 * mu * LOAD}), ("Mz", {"Mz": 0.08 * mu * LOAD}))
    ),
)

LUBKIN = Family(
    "mode III, torque",
    "Mz over that of gross slip 1e-12 to 0.999",
    "Lubkin's phi_z, c within a cell",
    tuple(
        Probe(
            f"share {share:g}",
            twisted(share, 3.0 * math.pi / 16.0 * LIMIT * 0.301107),
            worst(of_lubkin, lambda run: 0.02 * lubkin_cells(run)),
            0.02,  # a cell at the edge, of which the compliance is the third power
            quick=share in (1e-12, 0.5, 0.99),
        )
        for share in (1e-12, 1e-6, 1e-3, 0.5, 0.9, 0.99)
    ),
)


def near_limit(share: float) -> Parts:
    """A torque next to the one at which everything slides on these cells."""
    return twisted(share, capacity((0.0, 0.0, 1.0)))


TORQUE_LIMIT = Family(
    "mode III, near gross slip",
    "Mz over the limit 1 - 1e-6 to 1 - 1e-8 and 1 - 1e-12 to 2",
    "Lubkin's limit: certified below, exit 3 from there on",
    (
        *(
            Probe(f"share 1 - {gap:g}", partial(near_limit, 1.0 - gap), lambda run: off(run.end.Mz, 7.094667), 1e-3)
            for gap in (1e-4, 1e-6, 1e-8)
        ),
        *(
            Probe(f"share {share!r}", partial(near_limit, share), refused=SlidingError, says="Mz = .*phi_z")
            for share in (1.0 - 1e-12, 1.0, 1.01, 2.0)
        ),
    ),
)

LIMIT_SURFACE = Family(
    "Q and Mz along the limit surface",
    "0 to 90 degrees from force to torque, 1 - 1e-4 to 1 - 1e-8 of the limit",
    "power of the loads = sum mu p |v| (normality)",
    tuple(
        Probe(
            f"{angle:g} deg 1 - {gap:g}",
            partial(combined, angle, 1.0 - gap),
            of_dissipation,
            10.0 * gap,
            quick=gap == 1e-8 and angle in (5.0, 45.0, 60.0),
        )
        for angle in (5.0, 30.0, 45.0, 60.0, 75.0, 85.0)
        for gap in (1e-4, 1e-6, 1e-8)
    ),
)

FAMILIES = (SMALL, CATTANEO, TRANSVERSE, AT_THE_LIMIT, DRAGGED, SHAKEN, LUBKIN, TORQUE_LIMIT, LIMIT_SURFACE)
