"""Carry out ``fretsolve fatigue``: fatigue parameters over the last cycle of a result, and where they are largest."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from fretsolve.case.dimensions import LENGTH
from fretsolve.case.keys.output_spec import KINDS
from fretsolve.case.other_names import nearest
from fretsolve.case.problems import together
from fretsolve.case.quantities import QuantityError, to_internal
from fretsolve.cli.commands.stress import FileOptions, FileOrder, compute_with_messages
from fretsolve.errors import CaseError
from fretsolve.post.fatigue.fatigue_file import Worst, write_fatigue
from fretsolve.post.fatigue.request import SMALLER, Average, FatigueRequest, read_material, stresses_of_cycle
from fretsolve.post.fatigue.stress_cycle import FatigueCycles, StressCycle, cycles_of, not_closed, stresses_beside
from fretsolve.post.names import CRITERIA, OUTERMOST, fatigue_path
from fretsolve.post.stress.computed_file import opened_computed
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.result import open_result
from fretsolve.system.files import make_folder, writing
from fretsolve.system.progress import counting_bar, print_warnings


@dataclass(frozen=True)
class FatigueOptions(FileOptions):
    """The options of `fretsolve fatigue`. out: a result, whose stresses are computed first, or a file of stresses.

    criteria: names, several of them joined by commas; average: such as point:20um.
    """

    material: str
    criteria: Sequence[str]
    average: str | None


def fatigue_of_result(options: FatigueOptions) -> int:
    """Compute fatigue parameters, write them and print the worst places. Return the exit code.

    Raises CaseError, FileError.
    """
    request = FatigueRequest(
        read_material(options.material),
        _criteria(options.criteria),
        _average(options.average),
        options.body_numbers,
        window=options.window_choice,
    )
    out = options.out
    order = options.order(fatigue_path(out), "fatigue parameters", "the stresses or the result", SMALLER)
    with opened_computed(out) as found:
        if found is not None and found.kind == "stress":
            if request.window != "auto":
                raise CaseError(
                    "--window has no effect on a file of stresses, which has its cells; leave it out", (), out
                )
            _write(cycles_of(found, out, out, request), out, order)
            return 0
    make_folder(order.target.parent)
    with open_result(out) as result:
        write_fatigue_with_messages(TractionHistory(result), request, order)
    return 0


def write_fatigue_with_messages(tractions: TractionHistory, request: FatigueRequest, order: FileOrder) -> None:
    """Compute the stresses of the last cycle and write the parameters, with bars, warnings and the worst places.

    Raises CaseError, FileError.
    """
    with writing(order.target), stresses_beside(order.target) as stresses:
        needed = stresses_of_cycle(tractions, request)
        compute_with_messages(tractions, needed, replace(order, target=stresses, exclusive=True))
        with opened_computed(stresses) as file:
            out = tractions.result.path
            _write(cycles_of(file, stresses, out, request), out, order)


def _write(cycles: FatigueCycles, out: Path, order: FileOrder) -> None:
    """Write the parameters of cycles, and print the worst places; out: the file that warnings name."""
    shown = not order.quiet and sys.stdout.isatty()
    with counting_bar("layers", cycles.layers, shown=shown) as show, writing(order.target):
        worst, widest = write_fatigue(cycles, order.target, show, exclusive=order.exclusive)
    average = cycles.request.average
    gaps = (
        [] if average is None else [average.gap_problem(one.body.depths, one.cell) for one in cycles.of_body.values()]
    )
    print_warnings(out, *dict.fromkeys(one for one in (not_closed(widest), *gaps) if one is not None))
    if not order.quiet:
        for line in worst_lines(cycles.of_body, worst, cycles.request.average):
            print(line)
        print(order.target, flush=True)


def worst_lines(
    cycles: Mapping[int, StressCycle], worst: Mapping[int, Mapping[str, Worst]], average: Average | None
) -> Iterator[str]:
    """Return lines with the worst place of each criterion."""
    for number, cycle in cycles.items():
        mean = f", {average.kind} average over {average.length:g} mm" if average is not None else ""
        depths = f"{len(cycle.depths)} depth{'s' if len(cycle.depths) != 1 else ''}"
        yield f"body {number}, {depths}, {len(cycle.chosen)} states{mean}:"
        for name, found in worst[number].items():
            unit = f" {found.units}" if found.units != "1" else ""
            x, y, depth = found.place
            line = f"  {name:<13} {found.value:9.4g}{unit}"
            if found.limit is not None:
                line += f", {100.0 * found.value / found.limit:.3g} % of {found.limit:.4g}{unit}"
            if found.life is not None:
                line += ", endless life" if math.isinf(found.life) else f", life {found.life:.3g} cycles"
            line += f", at x = {x:.4g}, y = {y:.4g}, depth {depth:.4g} mm"
            if found.normal is not None:
                line += f", plane normal ({', '.join(f'{round(part, 3) + 0.0:.3f}' for part in found.normal)})"
            if found.outermost:
                line += " #"
            yield line
        if any(found.outermost for found in worst[number].values()):
            yield f"  # {OUTERMOST}"


def _criteria(texts: Sequence[str]) -> tuple[str, ...]:
    """Return the names of criteria, each once. Raises CaseError."""
    names = [name.strip() for text in texts for name in text.split(",")]
    message = "{!r} is not a criterion; {}"
    wrong = [
        CaseError(message.format(name, nearest(name, CRITERIA)), (), "--criterion")
        for name in names
        if name not in CRITERIA
    ]
    if wrong:
        raise together(wrong)
    return tuple(dict.fromkeys(names))


def _average(text: str | None) -> Average | None:
    """Return an average from a text such as point:20um. Raises CaseError."""
    if text is None:
        return None
    kind, _, length = text.partition(":")
    known = next((one for one in KINDS if one == kind.strip()), None)
    if known is None:
        raise CaseError(
            f"{text!r} is not an average; one such as {', '.join(f'{one}:20um' for one in KINDS)}", (), "--average"
        )
    try:
        value = to_internal(length, LENGTH)
    except QuantityError as error:
        raise CaseError(str(error), (), "--average") from None
    if value <= 0.0:
        raise CaseError(f"{length!r} is out of range; a length > 0 mm is needed", (), "--average")
    return Average(known, value)
