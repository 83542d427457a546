"""Unloading to nothing and reloading, contact lost on one side, and loads that no contact can carry."""

from __future__ import annotations

import numpy as np
from solving import DISSIMILAR, LOAD, RADIUS

from fretsolve.errors import (
    CaseError,
    ContactLostError,
    GridEdgeError,
    NoSolutionError,
    NotConvergedError,
    SlidingError,
)

from .driving import Family, Parts, Probe, Run, by, led
from .limits import hertz, off
from .pairs import BODIES, elastic

PUNCH = {"punch": {"radius": 0.3, "edge_radius": 0.05}}
WIDE = {"points": 36, "size": 1.5}


def unloaded(part: float, *between: Parts) -> list[Parts]:
    """Up, `between`, down to a part of P, up again."""
    return [{"P": LOAD, "increments": 3}, *between, {"P": part * LOAD, "increments": 5}, {"P": LOAD, "increments": 5}]


def pressure_as_before(run: Run) -> float:
    """Pressure against that of the first time at this load, over its peak."""
    first = next(state for state in run.states if abs(state.summary.P / LOAD - 1.0) < 1e-6)
    return float(np.abs(run.last.fields.pressure - first.fields.pressure).max()) / run.end.max_pressure


def of_hertz_aside(run: Run) -> float:
    """A moment P x0 moves the paraboloid's contact by x0 and tilts it by x0/R."""
    arm = run.end.My / run.end.P
    exact = hertz(run)
    return max(
        off(run.end.phi_y, arm / RADIUS),
        off(run.end.delta_z, exact.delta_z - arm**2 / (2.0 * RADIUS)),
        off(run.end.max_pressure, exact.max_pressure),
    )


def one_side_open(run: Run) -> float:
    """Pressure at x < -a/2 of the punch over the largest: none, as the moment has lifted that side off."""
    far = run.setup.grid.x < -0.15
    return float(run.last.fields.pressure[far].max()) / run.end.max_pressure


UNLOADING = Family(
    "unloading and reloading",
    "P to 1e-3 ... 1e-14 of itself and to 0",
    "the first loading's pressure; at 1e-14 rounding may be named",
    tuple(
        Probe(
            f"{name} to {part:g}{kind}",
            led(points=24, load_path=unloaded(part, *between), bodies=bodies),
            pressure_as_before,
            1e-5 if name == "equal" else 0.05,
            refused=NotConvergedError if part == 1e-14 else None,
            says="rounding",
            may_solve=True,
            quick=part in (0.0, 1e-12, 1e-14) and kind == "",
        )
        for name, bodies in BODIES.items()
        for part in (1e-3, 1e-6, 1e-9, 1e-12, 1e-14, 0.0)
        for kind, between in (
            ("", ({"Qx": 20.0, "increments": 2}, {"Qx": 0.0, "increments": 2})),
            (", delta_x held", ({"delta_x": 5e-4, "increments": 2},)),
            (", moments 0", ({"Mx": 0.0, "My": 0.0, "increments": 1},)),
        )
    ),
)

HELD_SHEAR = Family(
    "unloading with the shear force held",
    "P from 400 to 0 N at Qx = 20 N, mu P = 20 N at half",
    "exit 3 at mu P = Q",
    tuple(
        Probe(
            name,
            led(by(3, P=LOAD), by(2, Qx=20.0), by(5, P=0.0), points=24, bodies=bodies),
            refused=SlidingError,
            says="mu P = 16 N",
        )
        for name, bodies in BODIES.items()
    ),
)

TILTED = Family(
    "moment",
    "My/P 0 to 1.6 of the contact's radius",
    "Hertz's contact aside",
    tuple(
        Probe(
            f"My/P {arm:g} mm",
            led({"P": LOAD}, by(2, My=LOAD * arm), grid=WIDE),
            of_hertz_aside,
            allowed,
            quick=arm == 0.301107,
            resolved=arm != 1e-9,
        )
        # an arm smaller than a cell turns a contact of fixed cells, whose stiffness is a third power of the radius
        for arm, allowed in ((1e-9, 0.3), (0.1, 0.01), (0.29, 0.01), (0.301107, 0.01), (0.31, 0.01), (0.4, 0.01))
    ),
)

LIFTED = Family(
    "punch lifted on one side",
    "My/P 0.5 to 0.95 of the radius",
    "no pressure on the far side",
    (
        *(
            Probe(
                f"{name} My/P {arm:g} mm",
                led(by(2, P=LOAD), by(2, My=LOAD * arm), points=41, size=0.7, bodies=bodies, surface=PUNCH),
                one_side_open,
                0.0,
                quick=arm in (0.2, 0.29),
            )
            for name, bodies in BODIES.items()
            for arm in (0.2, 0.25, 0.28, 0.29)
        ),
        *(
            Probe(
                f"between two rows of cells at the punch's edge, arm {arm:g}",
                led(
                    {"P": 40.0},
                    {"Mx": -40.0 * arm},
                    points=[19, 23],
                    size=0.72,
                    bodies=[elastic(0.0, 1e6)] * 2,
                    friction=0.0,
                    surface={"punch": {"half_width": 0.3, "edge_radius": 0.05}},
                ),
                quick=arm == 0.265,
            )
            for arm in (0.26, 0.265, 0.27, 0.28)
        ),
    ),
)

