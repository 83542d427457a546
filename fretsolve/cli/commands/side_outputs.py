"""Side outputs of a run: stresses below the surface, fatigue parameters and a crack, if the case asks for them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fretsolve.case.models import Case
from fretsolve.cli.commands.computed_files import FileOrder
from fretsolve.cli.commands.crack import write_crack_with_messages
from fretsolve.cli.commands.fatigue import write_fatigue_with_messages
from fretsolve.cli.commands.stress import write_stress_with_messages
from fretsolve.errors import FileError
from fretsolve.post.crack.request import case_request as crack_request
from fretsolve.post.crack.request import require_crack
from fretsolve.post.fatigue.request import case_request as fatigue_request
from fretsolve.post.fatigue.request import require_fatigue
from fretsolve.post.names import crack_path, fatigue_path, stress_path
from fretsolve.post.stress.computed_file import is_made_from, opened_computed
from fretsolve.post.stress.request import case_request as stress_request
from fretsolve.post.stress.request import increments_before, request_before, room_problem
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.problem.setup.cost_estimate import free_bytes
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result import HistoryWriter, Result, RunHeader, open_result
from fretsolve.result.header import is_same_run
from fretsolve.system import atomic_files
from fretsolve.system.files import require_free, require_utf8, writing

AT_END = "the result is whole: with more room --resume writes what output.{} asks for"
"""Advice where there is no room for side outputs."""

RESULT_IS_THERE = "--resume goes on and writes what is missing beside it, --overwrite begins anew"
"""Advice for an existing result of a case with side outputs."""


def require_room(setup: ProblemSetup, out: Path) -> None:
    """Raise CaseError, before the run, if what the case asks for beside the result cannot be computed after it."""
    output = setup.case.output
    if (spec := output.stress) is not None:
        stages = len(setup.load_path.last_steps)
        count = increments_before(spec, -(-setup.load_path.increments // output.every), stages)
        request = request_before(spec.bodies, spec.depths, count, setup.grid.shape, spec.window, spec.components)
        if (problem := room_problem(request, free_bytes(out))) is not None:
            raise setup.case.source.problem(problem, ("output", "stress"))
    if output.fatigue is not None:
        require_fatigue(setup, free_bytes(out))
    if output.crack is not None:
        require_crack(setup)


def require_own_side_outputs(
    setup: ProblemSetup, out: Path, header: RunHeader, *, resume: bool, overwrite: bool
) -> None:
    """Raise CaseError, before the run, if what the case asks for would replace files that are not the run's own.

    The result itself is told of first: a run goes on with it, and with the files beside it.

    Raises FileError if the side outputs cannot hold the name of the result.
    """
    output = setup.case.output
    require_utf8(out.name, out)
    require_free(out, overwrite=resume or overwrite, advice=RESULT_IS_THERE)
    for spec, kind, path in (
        (output.stress, "stress", stress_path(out)),
        (output.fatigue, "fatigue", fatigue_path(out)),
        (output.crack, "crack", crack_path(out)),
    ):
        if spec is None:
            continue
        if path.is_symlink() and not path.exists():
            raise FileError("is a link to a file that does not exist; remove it, or give another name", path)
        own = not overwrite and resume and _is_own(path, kind, header.attributes("running"))
        advice = "the run would replace it by what output asks for: move it away, or give --overwrite"
        require_free(path, overwrite=overwrite or own, advice=advice)


def _is_own(path: Path, kind: str, attributes: Mapping[str, Any]) -> bool:
    """Return whether a file was computed from a run that gives the same numbers. Raises FileError if it is damaged."""
    with opened_computed(path) as found:
        return found is not None and found.kind == kind and is_same_run(found.attributes, attributes)


def write_side_outputs(
    case: Case, writer: HistoryWriter, threads: int, *, quiet: bool, overwrite: bool, missing: bool = False
) -> None:
    """Write and print the stresses, the fatigue parameters and the crack that the case asks for.

    writer: of the result, which is whole; overwrite: replace any file, otherwise only files of this run; missing: write
    only absent files.
    """
    out, stress, fatigue = writer.out, case.output.stress, case.output.fatigue

    def order(kind: str, target: Path, result: Result) -> FileOrder:
        folder = writer.working_folder()
        if not overwrite and _is_own(target, kind, result.attributes):
            with writing(target):
                atomic_files.remove(target)  # a file of this run, so that no other file can be replaced
        return FileOrder(target, threads, quiet, not overwrite, AT_END.format(kind), folder)

    with open_result(out) as result:
        tractions = TractionHistory(result)
        if stress is not None and not (missing and is_made_from(result, stress_path(out))):
            request = stress_request(tractions, stress)
            write_stress_with_messages(tractions, request, order("stress", stress_path(out), result))
        if fatigue is not None and not (missing and is_made_from(result, fatigue_path(out))):
            asked = fatigue_request(case)
            write_fatigue_with_messages(tractions, asked, order("fatigue", fatigue_path(out), result))
        if case.output.crack is not None and not (missing and is_made_from(result, crack_path(out))):
            write_crack_with_messages(tractions, crack_request(case), order("crack", crack_path(out), result))
