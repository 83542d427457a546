"""Carry out ``fretsolve crack``: write the stress intensity of a crack from a result, and print whether it stops.

Functions here raise CaseError and FileError.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from fretsolve.case.dimensions import LENGTH
from fretsolve.case.keys.material_spec import Material
from fretsolve.case.keys.output_spec import LifeCriterion
from fretsolve.case.quantities import QuantityError, to_internal
from fretsolve.case.source import Place
from fretsolve.cli.commands.computed_files import FileOrder, chosen_cycles, positive_length_of, require_no_result
from fretsolve.errors import CaseError
from fretsolve.post.crack.analysis import LONGEST_USUAL, Crack, crack_of
from fretsolve.post.crack.crack_file import write_crack
from fretsolve.post.crack.growth import Growth, intrinsic_length
from fretsolve.post.crack.notes import missing_of, notes_of, warnings_of
from fretsolve.post.crack.request import CrackRequest
from fretsolve.post.fatigue.material import ON_COMMAND_LINE, KeysSource, MaterialSource, read_material
from fretsolve.post.names import crack_path
from fretsolve.post.stress.cycles import LoadCycle
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.result import open_result
from fretsolve.system.arrays import DoubleArray
from fretsolve.system.files import make_folder, require_ending, require_free, require_other, require_utf8, writing
from fretsolve.system.progress import counting_bar, print_warnings

SHOWN = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0)
"""Lengths over the half-width of the contact whose stress intensities are printed."""


@dataclass(frozen=True)
class CrackOptions:
    """The options of `fretsolve crack`. out: a result; target: None for the usual name."""

    out: Path
    material: str | None
    at: str
    body: str | None
    criterion: LifeCriterion | None
    final_length: str | None
    thickness: str | None
    cycle: str | None
    blocks: Path | None
    target: Path | None
    overwrite: bool
    quiet: bool

    def request(self) -> CrackRequest:
        """Return what the options ask for. Raises CaseError, FileError."""
        return CrackRequest(
            _no_material() if self.material is None else read_material(self.material),
            _place(self.at),
            None if self.body is None else 1 if self.body == "1" else 2,
            self.criterion,
            positive_length_of("--final-length", self.final_length),
            positive_length_of("--thickness", self.thickness),
            chosen_cycles(self.cycle, self.blocks),
        )


def _no_material() -> MaterialSource:
    return MaterialSource(Material(), KeysSource(ON_COMMAND_LINE, "", Place(1)))


def _place(text: str) -> Literal["edge", "max"] | float:
    """Return where --at puts the crack. Raises CaseError."""
    if text in ("edge", "max"):
        return "edge" if text == "edge" else "max"
    try:
        return float(to_internal(text, LENGTH))
    except QuantityError as error:
        raise CaseError(f"{error}; edge, max, or x of the crack such as -0.1mm is needed", (), "--at") from None


def crack_of_result(options: CrackOptions) -> int:
    """Look at the crack of a result, write the file and print what is known of it. Return the exit code."""
    request = options.request()
    with open_result(options.out) as result:
        target = options.target or crack_path(result.path)
        require_ending(target, "a file of a crack", ".h5", ".hdf5")
        require_other(target, options.out, "the result itself")
        require_no_result(target)
        require_free(target, overwrite=options.overwrite)
        make_folder(target.parent)
        tractions = TractionHistory(result)
        write_crack_with_messages(tractions, request, FileOrder(target, 1, options.quiet, not options.overwrite))
    return 0


def write_crack_with_messages(tractions: TractionHistory, request: CrackRequest, order: FileOrder) -> None:
    """Write the crack that a request asks for, and print what is known of it. Raises CaseError, FileError."""
    result = tractions.result
    require_utf8(result.path.name, result.path)
    shown = not order.quiet and sys.stdout.isatty()
    crack = crack_of(tractions, request, lambda total: counting_bar("lengths", total, shown=shown))
    with writing(order.target):
        write_crack(crack, result, order.target, folder=order.folder, exclusive=order.exclusive)
    mismatch = request.material.mismatch(result.effective_case["bodies"][crack.body - 1])
    print_warnings(result.path, *warnings_of(crack, request), *filter(None, [mismatch]))
    if order.quiet:
        return
    for line in crack_lines(crack):
        print(line)
    worn = "wear" in result.effective_case
    for note in notes_of(crack, request, line=tractions.plane_strain, worn=worn):
        print(f"  {note}")
    print(order.target, flush=True)


def crack_lines(crack: Crack) -> Iterator[str]:
    """Yield lines on the place of a crack, its stress intensities, verdict and lives."""
    place = crack.place
    yield f"body {crack.body}, crack at x = {place.x:.5g}, y = {place.y:.4g} mm ({place.reason})"
    yield from constant_lines(crack)
    yield from _table(crack)
    yield from _verdict_lines(crack)
    yield from _life_lines(crack)
    if len(crack.cycles) > 1:
        for cycle, ranges, growth in zip(crack.cycles, crack.cycle_ranges, crack.of_cycles, strict=True):
            yield _cycle_line(crack, cycle, ranges, growth)
    for line in missing_of(crack):
        yield f"  {line}"


def constant_lines(crack: Crack) -> Iterator[str]:
    """Yield the constants that were used, with their units."""
    material, found = crack.material, []
    if (short := intrinsic_length(material)) is not None:
        found.append(f"threshold range {material.threshold_range:g} MPa m^0.5")
        found.append(f"fatigue range {material.fatigue_range:g} MPa, b_0 = {short:.4g} mm")
        if material.surface_factor != 1.0:
            found.append(f"surface factor {material.surface_factor:g}")
    if material.toughness is not None:
        found.append(f"toughness {material.toughness:g} MPa m^0.5")
    if (law := material.paris) is not None:
        found.append(f"Paris's C = {law.coefficient:g} m/cycle/(MPa m^0.5)^{law.exponent:g}, m = {law.exponent:g}")
        if law.walker_exponent != 1.0:
            found.append(f"Walker's exponent {law.walker_exponent:g}")
    if crack.initiation is not None:
        found.append(f"crack begins by {crack.criterion}")
    if found:
        yield f"  {'; '.join(found)}"


def _table(crack: Crack) -> Iterator[str]:
    """Yield a table of stress intensities at some lengths."""
    a, lengths = crack.half_width, crack.lengths
    wanted = [share * a for share in SHOWN] + [lengths[-1]]
    places = sorted({int(np.abs(np.log(lengths / length)).argmin()) for length in wanted})
    walker = crack.material.paris is not None and crack.material.paris.walker_exponent != 1.0
    wording = "range (Walker)" if walker else "range"
    heading = f"  {'b, mm':>9} {'b/a':>7}  {'K_I, MPa m^0.5':<24} {'K_II, MPa m^0.5':<24} {'error':<9} {wording:<18}"
    yield heading + (" threshold" if crack.threshold is not None else "")
    for place in places:
        modes = " ".join(f"{values.min():.4g} to {values.max():.4g}".ljust(24) for values in crack.K[:, :, place])
        ranges = f"{crack.range[place]:.4g} ± {crack.range_error[place]:.2g}"
        bar = f"± {crack.K_error[place]:.2g}"
        line = f"  {lengths[place]:9.4g} {lengths[place] / a:7.3g}  {modes} {bar:<9} {ranges:<18}"
        yield line.rstrip() if crack.threshold is None else f"{line} {crack.threshold[place]:.4g}"


def _verdict_lines(crack: Crack) -> Iterator[str]:
    arrest = crack.growth.arrest
    if arrest is None:
        return
    if arrest == 0.0:
        line = f"no crack: at b = {crack.lengths[crack.judged]:.3g} mm the range is below the threshold"
    elif math.isinf(arrest):
        last = min(float(crack.lengths[-1]), crack.growth.end or math.inf)
        line = f"goes through: the range stays above the threshold up to b = {last:.4g} mm"
    else:
        line = f"arrests at b = {arrest:.4g} ± {crack.values['arrest_length_error']:.2g} mm"
    bounds = [_in_words(one.arrest) for one in (crack.longest, crack.shortest)]
    if len({text.split(" at ")[0] for text in (*bounds, _in_words(arrest))}) > 1:
        line += f"; by the error bars from '{bounds[0]}' to '{bounds[1]}'"
    yield f"  {line}"


def _in_words(arrest: float | None) -> str:
    assert arrest is not None
    return "no crack" if arrest == 0.0 else "goes through" if math.isinf(arrest) else f"arrests at {arrest:.4g} mm"


def _life_lines(crack: Crack) -> Iterator[str]:
    growth, shortest = crack.growth, f"{crack.lengths[crack.judged]:.3g} mm"
    if growth.propagation is None or growth.end is None:
        if crack.initiation is not None:
            yield f"  cycles to a crack of b = {shortest}: {_cycles(float(crack.initiation[crack.judged]))}"
        return
    end = f"b = {growth.end:.4g} mm"
    if growth.life is None:
        yield f"  from b = {shortest} to {end}: {_cycles(float(growth.propagation[crack.judged]))}"
        return
    assert crack.initiation is not None
    bounds = [one.life for one in (crack.shortest, crack.longest)]
    line = f"life {_cycles(growth.life)}"
    if any(one != growth.life for one in bounds):
        line += f" (by the error bars {' to '.join('unknown' if one is None else _count(one) for one in bounds)})"
    if growth.first is not None:
        first = int(np.flatnonzero(crack.lengths == growth.first)[0])
        begins, grows = float(crack.initiation[first]), float(growth.propagation[first])
        line += f": {_cycles(begins)} to a crack of b = {growth.first:.4g} mm, {_cycles(grows)} from it to {end}"
    yield f"  {line}"
    if growth.first == crack.lengths[0]:
        yield "  that is the shortest crack looked at: the life may be less"
    if growth.deeper is not None and math.isfinite(growth.deeper):
        depth = f"{LONGEST_USUAL:g} half-widths of the contact"
        yield f"  a crack that begins by itself deeper, within {depth}, takes {_cycles(growth.deeper)} in all"
    if growth.crossing is not None:
        yield f"  a crack takes as long to begin as to grow at b = {growth.crossing:.4g} mm"


def _cycle_line(crack: Crack, cycle: LoadCycle, ranges: DoubleArray, growth: Growth) -> str:
    """Return a row on one of several cycles, as if it were alone."""
    place = int(np.abs(np.log(crack.lengths / (0.1 * crack.half_width))).argmin())
    times = f"{cycle.times:g} time{'s' if cycle.times != 1.0 else ''}"
    line = f"  {cycle.title}, {times}: range {ranges[place]:.4g} at b = {crack.lengths[place]:.3g} mm"
    if growth.arrest is not None:
        line += f"; {_in_words(growth.arrest)}"
    return line if growth.life is None else f"{line}; life {_cycles(growth.life)}"


def _cycles(count: float) -> str:
    return _count(count) + ("" if math.isinf(count) else " cycles")


def _count(cycles: float) -> str:
    return "endless" if math.isinf(cycles) else f"{cycles:.4g}"
