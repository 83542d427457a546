"""Compare line contacts with closed forms on grids from 20 to 320 cells per half-width.

    python benchmarks/lines.py

The cylinder and the rounded punch are the shipped ones; `figures.py` puts the tables into docs/verification.md.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

import fretsolve
from fretsolve.model.materials import compliances
from fretsolve.reference.line import HertzLine, LineContact, LinePartialSlip, RoundedPunch, pressed_stick_ratio
from fretsolve.result.state import State

CASES = Path(__file__).resolve().parent.parent / "cases"

CELLS = (20, 40, 80, 160, 320)
FRICTION, SLIPPED = 0.3, 0.6
"""Coefficient of friction, and tangential force over mu P."""

UNLIKE = "bodies=[{young_modulus: 200 GPa, poisson_ratio: 0.06}, {young_modulus: 200 GPa, poisson_ratio: 0.42}]"
FULL = {0.05: ("one cell", 1.031), 0.10: ("0.178", 1.036), 0.15: ("0.462", 1.035), 0.20: ("0.706", 1.035)}
FULL[0.25] = ("0.844", 1.034)
"""Stick ratio and largest pressure over Hertz's by an independent solve, 96 cells per half-width, 48 increments."""


def grid(cells: int, half_width: float) -> str:
    """Return a grid with a cell in the middle, out to 1.3 half-widths."""
    points = 2 * math.ceil(1.3 * cells) + 1
    return f"grid={{points: {points}, size: {points * half_width / cells!r}}}"


def contact_of(name: str) -> tuple[LineContact, LinePartialSlip]:
    """Return the closed forms of a shipped line contact."""
    case = fretsolve.load_case(CASES / f"{name}.yaml")
    material = compliances(*case.bodies)
    contact: LineContact = HertzLine(100.0, 10.0, material.contact_modulus)
    if name == "line_punch":
        contact = RoundedPunch(200.0, 0.5, 100.0, material.contact_modulus)
    return contact, LinePartialSlip(contact, FRICTION, SLIPPED * FRICTION * contact.load, material.A)


def errors(name: str, cells: int) -> Mapping[str, float]:
    """Return relative errors of a shipped line contact on a grid."""
    contact, slip = contact_of(name)
    force = f"{slip.shear_force!r} N/mm"
    path = f"{{P: {contact.load!r} N/mm}}, {{Qx: {force}, increments: 1}}"
    if name == "line_cylinder":
        path += f", {{Qx: -{force}, increments: 40}}, {{Qx: {force}, increments: 40}}"
    sets = [grid(cells, contact.half_width), f"load_path=[{path}]", "solver.tolerance=1e-8", "expect=[]"]
    case = fretsolve.load_case(CASES / f"{name}.yaml", sets)
    states = list(fretsolve.run(case))
    return {key: found / exact - 1.0 for key, found, exact in _compared(case, states, contact, slip)}


def _compared(
    case: object, states: Sequence[State], contact: LineContact, slip: LinePartialSlip
) -> Iterator[tuple[str, float, float]]:
    from fretsolve.setup.problem_setup import set_up

    x = set_up(case).grid.x  # type: ignore[arg-type]
    pressed, sheared = states[0], states[1]
    middle, zero = len(x) // 2, np.zeros(1)
    yield "largest pressure", pressed.summary.max_pressure, contact.max_pressure
    yield "half-width a", pressed.summary.contact_radius, contact.half_width
    yield "stick half-width c", sheared.summary.stick_radius, slip.stick_half_width
    yield "shear traction q(0)", float(sheared.fields.shear[0, middle, 0]), float(slip.shear(zero)[0])
    if not isinstance(contact, HertzLine):
        yield "pressure p(0)", float(pressed.fields.pressure[middle, 0]), float(contact.pressure(zero)[0])
        return
    at = np.array([0.9 * contact.half_width])
    yield "slip at 0.9 a", float(np.interp(at[0], x, sheared.fields.slip[0, :, 0])), float(slip.slip(at)[0])
    work = states[-1].summary.work_total - sheared.summary.work_total
    yield "dissipated energy per cycle", work, slip.work_per_cycle


def print_orders() -> None:
    """Print the errors of both contacts over the cells, with the mean order."""
    print("| contact | quantity |", " | ".join(map(str, CELLS)), "| order |")
    print("| --- " * (len(CELLS) + 3) + "|")
    for name, words in (("line_cylinder", "cylinder"), ("line_punch", "rounded punch")):
        found = [errors(name, cells) for cells in CELLS]
        for quantity in found[0]:
            values = [one[quantity] for one in found]
            order = math.log2(abs(values[0] / values[-1])) / (len(CELLS) - 1)
            print(f"| {words} | {quantity} |", " | ".join(f"{value:+.1e}" for value in values), f"| {order:.1f} |")


def print_unlike() -> None:
    """Print stick ratio and largest pressure of unlike bodies under P alone."""
    print("| friction | c/a one-way, closed form | c/a certified | c/a found | p/Hertz certified | p/Hertz found |")
    print("| --- " * 6 + "|")
    for friction, (stick, peak) in FULL.items():
        contact, _ = contact_of("line_cylinder")
        path = "load_path=[{P: 100 N/mm, increments: 48, spacing: graded}]"
        sets = [UNLIKE, f"friction={friction}", grid(96, contact.half_width), path, "expect=[]"]
        case = fretsolve.load_case(CASES / "line_cylinder.yaml", sets)
        *_, last = fretsolve.run(case)
        form = pressed_stick_ratio(friction, compliances(*case.bodies).dundurs_constant)
        ratio = last.summary.stick_radius / last.summary.contact_radius
        pressure = last.summary.max_pressure / contact.max_pressure
        print(f"| {friction:.2f} | {form:.4f} | {stick} | {ratio:.3f} | {peak:.3f} | {pressure:.3f} |")


if __name__ == "__main__":
    print_orders()
    print()
    print_unlike()
