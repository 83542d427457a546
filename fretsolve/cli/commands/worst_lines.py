"""Lines with the worst fatigue parameters of a body."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from fretsolve.post.fatigue.stress_cycle import StressCycles
from fretsolve.post.fatigue.worst import Life, Worst, WorstOfBody
from fretsolve.post.names import OUTERMOST

UNBOUNDED = "on these cells; at a sharp edge or tip stress grows without bound as cells get smaller"
"""What is said of a largest value at a sharp edge."""


def error_text(error: float) -> str:
    """Return an error bar, empty if it is not known or has no bound."""
    if not math.isfinite(error):
        return ""
    return f" ± {error:.2g}" if error < 100.0 else f" ± {error:.0f}"


def counted(values: Sequence[object], noun: str) -> str:
    """Return how many values there are, in words."""
    return f"{len(values)} {noun}{'s' if len(values) != 1 else ''}"


def worst_lines(number: int, of_body: StressCycles, worst: WorstOfBody) -> Iterator[str]:
    """Return lines with the worst place of each criterion in a body; of several cycles first a row of each."""
    average, cycles = of_body.average, of_body.cycles
    mean = f", {average.kind} average over {average.length:g} mm" if average is not None else ""
    several = f" of {len(cycles)} cycles" if len(cycles) > 1 else ""
    states = cycles[0].states if len(cycles) == 1 else of_body.states
    yield f"body {number}, {counted(of_body.depths.tolist(), 'depth')}, {len(states)} states{several}{mean}:"
    if several:
        yield from _rows_of_cycles(of_body, worst)
    for found in worst.total.values():
        yield _line_of(found, sum(cycle.times for cycle in cycles) if several else None)
    if any(found.outermost for found in worst.total.values()):
        yield f"  # {OUTERMOST}"
    if any(math.isinf(found.error) for found in worst.total.values()):
        yield f"  ! {UNBOUNDED}"


def _rows_of_cycles(of_body: StressCycles, worst: WorstOfBody) -> Iterator[str]:
    """Return a table of the worst values of each cycle, with how often the cycle occurs."""
    units = [f"{name}, {found.units}" if found.units != "1" else name for name, found in worst.total.items()]
    widths = [max(len(unit), 9) for unit in ("", "", *units)]
    rows = [("cycle", "times", *units)]
    for cycle, found in zip(of_body.cycles, worst.of_cycles, strict=True):
        cells = f"{cycle.number}", f"{cycle.times:g}", *(f"{one.value:.4g}" for one in found.values())
        rows.append(cells)
    for row in rows:
        yield "  " + "  ".join(f"{text:>{width}}" for text, width in zip(row, widths, strict=True))


def _line_of(found: Worst, block: float | None) -> str:
    """Return the line of a criterion; block: how many cycles a block has, None for a single cycle."""
    unit = f" {found.units}" if found.units != "1" else ""
    x, y, depth = found.place
    error = error_text(found.error)
    line = f"  {found.criterion:<13} {found.value:9.4g}{error}{unit}"
    if found.limit is not None:
        line += f", {100.0 * found.value / found.limit:.3g} % of {found.limit:.4g}{unit}"
    if found.life is not None:
        line += f", {_life_text(found.life, block)}"
    line += f", at x = {x:.4g}, y = {y:.4g}, depth {depth:.4g} mm"
    if block is not None:
        line += f", cycle {found.cycle}"
    if found.normal is not None:
        line += f", plane normal ({', '.join(f'{round(part, 3) + 0.0:.3f}' for part in found.normal)})"
    return line + (" #" if found.outermost else "") + (" !" if math.isinf(found.error) else "")


def _life_text(life: Life, block: float | None) -> str:
    """Return a life with its bounds, and the damage of a block."""
    text = "endless life" if math.isinf(life.cycles) else f"life {life.cycles:.3g}"
    if not math.isnan(life.low) and life.low != life.high:
        text += f" ({life.low:.3g} to {'endless' if math.isinf(life.high) else f'{life.high:.3g}'})"
    if not math.isinf(life.cycles):
        text += " cycles"
    if block is not None:
        text += f", damage {block / life.cycles if life.cycles else math.inf:.3g} a block"
    return text
