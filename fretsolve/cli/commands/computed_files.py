"""Carry out ``fretsolve stress`` and ``fretsolve fatigue``: compute files from a result, and print the largest values.

Stresses lie below the surface; fatigue parameters are over cycles of a result, by default the last one.

Functions here raise CaseError and FileError.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from fretsolve.case.dimensions import LENGTH
from fretsolve.case.keys.output_spec import KINDS
from fretsolve.case.keys.quantity_names import CRITERIA, INVARIANTS
from fretsolve.case.other_names import nearest
from fretsolve.case.quantities import QuantityError, to_internal
from fretsolve.cli.commands.shakedown_lines import tell_shakedown, tell_shakedown_of
from fretsolve.cli.commands.worst_lines import UNBOUNDED, counted, error_text, worst_lines
from fretsolve.errors import CaseError, FileError, together
from fretsolve.post.export.selection import stored_step
from fretsolve.post.fatigue.fatigue_file import write_fatigue
from fretsolve.post.fatigue.material import placed, read_material
from fretsolve.post.fatigue.request import SMALLER, Average, FatigueRequest, stresses_of_cycles
from fretsolve.post.fatigue.shakedown import ShakedownSearch
from fretsolve.post.fatigue.shakedown import yield_stresses as bearable
from fretsolve.post.fatigue.stress_cycle import FatigueCycles, not_closed, stress_cycles, stresses_beside
from fretsolve.post.names import OUTERMOST, fatigue_path, stress_path
from fretsolve.post.stress.computed_file import opened_computed
from fretsolve.post.stress.cycles import CycleChoice, chosen, cycles_of, read_blocks, states_of, whole_path_note
from fretsolve.post.stress.influence import Body
from fretsolve.post.stress.peaks import Key, Peak
from fretsolve.post.stress.request import (
    AS_OPTIONS,
    Plane,
    StressRequest,
    WindowChoice,
    disk_problem,
    memory_problem,
    stress_request,
    warnings_of,
)
from fretsolve.post.stress.stress_file import write_stress
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.post.stress.yielding import computed_lines, yield_lines, yield_stresses
from fretsolve.problem.setup.cost_estimate import free_bytes, rounded_bytes
from fretsolve.result import Result, open_result
from fretsolve.result.state import stage_ends
from fretsolve.system.files import make_folder, require_ending, require_free, require_other, require_utf8, writing
from fretsolve.system.progress import counting_bar, print_warnings

TITLES = {"mises": "largest von Mises stress", "tension": "largest tension", "tresca": "largest shear (Tresca)"}

WINDOW_KINDS: dict[str, WindowChoice] = {"auto": "auto", "all": "all"}


@dataclass(frozen=True)
class FileOrder:
    """A file to compute from a result.

    threads: that compute; quiet: print only warnings; exclusive: replace no file; advice: what would help where memory
    or disk is too small.
    """

    target: Path
    threads: int
    quiet: bool
    exclusive: bool
    advice: str = AS_OPTIONS


@dataclass(frozen=True)
class FileOptions:
    """Options of a command that computes a file from the result `out`. target: None for the usual name."""

    out: Path
    bodies: Sequence[str]
    window: str
    target: Path | None
    overwrite: bool
    threads: int
    quiet: bool

    @property
    def body_numbers(self) -> tuple[Body, ...]:
        """The chosen bodies."""
        return tuple(1 if body == "1" else 2 for body in self.bodies)

    @property
    def window_choice(self) -> WindowChoice:
        """The cells: auto, all, or a margin (mm). Raises CaseError."""
        if self.window in WINDOW_KINDS:
            return WINDOW_KINDS[self.window]
        needed = "a margin around the contact is needed"
        return length_of("--window", self.window, needed, "; auto, all, or a margin such as 0.5mm is needed")

    def order(self, usual: Path, contents: str, source: str, advice: str = AS_OPTIONS) -> FileOrder:
        """Return the order of a file, by default `usual`. Raises CaseError, FileError if the file cannot be written.

        contents, source: what the file holds and what `out` is, in words.
        """
        target = self.target or usual
        require_ending(target, f"a file of {contents}", ".h5", ".hdf5")
        require_other(target, self.out, source)
        require_free(target, overwrite=self.overwrite)
        return FileOrder(target, self.threads, self.quiet, not self.overwrite, advice)


@dataclass(frozen=True)
class StressOptions(FileOptions):
    """The options of `fretsolve stress`."""

    depths: Sequence[str]
    stages: Sequence[int]
    steps: Sequence[tuple[int, int]]
    cycle: str | None
    plane: Plane | None


def stress_of_result(options: StressOptions) -> int:
    """Compute the stresses of a result, write them and print the largest ones. Return the exit code."""
    needed = "a depth is the distance from the surface into a body"
    depths = [length_of("--depth", text, needed) for text in options.depths]
    with open_result(options.out) as result:
        order = options.order(stress_path(result.path), "stresses", "the result itself")
        tractions, bodies = TractionHistory(result), options.body_numbers
        steps = _increments(result, options)
        request = stress_request(tractions, steps, bodies, depths, options.plane, options.window_choice)
        write_with_messages(tractions, request, order)
        if options.cycle is not None and (limits := yield_stresses(result)):
            tell_shakedown_of(order.target, cycle_choice(options.cycle), limits, result.path, quiet=order.quiet)
    return 0


def write_with_messages(tractions: TractionHistory, request: StressRequest, order: FileOrder) -> None:
    """Write the stresses that a request asks for, and print the largest ones. Raises CaseError, FileError."""
    peaks = compute_with_messages(tractions, request, order)
    result = tractions.result
    certain = yield_lines(result, dict.fromkeys(request.bodies, math.inf))  # what is about so is computed
    lines = {**certain, **computed_lines(result, request, peaks)}
    print_warnings(result.path, *(lines[body] for body in request.bodies if body in lines))
    if not order.quiet:
        for line in peak_lines(request, peaks):
            print(line)
        print(order.target, flush=True)


def compute_with_messages(
    tractions: TractionHistory, request: StressRequest, order: FileOrder
) -> dict[Key, list[Peak]]:
    """Write the stresses that a request asks for, with warnings and a bar, and return the largest ones."""
    path, target = tractions.result.path, order.target
    require_utf8(path.name, path)
    if (problem := memory_problem(request, order.threads, order.advice)) is not None:
        raise CaseError(problem, (), path)
    if (problem := disk_problem(request, free_bytes(target), order.advice)) is not None:
        raise FileError(problem, path)
    print_warnings(path, *warnings_of(request, tractions))
    if not order.quiet and request.file_bytes > 1e9:
        print(f"the file takes up to {rounded_bytes(request.file_bytes)}", flush=True)
    layers = len(request.bodies) * len(request.depths) * len(request.steps)
    with counting_bar("layers", layers, shown=not order.quiet and sys.stdout.isatty()) as show, writing(target):
        return write_stress(tractions, request, target, order.threads, show, exclusive=order.exclusive)


def peak_lines(request: StressRequest, peaks: Mapping[Key, Sequence[Peak]]) -> Iterator[str]:
    """Return lines with the largest stresses of all increments."""
    for body in request.bodies:
        yield f"body {body}, {counted(request.depths, 'depth')}, {counted(request.steps, 'increment')}:"
        notes = set()
        for name in INVARIANTS:
            found = peaks[body, name]
            index = max(range(len(found)), key=lambda one: found[one].value)
            peak = found[index]
            mark = _mark(peak)
            notes.add(mark)
            place = f"x = {peak.x:.4g}, y = {peak.y:.4g}, depth {peak.depth:.4g} mm, increment {request.steps[index]}"
            error = "" if peak.unbounded else error_text(peak.error)
            yield f"  {TITLES[name] + mark:<26} {peak.value:8.4g}{error} MPa at {place}"
        if "*" in notes:
            yield "  * at the edge of contact, where stress converges with the square root of the cell: extrapolated"
        if "+" in notes:
            yield "  + at the largest depth: it may grow below"
        if "#" in notes:
            yield f"  # {OUTERMOST}"
        if "!" in notes:
            yield f"  ! {UNBOUNDED}"


def _mark(peak: Peak) -> str:
    """Return the mark of a note below the largest values, empty for none."""
    marks = {"!": peak.unbounded, "*": peak.at_edge, "+": peak.deepest, "#": peak.outermost}
    return next((mark for mark, holds in marks.items() if holds), "")


def cycle_choice(text: str) -> CycleChoice:
    """Return the cycles that --cycle chooses. Raises CaseError."""
    if text in ("last", "all"):
        return "last" if text == "last" else "all"
    if not (text.isdecimal() and int(text) > 0):
        raise CaseError(f"{text!r} is no cycle; last, all, or a number from 1 on is needed", (), "--cycle")
    return int(text)


def chosen_cycles(cycle: str | None, blocks: Path | None) -> CycleChoice:
    """Return the cycles that --cycle or --blocks chooses, by default the last one. Raises CaseError, FileError."""
    if blocks is None:
        return cycle_choice(cycle or "last")
    if cycle is not None:
        raise CaseError("--blocks names the cycles; leave --cycle out", (), "--cycle")
    return read_blocks(blocks)


def positive_length_of(option: str, text: str | None) -> float | None:
    """Return the value of an option that is a length above 0 (mm), None without one. Raises CaseError."""
    if text is None:
        return None
    if not (length := length_of(option, text, needed := "a length > 0 mm is needed")) > 0.0:
        raise CaseError(f"{text!r} is out of range; {needed}", (), option)
    return length


def length_of(option: str, text: str, needed: str, instead: str = "") -> float:
    """Return the value of an option in mm. Raises CaseError.

    needed: what a negative value should be; instead: what a value that is no length should be.
    """
    try:
        length = to_internal(text, LENGTH)
    except QuantityError as error:
        raise CaseError(f"{error}{instead}", (), option) from None
    if length < 0.0:
        raise CaseError(f"{text!r} is negative; {needed}", (), option)
    return length


def _increments(result: Result, options: StressOptions) -> list[int]:
    """Return the increments that the options choose, by default the ends of stages. Raises CaseError."""
    if not result.increments:
        raise CaseError(result.why_empty, (), result.path)
    ends = stage_ends(result.history["stage"]).tolist()
    if not (options.stages or options.steps or options.cycle):
        return [step for step in ends if step in result.steps] or list(result.steps[-1:])
    found = set[int]()
    if options.cycle is not None:
        with placed(lambda message: CaseError(f"{message}; --stage or --step chooses increments", (), result.path)):
            cycles = chosen(cycles_of(result), cycle_choice(options.cycle))
        print_warnings(result.path, *filter(None, [whole_path_note(cycles)]))
        found.update(states_of(cycles, result.steps))
    try:
        for stage in options.stages:
            if not 1 <= stage <= len(ends):
                raise ValueError(f"there is no stage {stage}; there are 1 to {len(ends)}")
            found.add(stored_step(result, ends[stage - 1]))
        for first, last in options.steps:
            inside = [step for step in result.steps if first <= step <= last]
            if first != last and not inside:
                raise ValueError(f"no increment from {first} to {last} has fields")
            found.update(inside if first != last else [stored_step(result, first)])
    except ValueError as error:
        raise CaseError(str(error), (), result.path) from error
    return sorted(found)


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
    with writing(order.target), stresses_beside(order.target) as stresses:
        computed = stresses_of_cycles(tractions, request)
        compute_with_messages(tractions, computed.stresses, replace(order, target=stresses, exclusive=True))
        with opened_computed(stresses) as file:
            out = tractions.result.path
            _write(stress_cycles(file, stresses, out, request, computed), out, order)


def _write(cycles: FatigueCycles, out: Path, order: FileOrder) -> None:
    """Write the parameters of cycles, and print the worst places; out: the file that warnings name."""
    shown = not order.quiet and sys.stdout.isatty()
    with counting_bar("layers", cycles.layers, shown=shown) as show, writing(order.target):
        shakedown = ShakedownSearch(bearable(cycles))
        worst, widest = write_fatigue(cycles, order.target, show, shakedown=shakedown, exclusive=order.exclusive)
    average = cycles.request.average
    gaps = (
        [] if average is None else [average.gap_problem(one.body.depths, one.cell) for one in cycles.of_body.values()]
    )
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
