"""Random cases with closed forms, for accuracies that no finer run is exact enough to judge.

Spheres, ellipsoids and cones of random sizes, moduli and loads, pressed, and spheres sheared, sheared back or twisted
by a random share of what friction carries; those that are sheared without the coupling of directions, which their
closed forms leave out. A case depends on its seed and its number alone.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from random import Random
from typing import Any

from calibration_cases import CalibrationCase
from calibration_truth import cone, elliptic, hertz, mindlin, torsion

from fretsolve.reference.hertz import hertz_sphere
from fretsolve.reference.tangential import gross_slip_torque

KINDS = ("sphere", "ellipsoid", "cone", "sheared", "sheared", "sheared back", "twisted", "twisted")


def random_closed_forms(seed: int, count: int) -> Iterator[CalibrationCase]:
    """Yield `count` cases."""
    for number in range(count):
        yield _draw(Random(f"closed {seed}-{number}"), f"closed {seed}-{number:02d}")


def _draw(random: Random, label: str) -> CalibrationCase:
    kind = random.choice(KINDS)
    radius = _log_uniform(random, 1.0, 50.0)
    load = float(f"{4.0 * radius**2 * random.uniform(0.5, 2.0):.4g}")
    body = {"young_modulus": _log_uniform(random, 3e3, 4e5), "poisson_ratio": round(random.uniform(0.0, 0.45), 2)}
    friction, share = _log_uniform(random, 0.02, 1.5), round(random.uniform(0.1, 0.97), 2)
    parts: dict[str, Any] = {"bodies": [body, body], "grid": {}, "friction": 0.0, "load_path": [{"P": load}]}
    match kind:
        case "sphere":
            parts["surface"] = {"sphere": {"radius": radius}}
            return CalibrationCase(f"{label} sphere", parts, partial(hertz, load=load, radius=radius))
        case "ellipsoid":
            other = float(f"{radius * _log_uniform(random, 1.2, 8.0):.4g}")
            parts["surface"] = {"ellipsoid": {"radius_x": radius, "radius_y": other}}
            return CalibrationCase(f"{label} ellipsoid", parts, elliptic(radius, other, load))
        case "cone":
            angle = round(random.uniform(0.01, 0.04), 4)
            parts["surface"] = {"cone": {"angle": angle}}
            return CalibrationCase(f"{label} cone", parts, cone(load, angle))
    parts |= {"surface": {"sphere": {"radius": radius}}, "friction": friction}
    words = f"{label} {kind}, friction {friction:g}, {share:g} of gross slip"
    if kind == "twisted":
        modulus = body["young_modulus"] / (2.0 * (1.0 - body["poisson_ratio"] ** 2))
        torque = share * gross_slip_torque(hertz_sphere(load, radius, modulus), friction)
        parts["load_path"] = [{"P": load}, {"Mz": torque}]
        return CalibrationCase(words, parts, torsion(share, friction, load, radius))
    force, back = share * friction * load, kind == "sheared back"
    forces = (force, 0.0, -force) if back else (force,)
    parts["coupling"] = "none"
    parts["load_path"] = [{"P": load}, *({"Qx": value} for value in forces)]
    return CalibrationCase(words, parts, mindlin(force, friction, back, load, radius))


def _log_uniform(random: Random, low: float, high: float) -> float:
    """Return a number between `low` and `high`, as likely in each decade, with three digits."""
    return float(f"{math.exp(random.uniform(math.log(low), math.log(high))):.3g}")
