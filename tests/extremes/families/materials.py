"""Elastic constants at their ends, and lengths, forces and stresses over many decades."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from solving import DISSIMILAR, LOAD, RADIUS

from fretsolve.errors import CaseError, FretsolveError

from .driving import Family, Parts, Probe, Run, by, led
from .limits import again, case_of, like, of_hertz, of_mindlin, off, worst
from .pairs import FLAT_RIGID, elastic

HALF = [{"P": LOAD, "increments": 3}, {"Qx": 0.05 * LOAD, "increments": 2}]


def mirrored(run: Run) -> float:
    """Against the bodies swapped: the same pressure turned by 180 degrees, and the same approach."""
    other = again(run, bodies=run.parts["bodies"][::-1])
    turned = other.last.fields.pressure[::-1, ::-1]
    miss = float(np.abs(run.last.fields.pressure - turned).max()) / run.end.max_pressure
    return max(miss, off(run.end.delta_z, other.end.delta_z), off(run.end.delta_x, other.end.delta_x))


def scaled(length: float, stress: float) -> Parts:
    """A case with moments, dissimilar bodies and every kind of load, in other units."""
    force, moment = stress * length**2, stress * length**3
    return {
        "bodies": [body | {"young_modulus": body["young_modulus"] * stress} for body in DISSIMILAR],
        "surface": {"sphere": {"radius": RADIUS * length}},
        "load_path": [
            {"P": LOAD * force, "My": 5.0 * moment, "increments": 2},
            {"Qx": 20.0 * force, "Mz": 2.0 * moment, "increments": 2},
            {"delta_x": -1e-3 * length, "increments": 2},
        ],
        # Leaves nothing to single precision, whose rounding differs from units to units.
        "solver": {"tolerance": 1e-10},
    }


def as_at_scale_one(length: float, stress: float) -> Callable[[Run], float]:
    """Every scalar in units of the scale."""
    force, moment = stress * length**2, stress * length**3
    factors = {"P": force, "Qx": force, "Mz": moment, "work_total": moment, "max_pressure": stress, "max_shear": stress}
    factors |= {"delta_z": length, "delta_x": length, "phi_z": 1.0, "phi_y": 1.0, "contact_area": length**2}
    return like(tuple(factors), case_of(**scaled(1.0, 1.0)), **factors)


def as_other_load(run: Run) -> float:
    """Hertz's contact grows with P^(1/3) on the cells that `auto` gives it: the result scales digit by digit."""
    ratio = run.end.P / LOAD
    other = case_of(**{**run.parts, "load_path": [{"P": LOAD}]})
    return like(
        ("delta_z", "max_pressure", "contact_radius"),
        other,
        delta_z=ratio ** (2 / 3),
        max_pressure=ratio ** (1 / 3),
        contact_radius=ratio ** (1 / 3),
    )(run)


DUNDURS = Family(
    "Dundurs' constant at its ends",
    "+-1/2, friction 0.1 to 10, Q = mu P/2",
    "bodies swapped: the mirror image",
    tuple(
        Probe(
            f"friction {mu:g}",
            led(
                by(5, P=LOAD),
                by(5, Qx=0.5 * mu * LOAD),
                points=32,
                size=1.5 if mu == 10.0 else 1.1,
                bodies=FLAT_RIGID,
                friction=mu,
            ),
            mirrored,
            1e-4,
            quick=mu in (0.3, 2.0),
        )
        for mu in (0.1, 0.3, 0.5, 1.0, 2.0, 5.0, 10.0)
    ),
)

POISSON = Family(
    "Poisson's ratio at its ends, equal bodies",
    "nu 0.5, 0, -0.9, -0.999999; friction 0.1, 10",
    "Hertz, Mindlin; the coupling vanishes",
    tuple(
        Probe(
            f"nu {nu:g} friction {mu:g}",
            led({"P": LOAD}, by(2, Qx=0.5 * mu * LOAD), bodies=[elastic(nu)] * 2, friction=mu, coupling="none"),
            worst(of_hertz, of_mindlin),
            0.01,
            quick=mu == 0.1,
        )
        for nu in (0.5, 0.0, -0.9, -0.999999)
        for mu in (0.1, 10.0)
    ),
)

POISSON_PAIRS = Family(
    "Poisson's ratio at its ends, dissimilar bodies",
    "nu 0.5, 0, -0.9, -0.999999, rigid; friction 0.1, 1",
    "bodies swapped: the mirror image",
    tuple(
        Probe(
            f"{one} on {other} friction {mu:g}",
            led(
                by(3, P=LOAD),
                by(2, Qx=0.5 * mu * LOAD),
                bodies=[body if isinstance(body, str) else elastic(body) for body in (one, other)],
                friction=mu,
            ),
            mirrored,
            1e-4,
            quick=mu == 1.0 and one != 0.0,
        )
        for one, other in ((0.5, 0.0), (-0.9, 0.5), (0.5, -0.999999), ("rigid", -0.9), (0.0, -0.9), ("rigid", 0.5))
        for mu in (0.1, 1.0)
    ),
)

STIFFNESS = Family(
    "ratio of the moduli",
    "1e-12 to 1e12",
    "a rigid body",
    tuple(
        Probe(
            f"E1/E2 {ratio:g}",
            led(load_path=HALF, bodies=[elastic(0.3, 200e3 * max(ratio, 1.0)), elastic(0.3, 200e3 / min(ratio, 1.0))]),
            like(
                ("delta_z", "delta_x", "max_pressure", "stick_radius"),
                case_of(bodies=["rigid", elastic(0.3)] if ratio > 1.0 else [elastic(0.3), "rigid"], load_path=HALF),
            ),
            1e-4 + 2.0 * min(ratio, 1.0 / ratio),
            quick=ratio in (1e-12, 1e12),
        )
        for ratio in (1e-12, 1e-6, 1e-3, 1e3, 1e6, 1e12)
    ),
)

