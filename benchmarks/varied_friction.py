"""Compare friction that varies with closed forms and certified values, and time what it costs.

    python benchmarks/varied_friction.py                             # about 30 s
    python benchmarks/varied_friction.py --into docs/verification.md

A sphere of 10 mm, P = 400 N, friction 0.1, nu = 0.3, one increment under Qx from rest.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from helpers import parser_of, report

from fretsolve import run
from fretsolve.case.keys.body_specs import ElasticBody
from fretsolve.case.models import Case
from fretsolve.problem.model.materials import compliances
from fretsolve.reference.hertz import HertzContact, hertz_sphere
from fretsolve.result.state import Summary
from fretsolve.simulation.problem_setup import set_up

LOAD, RADIUS, SIZE = 400.0, 10.0, 0.9

UNITS = {"delta_x": "um", "delta_y": "um", "stick area": "mm^2", "dissipated energy": "uJ", "gross slip": "N"}

SHEAR_MODULUS = 100e3
"""G* of two bodies of 200 GPa without Poisson's ratio, by 1/G* = sum (2 - nu)/4G (MPa)."""


def body(nu: float) -> dict[str, float]:
    """Return an elastic body."""
    return {"young_modulus": 200e3, "poisson_ratio": nu}


def hertz(nu: float) -> HertzContact:
    """Return Hertz's contact of two such bodies under the load."""
    one = ElasticBody.model_validate(body(nu))
    return hertz_sphere(LOAD, RADIUS, compliances(one, one).contact_modulus)


HERTZ = hertz(0.0)


@dataclass(frozen=True)
class Certified:
    """An increment from rest that independent solvers have solved.

    points: cells per side; values: by quantity, in the units of `UNITS`; the stick area counts cells, and gross slip is
    the force of it.
    """

    name: str
    friction: Any
    loads: dict[str, float]
    points: int
    values: dict[str, float]


CERTIFIED = (
    Certified(
        "limit 100 MPa",
        {"coefficient": 0.1, "shear_limit": 100.0},
        {"Qx": 21.07392},
        128,
        {"delta_x": 0.43881, "stick area": 0.1394, "dissipated energy": 0.4844, "gross slip": 26.3437},
    ),
    Certified(
        "0.02 in r < 0.1 mm",
        {"expression": "0.1 - 0.08*(r < 0.1)"},
        {"Qx": 27.908},
        128,
        {"delta_x": 0.60848, "stick area": 0.0952, "dissipated energy": 1.159, "gross slip": 34.8546},
    ),
    Certified(
        "0.3 in abs(y) < 0.0984 mm",
        {"expression": "0.1 + 0.2*(abs(y) < 0.0984375)"},
        {"Qx": 62.2672},
        128,
        {"delta_x": 1.67769, "stick area": 0.0590, "dissipated energy": 14.394, "gross slip": 77.834},
    ),
    Certified(
        "0.2 along x, 0.1 along y",
        {"coefficient": [0.2, 0.1]},
        {"Qx": 30.0, "Qy": 30.0},
        96,
        {"delta_x": 0.63611, "delta_y": 0.71357, "stick area": 0.0808, "dissipated energy": 3.377},
    ),
)

LAWS: dict[str, Any] = {
    "limit 0.5 mu p0": {"coefficient": 0.1, "shear_limit": 0.05 * HERTZ.max_pressure},
    "limit 0.25 mu p0": {"coefficient": 0.1, "shear_limit": 0.025 * HERTZ.max_pressure},
    "3 mu in r < 0.4 a": {"expression": f"0.1 + 0.2*(r < {0.4 * HERTZ.contact_radius})"},
    "mu p0^(1/3) p^(2/3)": {"coefficient": 0.1, "exponent": 2 / 3, "reference_pressure": HERTZ.max_pressure},
}

TRANSFORMED: dict[tuple[str, float], tuple[float, float, float]] = {
    ("mu p", 0.5): (1.0, 0.793701, 0.581257),
    ("mu p", 0.9): (1.0, 0.464159, 1.232379),
    ("limit 0.5 mu p0", 0.5): (0.6875, 0.869007, 0.384574),
    ("limit 0.5 mu p0", 0.9): (0.6875, 0.566742, 0.770077),
    ("limit 0.25 mu p0", 0.5): (0.367188, 0.904929, 0.199815),
    ("limit 0.25 mu p0", 0.9): (0.367188, 0.586505, 0.398447),
    ("3 mu in r < 0.4 a", 0.5): (1.460255, 0.646229, 0.914813),
    ("3 mu in r < 0.4 a", 0.9): (1.460255, 0.305497, 2.395466),
    ("mu p0^(1/3) p^(2/3)", 0.5): (1.125, 0.829717, 0.636719),
    ("mu p0^(1/3) p^(2/3)", 0.9): (1.125, 0.496831, 1.328591),
}
"""Gross slip over mu P, c/a and delta_x over mu p0 a/G* at Q over gross slip, certified by Abel's transform."""


def case_of(friction: Any, stages: list[dict[str, Any]], points: int, nu: float = 0.3) -> Case:
    """Return the sphere under P and `stages`; without Poisson's ratio as the closed forms have it."""
    return Case.model_validate(
        {
            "bodies": [body(nu), body(nu)],
            "surface": {"sphere": {"radius": RADIUS}},
            "grid": {"points": points, "size": SIZE},
            "friction": friction,
            "load_path": [{"P": LOAD}, *stages],
            "output": {"fields": ["shear_bound"]},
        }
    )


