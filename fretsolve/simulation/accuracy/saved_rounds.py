"""Solve the rounds of an accuracy into a result, and find the round with which a stopped run goes on.

A round that is complete lies beside the parts of the round that follows it, and becomes the result once no round
follows, or the one that follows has no solution.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from fretsolve.errors import FileError, NoSolutionError
from fretsolve.problem.setup.picked_settings import Picks
from fretsolve.result import HistoryWriter, RunHeader, open_result
from fretsolve.result.header import require_same_run
from fretsolve.result.parts import ROUND_NAME, parts_folder
from fretsolve.result.reader import read_attributes, read_header
from fretsolve.result.verdict import Verdict
from fretsolve.simulation.accuracy.rounds import Judgement, Record, Round, judge, no_solution
from fretsolve.simulation.problem_setup import set_up
from fretsolve.simulation.run_to_file import run_header

ROUNDS, PICKED_KEYS = "rounds", "picked_keys"
"""Names of the rounds that are done, and of the keys of the case that the rounds pick, in a result's provenance."""

HeaderOf = Callable[[Round], RunHeader]
"""Returns the header of a round's result."""


def begun_round(first: Round, out: Path, header_of: HeaderOf) -> Round:
    """Return the round to go on with: of the parts of `out`, after the round beside them, or of `out` itself.

    Where there is nothing it is the first round. A damaged file is reported by the writer that goes on with it.
    Raises FileError if the round beside the parts belongs to another run.
    """
    folder = parts_folder(out)
    if first.asked.solver.accuracy is None and (out.exists() or not (folder / ROUND_NAME).exists()):
        return first
    with suppress(OSError, FileError):
        return _round_of(read_header(folder).attributes("stopped"), first)
    file = out if out.exists() else folder / ROUND_NAME
    if not file.exists():
        return first
    try:
        attributes = read_attributes(file)
    except (OSError, FileError):
        return first
    done = _round_of(attributes, first)
    if file == out:
        return done
    require_same_run(file, attributes, header_of(done))
    return judged_round(done, file).following or done


def _round_of(attributes: Mapping[str, Any], first: Round) -> Round:
    """Return the round that a result or its parts hold, by their attributes."""
    with suppress(KeyError, TypeError, ValueError):
        effective, done = (json.loads(attributes[name]) for name in ("effective_case", "provenance"))
        points, refinement = effective["grid"]["points"], effective["solver"]["refinement"]
        shape = (points, 1) if isinstance(points, int) else (points[0], points[1])
        before = tuple(Record(**{**one, "points": tuple(one["points"])}) for one in done[ROUNDS])
        setup = set_up(first.asked, first.compiled, Picks(shape, refinement))
        return replace(first, setup=setup, before=before)
    return first


def in_provenance(current: Round) -> dict[str, Any]:
    """Return the rounds that are done as the provenance of a result has them; nothing without an accuracy."""
    if current.asked.solver.accuracy is None:
        return {}
    return {ROUNDS: [asdict(one) for one in current.before], PICKED_KEYS: current.picked_keys}


def solve_rounds(
    writer: HistoryWriter,
    begun: Round,
    header_of: HeaderOf,
    solve: Callable[[Round], bool],
    prepared: Callable[[Round], Round] = lambda current: current,
) -> tuple[Round, Verdict | None] | None:
    """Solve a round and all that follow, and let the last one be the result; return it, or None after a stop.

    solve: solves what is missing of a round into `writer`, and returns whether it is complete; prepared: returns a
    round as it is to be solved. If a later round has no solution, the round before it is the result. Raises
    NoSolutionError if the first round has none, FileError.
    """
    current = begun
    if current.asked.solver.accuracy is None:
        return (current, None) if writer.complete or solve(current) else None
    if writer.complete and not _has_other_limits(current, writer.out):
        return current, None
    while True:
        began = time.perf_counter()
        try:
            if not (writer.complete or writer.holds_round or solve(current)):
                return None
        except NoSolutionError as error:
            if not current.before:
                raise
            before = _round_of(read_attributes(writer.out), begun)
            verdict = judged_round(before, writer.out).verdict
            assert verdict is not None
            return before, replace(verdict, reason=no_solution(current, error))
        file = writer.out if writer.complete else writer.round
        found = judged_round(current, file, time.perf_counter() - began)
        if found.following is None:
            if not writer.complete:
                writer.give_round()
            return current, found.verdict
        current = prepared(found.following)
        writer.begin_round(header_of(current))


def _has_other_limits(current: Round, out: Path) -> bool:
    """Return whether the complete result `out` was to keep to other limits than the case does now."""
    there, here = json.loads(read_attributes(out)["effective_case"]), current.setup.case.effective()
    limits = [case["solver"]["accuracy"]["at_most"] for case in (there, here)]
    return bool(limits[0] != limits[1])


def judged_round(done: Round, file: Path, elapsed: float = 0.0) -> Judgement:
    """Judge the round whose result is `file`; elapsed: seconds since the round began. Raises FileError."""
    with open_result(file) as result:
        return judge(done, result.history, result.cycle_columns, elapsed)


def header_of_round(threads: int, overrides: Sequence[str], current: Round) -> RunHeader:
    """Return the header of the result of a round, see `run_header`."""
    return run_header(current.setup, threads, overrides, in_provenance(current))