BOTH_RIGID = Family(
    "two rigid bodies",
    "",
    "exit 2",
    (
        Probe(
            "rigid on rigid", {"bodies": ["rigid", "rigid"]}, refused=CaseError, says="both bodies are rigid.*elastic"
        ),
    ),
)

UNITS = Family(
    "units",
    "lengths 1e-15 to 1e12 (1e-6: nm, 1e6: km), stresses 1e-15 to 1e30",
    "the same digits",
    tuple(
        Probe(
            f"length {length:g} stress {stress:g}",
            scaled(length, stress),
            as_at_scale_one(length, stress),
            1e-9,
            quick=length in (1e-6, 1e6),
        )
        for length, stress in (
            (1e-15, 1e30),
            (1e-9, 1.0),
            (1e-9, 1e9),
            (1e-6, 1.0),
            (1e-3, 1e6),
            (1e3, 1e-6),
            (1e6, 1.0),
            (1e9, 1e-9),
            (1e12, 1e-15),
        )
    ),
)


def elliptic(length: float) -> Parts:
    """An ellipsoid on a grid that is sized by trial."""
    return led({"P": length**2}, points=24, surface={"ellipsoid": {"radius_x": 3.0 * length, "radius_y": 5.0 * length}})


SIZED = Family(
    "units, sized by trial",
    "lengths 1e-6 to 1e6",
    "the same digits",
    tuple(
        Probe(
            f"length {length:g}",
            elliptic(length),
            like(("delta_z", "max_pressure"), case_of(**elliptic(1.0)), delta_z=length),
            1e-9,
            quick=length == 1e-6,
        )
        for length in (1e-6, 10.0, 1e6)
    ),
)

LOADS = Family(
    "normal force",
    "P 1e-15 to 1e12 N on 10 mm",
    "Hertz's P^(1/3), the same digits",
    tuple(
        Probe(
            f"P {load:g}",
            led({"P": load}),
            worst(as_other_load, lambda run: 1e-7 * of_hertz(run)),
            1e-9,
            quick=load in (1e-15, 1e12),
        )
        for load in (1e-15, 1e-9, 1e-3, 1e3, 1e6, 1e12)
    ),
)

ABSURD = Family(
    "numbers beyond physics",
    "1e-300 to 1e308 for E, P, R, size, displacements, friction",
    "exit 2, with what is possible",
    tuple(
        Probe(
            name,
            parts,
            refused=FretsolveError,
            says="between 1e-40 and 1e\\+40 .* is needed|reaches the edge|finds no contact",
            quick=quick,
        )
        for name, parts, quick in (
            ("E 1e-300", {"bodies": [elastic(0.3), elastic(0.3, 1e-300)]}, True),
            ("E 1e300", {"bodies": [elastic(0.3, 1e300), elastic(0.3)]}, True),
            ("P 1e308", led({"P": 1e308}), True),
            ("P 1e-300", led({"P": 1e-300}), False),
            ("P 1e-100", led({"P": 1e-100}), True),
            ("R 1e300", {"surface": {"sphere": {"radius": 1e300}}}, True),
            ("R 1e-300", {"surface": {"sphere": {"radius": 1e-300}}}, False),
            ("size 1e-200", {"grid": {"points": 24, "size": 1e-200}}, False),
            ("size 1e200", {"grid": {"points": 24, "size": 1e200}}, True),
            ("center 1e300", {"grid": {"points": 24, "size": 1.0, "center": [1e300, 0.0]}}, False),
            ("delta_x 1e308", led({"P": LOAD}, {"delta_x": 1e308}), True),
            ("delta_z 1e300", led({"delta_z": 1e300}, points=24, size=1.0), False),
            ("phi_x 1e300", led({"P": LOAD, "phi_x": 1e300}, points=24, size=1.0), True),
        )
    ),
)

NOTHING = 1e-60
AT_REST: Parts = led({"P": LOAD}, points=32, size=0.75)

TINY_PARTS: dict[str, Parts] = {
    **{name: led({"P": LOAD, name: NOTHING}) for name in ("Qx", "delta_x", "My", "phi_x", "Mz")},
    "angle": {"surface": {"ellipsoid": {"radius_x": 10.0, "radius_y": 10.0, "angle": NOTHING}}},
    "center": {"surface": {"sphere": {"radius": 10.0, "center": [NOTHING, 0.0]}}},
    "friction": {"friction": NOTHING},
}

NEXT_TO_NOTHING = Family(
    "almost nothing instead of 0",
    "Qx, delta_x, My, phi_x, Mz, angle, center, friction of 1e-60",
    "those of 0",
    tuple(
        Probe(
            name,
            AT_REST | parts,
            like(("delta_z", "max_pressure"), case_of(**AT_REST)),
            1e-5,
            quick=name in ("Qx", "angle"),
        )
        for name, parts in TINY_PARTS.items()
    ),
)

FAMILIES = (DUNDURS, POISSON, POISSON_PAIRS, STIFFNESS, BOTH_RIGID, UNITS, SIZED, LOADS, ABSURD, NEXT_TO_NOTHING)
