"""Compare line contacts with closed forms on grids from 20 to 320 cells per half-width.

`figures.py` prints the tables and puts them into docs/verification.md. The cylinder and the rounded punch are the
shipped ones.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

import fretsolve
from fretsolve.problem.model.materials import compliances
from fretsolve.reference.hertz import HertzLine, LineContact, RoundedPunch, pressed_stick_ratio
from fretsolve.reference.line_slip import LinePartialSlip
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
    from fretsolve.simulation.problem_setup import set_up

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


PROPORTIONATE = ((0.6, 0.1, "-.53246, .73246"), (0.9, 0.2, "-.11623, .51623"), (0.3, 0.2, "-.63703, .96948"))
"""Q over mu P, b = sigma/(4 mu p0), and the ends of the stick zone over a by an independent solution."""

ALONE = {0.02: 0.980100, 0.05: 0.950633, 0.1: 0.902562, 0.2: 0.810483, 0.5: 0.569321, 1.0: 0.289359}
"""Stick ratio under bulk stress without Q."""

ENERGIES = {0.0: 5.57719e-4, 0.1: 6.82853e-4, 0.2: 1.05826e-3}
"""Energy dissipated in a cycle of Q = 0.6 mu P in phase with b (mJ/mm)."""


def pulled(cells: int, *steps: tuple[float, float, int]) -> list[State]:
    """Return the states under parts of mu P and b, each with its number of increments."""
    contact, _ = contact_of("line_cylinder")
    limit, unit = FRICTION * contact.load, 4.0 * FRICTION * contact.max_pressure
    stages = [
        f"{{Qx: {part * limit!r} N/mm, bulk_2: {{xx: {b * unit!r} MPa}}, increments: {count}}}"
        for part, b, count in steps
    ]
    sets = [grid(cells, contact.half_width), f"load_path=[{{P: 100 N/mm}}, {', '.join(stages)}]", "expect=[]"]
    return list(fretsolve.run(fretsolve.load_case(CASES / "line_cylinder.yaml", sets)))


def print_bulk() -> None:
    """Print the stick zone under bulk stress and the dissipated energy of cycles in phase with it."""
    a = contact_of("line_cylinder")[0].half_width
    print("| Q/mu P | b | ends of the stick zone/a, certified | found, 80 cells per a | found, 320 |")
    print("| --- " * 5 + "|")
    rows = [*PROPORTIONATE]
    rows += [(0.0, b, f"-{ratio:.6f}, {ratio:.6f}") for b, ratio in ALONE.items()]
    for part, b, certified in rows:
        ends = []
        for cells in (80, 320):
            last = pulled(cells, (part, b, 20))[-1].summary
            low, high = (last.stick_center_x + sign * last.stick_half_width_x for sign in (-1, 1))
            ends.append(f"{low / a:.5f}, {high / a:.5f}")
        print(f"| {part:g} | {b:g} | {certified} | {' | '.join(ends)} |")
    print("\n| b, in phase with Q = 0.6 mu P | energy of a cycle, closed form, mJ/mm | 40 cells per a | 80 | 160 |")
    print("| --- " * 5 + "|")
    for b, energy in ENERGIES.items():
        found = []
        for cells in (40, 80, 160):
            states = pulled(cells, (0.6, b, 1), (-0.6, -b, 40), (0.6, b, 40))
            work = states[-1].summary.work_total - states[1].summary.work_total
            found.append(f"{work / energy - 1.0:+.1e}")
        print(f"| {b:g} | {energy:.5e} | {' | '.join(found)} |")