def ends(case: Case) -> list[Summary]:
    """Return the summaries of a case."""
    return [state.summary for state in run(case)]


def certified() -> None:
    """Print the comparison with independent solves."""
    print("| friction | cells | quantity | certified | found | difference |")
    print("| --- | --- | --- | --- | --- | --- |")
    for one in CERTIFIED:
        found = ends(case_of(one.friction, [{**one.loads, "increments": 1}], one.points))[-1]
        values = {
            "delta_x": 1e3 * found.delta_x,
            "delta_y": 1e3 * found.delta_y,
            "stick area": found.stick_cells * (SIZE / one.points) ** 2,
            "dissipated energy": 1e3 * found.work_total,
        }
        if "gross slip" in one.values:
            values["gross slip"] = carried(one.friction, one.points)
        for quantity, known in one.values.items():
            value = values[quantity]
            name = f"{quantity} ({UNITS[quantity]})"
            print(f"| {one.name} | {one.points} | {name} | {known:g} | {value:.6g} | {value / known - 1.0:+.1e} |")


def carried(friction: Any, points: int, nu: float = 0.3) -> float:
    """Return the force that friction carries in gross slip (N): the sum of the friction limit."""
    bound = list(run(case_of(friction, [], points, nu)))[-1].fields.shear_bound
    assert bound is not None
    return float(bound.sum()) * (SIZE / points) ** 2


def transformed() -> None:
    """Print c/a, delta_x and gross slip under 128 x 128 cells against Abel's transform as it is certified."""
    print("| friction | Q over gross slip | gross slip over mu P, c/a, delta_x G*/(mu p0 a): certified | found |")
    print("| --- | --- | --- | --- |")
    unit = 0.1 * HERTZ.max_pressure * HERTZ.contact_radius / SHEAR_MODULUS
    for (name, share), known in TRANSFORMED.items():
        friction = LAWS.get(name, {"expression": "0.1"})
        force = share * known[0] * 0.1 * LOAD
        found = ends(case_of(friction, [{"Qx": force, "increments": 1}], 128, 0.0))[-1]
        gross_slip = carried(friction, 128, 0.0) / (0.1 * LOAD)
        values = gross_slip, found.stick_radius / HERTZ.contact_radius, found.delta_x / unit
        texts = (f"{value:.6f} ({value / other - 1.0:+.1e})" for value, other in zip(values, known, strict=True))
        print(f"| {name} | {share} | {', '.join(f'{value:.6f}' for value in known)} | {', '.join(texts)} |")


def closed_forms() -> None:
    """Print the relative errors against Abel's transform, on 32 to 256 points per side."""
    print("| friction | Q over gross slip | delta_x | stick_radius | work_total |")
    print("| --- | --- | --- | --- | --- |")
    for name, friction in LAWS.items():
        gross_slip = set_up(case_of(friction, [], 16, 0.0)).closed_forms
        force = gross_slip.gross_slip(LOAD, gross_slip.hertz[0])[0]
        for share in (0.5, 0.9):
            errors: dict[str, list[str]] = {"delta_x": [], "stick_radius": [], "work_total": []}
            for points in (32, 64, 128, 256):
                case = case_of(friction, [{"Qx": share * force, "increments": 1}], points, 0.0)
                exact = {one.quantity: one.value for one in set_up(case).closed_forms.values() if one.stage == 1}
                found = ends(case)[-1]
                for quantity, column in errors.items():
                    column.append(f"{getattr(found, quantity) / exact[quantity] - 1.0:+.1e}")
            print(f"| {name} | {share} | {' | '.join(map(', '.join, errors.values()))} |")


def under_load() -> None:
    """Print what a change of the coefficient under load does."""
    pull: dict[str, Any] = {"Qx": 36.0, "increments": 1}
    lowered = ends(case_of(0.2, [pull, {"friction": 0.1}], 64))[-1]
    direct = ends(case_of(0.1, [pull], 64))[-1]
    raised = ends(case_of(0.2, [pull, {"friction": 0.3}, {**pull, "Qx": 60.0}], 64))
    throughout = ends(case_of(0.3, [{**pull, "Qx": 60.0}], 64))[-1]
    rows = (
        ("0.2, Q = 36 N, lowered to 0.1", "0.863045", lowered.delta_x),
        ("0.1, Q = 36 N", "0.863045", direct.delta_x),
        ("0.2, Q = 36 N, raised to 0.3: change", "0", raised[2].delta_x - raised[1].delta_x),
        ("the same, then Q = 60 N", "1.221797", raised[3].delta_x),
        ("0.3, Q = 60 N", "1.221805", throughout.delta_x),
    )
    print("| path, 64 x 64 cells | delta_x, um: certified | found |")
    print("| --- | --- | --- |")
    for name, known, delta_x in rows:
        print(f"| {name} | {known} | {np.round(1e3 * delta_x, 6):g} |")


def main() -> None:
    """Print the tables, or put them into a page."""
    page = parser_of(__doc__).parse_args().into
    report(
        {
            "friction certified": certified,
            "friction transform": transformed,
            "friction closed forms": closed_forms,
            "friction changed": under_load,
        },
        page,
    )


if __name__ == "__main__":
    main()