CLEAR = "moment is imposed where delta_z lifts the body off"

TOPPLED = Family(
    "loads that no contact can carry",
    "My/P beyond the material, P < 0, moments without P",
    "exit 2 or 3",
    (
        *(
            Probe(
                f"{name} punch, My/P {arm:g} mm",
                led(by(2, P=LOAD), by(1, My=LOAD * arm), points=33, size=0.75, bodies=bodies, surface=PUNCH),
                refused=ContactLostError,
                says="My/P = .*no equilibrium",
            )
            for name, bodies in BODIES.items()
            for arm in (0.3, 10.0)
        ),
        Probe(
            "unlike punch unloaded with a moment held",
            led(
                by(3, P=LOAD),
                by(2, Mx=-0.2 * LOAD),
                by(7, P=0.0),
                points=25,
                size=0.75,
                bodies=DISSIMILAR,
                surface=PUNCH,
            ),
            refused=ContactLostError,
            says="Mx/P = .*no equilibrium",
        ),
        Probe("P < 0", led({"P": -1.0}), refused=CaseError, says="P: -1.* out of range.*>= 0"),
        Probe("P = 0, auto", led({"P": 0.0}), refused=CaseError, says="no contact"),
        Probe("P = 0", led({"P": 0.0}, grid=WIDE), lambda run: run.end.contact_area, 0.0),
        Probe("delta_z < 0", led({"delta_z": -1e-3}, grid=WIDE), lambda run: run.end.contact_area, 0.0),
        Probe("moment, P = 0", led({"P": 0.0, "My": 1.0}, grid=WIDE), refused=ContactLostError, says="moment at P = 0"),
        *(
            Probe(
                f"moment while delta_z lifts off{how}",
                led(points=25, size=0.75, load_path=stages, friction=0.0),
                refused=NoSolutionError,
                says=CLEAR,
                may_solve=True,
            )
            for how, stages in (
                ("", [{"P": 1.0}, {"Mx": 0.1, "delta_z": -1e-4, "increments": 1}]),
                (" first", [{"delta_z": -1e-4}, {"Mx": 0.1, "increments": 1}]),
                (" the other way", [{"P": LOAD}, {"My": 20.0}, {"delta_z": -6.6e-3, "My": -5.0, "increments": 1}]),
            )
        ),
        Probe(
            "shear force, pulled off",
            led({"P": LOAD}, {"Qx": 1.0}, by(2, delta_z=-1e-3), grid=WIDE),
            refused=SlidingError,
            says="none of it",
        ),
    ),
)

ON_THE_FLANK = Family(
    "cone under a moment",
    "My/P 0.5 to 3 of the contact's radius",
    "certified, or at the grid's edge",
    tuple(
        Probe(
            f"My/P {arm:g} a",
            led({"P": LOAD}, by(2, My=arm * LOAD * 0.6808), points=32, surface={"cone": {"angle": 0.005}}),
            refused=GridEdgeError,
            says="would do|more points|try size",
            may_solve=True,
            quick=arm == 3.0,
        )
        for arm in (0.5, 1.0, 2.0, 3.0)
    ),
)

RING = [{"sphere": {"radius": -20.0}}, PUNCH]

ON_FEW_CELLS = Family(
    "moments on contacts of few cells",
    "My/P 10 mm on a sphere of 10 mm, a cone, a ring",
    "certified, or at the grid's edge",
    (
        *(
            Probe(
                f"sphere, {name}, {increments} increments",
                led(by(5, P=LOAD), by(increments, My=10.0 * LOAD), bodies=bodies),
                quick=increments == 2,
            )
            for name, bodies in BODIES.items()
            for increments in (2, 10)
        ),
        Probe(
            "cone",
            led(
                {"P": 1.014},
                by(1, My=0.0162),
                points=[21, 16],
                bodies=[elastic(0.3, 1.39e7)] * 2,
                surface={"cone": {"angle": 0.0049}},
            ),
        ),
        Probe(
            "ring, unloaded",
            led({"P": 2.93}, by(3, Mx=-0.204), by(4, P=0.0), points=[22, 24], surface=RING),
            refused=NoSolutionError,
            says="reaches the edge|tilt",
        ),
    ),
)

SPUN = Family(
    "motion much larger than the elastic one",
    "friction 1e-8 to 0.1, delta_x or phi_z of 1e-3 to 0.2",
    "certified",
    tuple(
        Probe(
            f"{name} friction {mu:g} {how}",
            led(by(2, P=LOAD), *stages, points=24, bodies=bodies, friction=mu),
            quick=mu == 1e-8,
        )
        for name, bodies in BODIES.items()
        for mu in (1e-8, 1e-6, 1e-3, 0.1)
        for how, stages in (
            ("delta_x", ({"delta_x": 1e-3, "increments": 1},)),
            ("phi_z, delta_y", ({"phi_z": 0.2, "increments": 1}, {"delta_y": 1e-6, "increments": 1})),
        )
    ),
)

FAMILIES = (UNLOADING, HELD_SHEAR, TILTED, LIFTED, TOPPLED, ON_THE_FLANK, ON_FEW_CELLS, SPUN)
