"""Compare friction that varies with closed forms and certified values, and time what it costs.

    python benchmarks/varied_friction.py                             # about 30 s
    python benchmarks/varied_friction.py --into docs/verification.md

A sphere of 10 mm, P = 400 N, friction 0.1, nu = 0.3, one increment under Qx from rest.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from marked import parser_of, report

from fretsolve import run
from fretsolve.case.body_spec import ElasticBody
from fretsolve.case.models import Case
from fretsolve.model.materials import compliances
from fretsolve.reference.hertz import hertz_sphere
from fretsolve.result.state import Summary
from fretsolve.setup.problem_setup import set_up

LOAD, RADIUS = 400.0, 10.0


def body(nu: float) -> dict[str, float]:
    """Return an elastic body."""
    return {"young_modulus": 200e3, "poisson_ratio": nu}


STEEL = ElasticBody.model_validate(body(0.3))
HERTZ = hertz_sphere(LOAD, RADIUS, compliances(STEEL, STEEL).contact_modulus)

CERTIFIED: tuple[tuple[str, Any, dict[str, float], int, str], ...] = (
    ("limit 100 MPa", {"coefficient": 0.1, "shear_limit": 100.0}, {"Qx": 21.07392}, 128, "0.43881, 0.13866, 0.4844"),
    ("0.02 in r < 0.1 mm", {"expression": "0.1 - 0.08*(r < 0.1)"}, {"Qx": 27.908}, 128, "0.60848, -, 1.159"),
    (
        "0.3 in abs(y) < 0.0984 mm",
        {"expression": "0.1 + 0.2*(abs(y) < 0.0984375)"},
        {"Qx": 62.2672},
        128,
        "1.67769, 0.0590, 14.394",
    ),
    ("0.2 along x, 0.1 along y", {"coefficient": [0.2, 0.1]}, {"Qx": 30.0, "Qy": 30.0}, 96, "0.63611, 0.0808, 3.377"),
)
"""Name, friction, loads, points, and delta_x (um), stick area (mm^2) and dissipated energy (uJ) of independent solves.
The stick area under the shear limit is that of the closed form, the others count cells."""

LAWS: dict[str, Any] = {
    "limit 0.5 mu p0": {"coefficient": 0.1, "shear_limit": 0.05 * HERTZ.max_pressure},
    "limit 0.25 mu p0": {"coefficient": 0.1, "shear_limit": 0.025 * HERTZ.max_pressure},
    "3 mu in r < 0.4 a": {"expression": f"0.1 + 0.2*(r < {0.4 * HERTZ.contact_radius})"},
    "mu p0^(1/3) p^(2/3)": {"coefficient": 0.1, "exponent": 2 / 3, "reference_pressure": HERTZ.max_pressure},
}


def case_of(friction: Any, stages: list[dict[str, Any]], points: int, nu: float = 0.3) -> Case:
    """Return the sphere under P and `stages`; without Poisson's ratio as the closed forms have it."""
    return Case.model_validate(
        {
            "bodies": [body(nu), body(nu)],
            "surface": {"sphere": {"radius": RADIUS}},
            "grid": {"points": points, "size": 0.9},
            "friction": friction,
            "load_path": [{"P": LOAD}, *stages],
        }
    )


def ends(case: Case) -> list[Summary]:
    """Return the summaries of a case."""
    return [state.summary for state in run(case)]


def certified() -> None:
    """Print the comparison with independent solves."""
    print("| friction | cells | delta_x (um), stick area (mm^2), dissipated energy (uJ): certified | found |")
    print("| --- | --- | --- | --- |")
    for name, friction, loads, points, known in CERTIFIED:
        found = ends(case_of(friction, [{**loads, "increments": 1}], points))[-1]
        values = f"{1e3 * found.delta_x:.5f}, {found.stick_area:.4f}, {1e3 * found.work_total:.4f}"
        print(f"| {name} | {points} | {known} | {values} |")


def closed_forms() -> None:
    """Print the relative errors against Abel's transform."""
    grids = (32, 64, 128, 256)
    print(f"| friction | Q over gross slip | quantity | {' | '.join(map(str, grids))} |")
    print(f"| --- | --- | --- |{' --- |' * len(grids)}")
    for name, friction in LAWS.items():
        gross_slip = set_up(case_of(friction, [], 16, 0.0)).closed_forms
        force = gross_slip.gross_slip(LOAD, gross_slip.hertz[0])[0]
        for share in (0.5, 0.9):
            errors: dict[str, list[str]] = {"delta_x": [], "stick_radius": [], "work_total": []}
            for points in grids:
                case = case_of(friction, [{"Qx": share * force, "increments": 1}], points, 0.0)
                exact = {one.quantity: one.value for one in set_up(case).closed_forms.values() if one.stage == 1}
                found = ends(case)[-1]
                for quantity, column in errors.items():
                    column.append(f"{getattr(found, quantity) / exact[quantity] - 1.0:+.1e}")
            for quantity, column in errors.items():
                print(f"| {name} | {share} | {quantity} | {' | '.join(column)} |")


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
        {"friction certified": certified, "friction closed forms": closed_forms, "friction changed": under_load}, page
    )


if __name__ == "__main__":
    main()
