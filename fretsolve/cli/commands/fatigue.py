"""Carry out ``fretsolve fatigue``: compute fatigue parameters over cycles of a result, and print the worst places.

Functions here raise CaseError and FileError.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from fretsolve.case.dimensions import LENGTH
from fretsolve.case.keys.output_spec import KINDS
from fretsolve.case.keys.quantity_names import CRITERIA
from fretsolve.case.other_names import nearest
from fretsolve.case.quantities import QuantityError, to_internal
from fretsolve.cli.commands.computed_files import FileOptions, FileOrder, chosen_cycles
from fretsolve.cli.commands.shakedown_lines import tell_shakedown
from fretsolve.cli.commands.stress import compute_with_messages
from fretsolve.cli.commands.worst_lines import worst_lines
from fretsolve.errors import CaseError, together
from fretsolve.post.fatigue.fatigue_file import write_fatigue
from fretsolve.post.fatigue.material import read_material
from fretsolve.post.fatigue.request import SMALLER, Average, FatigueRequest, stresses_of_cycles
from fretsolve.post.fatigue.shakedown import ShakedownSearch, shakedown_limits
from fretsolve.post.fatigue.stress_cycle import FatigueCycles, elastic_body, not_closed, stress_cycles, stresses_beside
from fretsolve.post.names import fatigue_path
from fretsolve.post.stress.computed_file import opened_computed
from fretsolve.post.stress.cycles import CycleChoice, whole_path_note
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.result import open_result
from fretsolve.system.files import make_folder, writing
from fretsolve.system.progress import counting_bar, print_warnings


@dataclass(frozen=True)
class FatigueOptions(FileOptions):
    """The options of `fretsolve fatigue`. out: a result, whose stresses are computed first, or a file of stresses.

    criteria: names, several of them joined by commas; average: such as point:20um; cycle: None for the last one;
    blocks: a file of the cycles and how often each of them occurs.
    """

    material: str
    criteria: Sequence[str]
    average: str | None
    cycle: str | None
    blocks: Path | None

    @property
    def cycles(self) -> CycleChoice:
        """The chosen cycles. Raises CaseError, FileError."""
        return chosen_cycles(self.cycle, self.blocks)


def fatigue_of_result(options: FatigueOptions) -> int:
    """Compute fatigue parameters, write them and print the worst places. Return the exit code."""
    request = FatigueRequest(
        read_material(options.material),
        _criteria(options.criteria),
        _average(options.average),
        options.body_numbers,
        window=options.window_choice,
        cycles=options.cycles,
    )
    out = options.out
    order = options.order(fatigue_path(out), "fatigue parameters", "the stresses or the result", SMALLER)
    with opened_computed(out) as found:
        if found is not None and found.kind == "stress":
            if request.window != "auto":
                raise CaseError(
                    "--window has no effect on a file of stresses, which has its cells; leave it out", (), out
                )
            _write(stress_cycles(found, out, out, request), out, order)
            return 0
    make_folder(order.target.parent)
    with open_result(out) as result:
        write_fatigue_with_messages(TractionHistory(result), request, order)
    return 0


def write_fatigue_with_messages(tractions: TractionHistory, request: FatigueRequest, order: FileOrder) -> None:
    """Compute the stresses of cycles and write the parameters, with bars, warnings and the worst places."""
    with writing(order.target), stresses_beside(order.target, order.folder) as stresses:
        computed = stresses_of_cycles(tractions, request)
        compute_with_messages(
            tractions, computed.stresses, replace(order, target=stresses, folder=None, exclusive=True)
        )
        with opened_computed(stresses) as file:
            out = tractions.result.path
            _write(stress_cycles(file, stresses, out, request, computed), out, order)


def _write(cycles: FatigueCycles, out: Path, order: FileOrder) -> None:
    """Write the parameters of cycles, and print the worst places; out: the file that warnings name."""
    shown = not order.quiet and sys.stdout.isatty()
    with counting_bar("layers", cycles.layers, shown=shown) as show, writing(order.target):
        shakedown = ShakedownSearch(shakedown_limits(cycles))
        worst, widest = write_fatigue(
            cycles, order.target, show, shakedown=shakedown, folder=order.folder, exclusive=order.exclusive
        )
    average = cycles.request.average
    gaps = (
        [] if average is None else [average.gap_problem(one.body.depths, one.cell) for one in cycles.of_body.values()]
    )
    bodies = [elastic_body(cycles.attributes, number) for number in cycles.of_body]
    gaps += [cycles.request.material.mismatch(body) for body in bodies]
    notes = whole_path_note(cycles.cycles), not_closed(widest, whole_path=not cycles.cycles[0].number), *gaps
    print_warnings(out, *dict.fromkeys(one for one in notes if one is not None))
    if not order.quiet:
        for number, of_body in cycles.of_body.items():
            for line in worst_lines(number, of_body, worst[number]):
                print(line)
        if cycles.tractions is None:
            print("no error bars: they follow from tractions, which the result has and its stresses do not")
    tell_shakedown(shakedown, out, quiet=order.quiet)
    if not order.quiet:
        print(order.target, flush=True)


def _criteria(texts: Sequence[str]) -> tuple[str, ...]:
    """Return the names of criteria, each once. Raises CaseError."""
    names = [name.strip().replace("_", "-") for text in texts for name in text.split(",")]
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
