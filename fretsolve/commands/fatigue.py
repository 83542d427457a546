"""Carry out ``fretsolve fatigue``: fatigue parameters over the last cycle of a result, and where they are largest."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import get_args

from fretsolve.case.dimensions import LENGTH
from fretsolve.case.problems import nearest
from fretsolve.case.quantities import QuantityError, to_internal
from fretsolve.errors import CaseError
from fretsolve.fatigue.averaging import Average, AverageKind
from fretsolve.fatigue.criteria import CRITERIA
from fretsolve.fatigue.cycle import not_closed, require_states
from fretsolve.fatigue.fatigue_file import Worst, fatigue_path, write_fatigue
from fretsolve.fatigue.material_file import MaterialSource, read_material
from fretsolve.fatigue.stress_cycle import StressCycle, cycle_of, elastic_body
from fretsolve.result import open_result
from fretsolve.setup.cost_estimate import free_bytes
from fretsolve.stress.names import is_stress_file
from fretsolve.stress.request import memory_problem, stress_request, warnings_of
from fretsolve.stress.stress_file import bodies_of, write_stress
from fretsolve.stress.tractions import TractionHistory, last_cycle
from fretsolve.system.files import make_folder, require_ending, require_free, require_other, writing
from fretsolve.system.foreign_files import open_hdf5
from fretsolve.system.progress import counting_bar, print_warnings

LINE_DEPTHS = 9
"""Depths that are computed for an average, evenly over its range."""


def fatigue_of_result(
    out: Path,
    material: str,
    criteria: Sequence[str],
    average: str | None,
    bodies: Sequence[str],
    target: Path | None,
    overwrite: bool,
    threads: int,
    quiet: bool,
) -> int:
    """Compute fatigue parameters, write them and print the worst places. Return the exit code.

    out: a result, whose stresses are computed first, or a file of stresses. criteria: names, several of them joined by
    commas; average: such as point:20um. Raises CaseError, FileError.
    """
    names = _criteria(criteria)
    constants = read_material(material)
    mean = _average(average)
    target = target or fatigue_path(out)
    require_ending(target, "a file of fatigue parameters", ".h5", ".hdf5")
    require_other(target, out, "the stresses or the result")
    require_free(target, overwrite=overwrite)
    chosen = [int(body) for body in bodies]
    if is_stress_file(out):
        _write(out, out, constants, names, mean, chosen, target, quiet=quiet, exclusive=not overwrite)
        return 0
    make_folder(target.parent)
    with writing(target), TemporaryDirectory(dir=target.parent, prefix=".fretsolve-") as folder:
        stresses = Path(folder) / "stress.h5"
        _compute_stresses(out, constants, names, mean, chosen, stresses, threads)
        _write(out, stresses, constants, names, mean, chosen, target, quiet=quiet, exclusive=not overwrite)
    return 0


def _compute_stresses(
    out: Path,
    constants: MaterialSource,
    names: tuple[str, ...],
    average: Average | None,
    bodies: Sequence[int],
    target: Path,
    threads: int,
) -> None:
    """Write the stresses of the last cycle of the result `out`, once all that can be wrong is known to be right."""
    with open_result(out) as result:
        tractions = TractionHistory(result)
        try:
            steps = last_cycle(result)
            require_states(len(steps))
        except CaseError as error:
            message = error.message.partition(";")[0]
            advice = "`fretsolve stress --step` writes stresses of chosen increments, which this command takes too"
            raise CaseError(f"{message}; {advice}", (), out) from None
        bodies_there = result.effective_case.get("bodies", ())
        for body in bodies or (2,):
            if len(bodies_there) >= body and isinstance(bodies_there[body - 1], dict):
                constants.with_elastic_constants(bodies_there[body - 1]).require(names)
        cell = (tractions.grid.dx, tractions.grid.dy)
        depths: tuple[float, ...] = ()
        if average is not None:
            first, last = average.depth_range
            spread = LINE_DEPTHS if last > first else 1
            depths = tuple(first + (last - first) * k / max(spread - 1, 1) for k in range(spread))
            try:
                average.require_length(cell)
            except CaseError as error:
                raise CaseError(error.message, (), "--average") from None
        request = stress_request(tractions, steps, [1 if body == 1 else 2 for body in bodies], depths)
        if (problem := memory_problem(request, threads, free_bytes(target))) is not None:
            raise CaseError(problem, (), out)
        print_warnings(out, *warnings_of(request, tractions))
        write_stress(tractions, request, target, threads)


def _write(
    out: Path,
    stresses: Path,
    constants: MaterialSource,
    names: tuple[str, ...],
    average: Average | None,
    chosen: Sequence[int],
    target: Path,
    *,
    quiet: bool,
    exclusive: bool,
) -> None:
    """Compute the parameters from a file of stresses, write them to `target`, and print the worst places.

    exclusive: replace no file.
    """
    with open_hdf5(stresses) as file:
        found = bodies_of(file, stresses)
        attributes = dict(file.attrs)
        for number in chosen:
            if number not in found:
                there = " and ".join(f"body {one}" for one in found)
                raise CaseError(f"there are no stresses of body {number}, only of {there}", (), out)
        cycles, materials = {}, {}
        for number, body in found.items():
            if chosen and number not in chosen:
                continue
            own = constants.with_elastic_constants(elastic_body(attributes, number))
            own.require(names)
            cycles[int(number)] = StressCycle(out, body, cycle_of(body, attributes), average)
            materials[int(number)] = own.material
        texts = {"average": "" if average is None else f"{average.kind} over {average.length:g} mm"}
        texts |= {"material": next(iter(materials.values())).model_dump_json(exclude_none=True)}
        texts |= {name: str(attributes[name]) for name in ("title", "result") if name in attributes}
        layers = sum(len(cycle.depths) for cycle in cycles.values())
        with counting_bar("layers", layers, shown=not quiet and sys.stdout.isatty()) as show, writing(target):
            worst, widest = write_fatigue(cycles, materials, names, target, texts, show, exclusive=exclusive)
    if (warning := not_closed(widest)) is not None:
        print_warnings(out, warning)
    if not quiet:
        for line in worst_lines(cycles, worst, average):
            print(line)
        print(target, flush=True)


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
            yield line


def _criteria(texts: Sequence[str]) -> tuple[str, ...]:
    """Return the names of criteria, each once. Raises CaseError."""
    names = [name.strip() for text in texts for name in text.split(",")]
    for name in names:
        if name not in CRITERIA:
            raise CaseError(f"{name!r} is not a criterion; {nearest(name, CRITERIA)}", (), "--criterion")
    return tuple(dict.fromkeys(names))


def _average(text: str | None) -> Average | None:
    """Return an average from a text such as point:20um. Raises CaseError."""
    if text is None:
        return None
    kind, _, length = text.partition(":")
    kinds: tuple[AverageKind, ...] = get_args(AverageKind)
    known = next((one for one in kinds if one == kind.strip()), None)
    if known is None:
        raise CaseError(
            f"{text!r} is not an average; one such as {', '.join(f'{one}:20um' for one in kinds)}", (), "--average"
        )
    try:
        value = to_internal(length, LENGTH)
    except QuantityError as error:
        raise CaseError(str(error), (), "--average") from None
    if value <= 0.0:
        raise CaseError(f"{length!r} is out of range; a length > 0 mm is needed", (), "--average")
    return Average(known, value)
