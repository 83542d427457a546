"""Write what a case asks for beside its result: stresses and fatigue parameters at the end of the run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fretsolve.case.models import Case
from fretsolve.errors import FileError
from fretsolve.result import Result, RunHeader, open_result
from fretsolve.setup.cost_estimate import free_bytes
from fretsolve.setup.problem_setup import ProblemSetup
from fretsolve.system import atomic_files
from fretsolve.system.files import require_free, require_utf8, writing

AT_END = "the result is whole: with more room --resume writes what output.{} asks for"
"""Advice where there is no room for files beside a result."""


def require_room(setup: ProblemSetup, out: Path) -> None:
    """Raise CaseError, before the run, if stresses or fatigue that the case asks for cannot be computed after it."""
    output = setup.case.output
    if (spec := output.stress) is not None:
        from fretsolve.stress.of_case import increments_before, request_before, room_problem

        stages = len(setup.load_path.last_steps)
        count = increments_before(spec, -(-setup.load_path.increments // output.every), stages)
        request = request_before(spec.bodies, spec.depths, count, setup.grid.shape, spec.window, spec.components)
        if (problem := room_problem(request, free_bytes(out))) is not None:
            raise setup.case.source.problem(problem, ("output", "stress"))
    if output.fatigue is not None:
        from fretsolve.fatigue.of_case import require_fatigue

        require_fatigue(setup, free_bytes(out))


def require_own_beside(setup: ProblemSetup, out: Path, header: RunHeader, *, resume: bool, overwrite: bool) -> None:
    """Raise CaseError, before the run, if what the case asks for would replace files that are not the run's own.

    Raises FileError if those files cannot hold the name of the result.
    """
    output = setup.case.output
    if output.stress is None and output.fatigue is None:
        return
    require_utf8(out.name, out)
    from fretsolve.fatigue.names import fatigue_path
    from fretsolve.stress.names import stress_path

    for spec, kind, path in (
        (output.stress, "stress", stress_path(out)),
        (output.fatigue, "fatigue", fatigue_path(out)),
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
    from fretsolve.result.header import is_same_run
    from fretsolve.stress.names import opened_computed

    with opened_computed(path) as found:
        return found is not None and found.kind == kind and is_same_run(found.attributes, attributes)


def write_beside(case: Case, out: Path, threads: int, *, quiet: bool, overwrite: bool, missing: bool = False) -> None:
    """Write and print the stresses and fatigue parameters that the case asks for.

    overwrite: replace any file, otherwise only those of the same run; missing: unless they are there.
    """
    stress, fatigue = case.output.stress, case.output.fatigue
    if stress is None and fatigue is None:
        return
    from fretsolve.commands.fatigue import write_fatigue_with_messages
    from fretsolve.commands.stress import FileOrder, write_with_messages
    from fretsolve.fatigue import of_case as fatigue_of_case
    from fretsolve.fatigue.names import fatigue_path
    from fretsolve.stress.names import is_made_from, stress_path
    from fretsolve.stress.of_case import case_request
    from fretsolve.stress.tractions import TractionHistory

    with open_result(out) as result:
        tractions, target = TractionHistory(result), stress_path(out)
        if stress is not None and not (missing and is_made_from(result, target)):
            request = case_request(tractions, stress)
            _make_room(target, "stress", result, overwrite=overwrite)
            order = FileOrder(target, threads, quiet, not overwrite, AT_END.format("stress"))
            write_with_messages(tractions, request, order)
        target = fatigue_path(out)
        if fatigue is not None and not (missing and is_made_from(result, target)):
            asked = fatigue_of_case.case_request(case)
            _make_room(target, "fatigue", result, overwrite=overwrite)
            order = FileOrder(target, threads, quiet, not overwrite, AT_END.format("fatigue"))
            write_fatigue_with_messages(tractions, asked, order)


def _make_room(target: Path, kind: str, result: Result, *, overwrite: bool) -> None:
    """Remove a file of the same run, so that no other one can be replaced. Raises FileError."""
    if not overwrite and _is_own(target, kind, result.attributes):
        with writing(target):
            atomic_files.remove(target)
