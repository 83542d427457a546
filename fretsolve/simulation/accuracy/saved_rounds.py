"""Find the round of an accuracy that a result holds, or the parts of a result, to go on with it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

from fretsolve.case.models import Case
from fretsolve.errors import FileError
from fretsolve.problem.setup.picked_settings import Picks
from fretsolve.result import open_result
from fretsolve.result.parts import parts_folder
from fretsolve.result.reader import read_attributes, read_header
from fretsolve.simulation.accuracy.rounds import End, Record, Round, first_round, next_round, seconds_of
from fretsolve.simulation.problem_setup import set_up

ROUNDS = "rounds"
"""Name of the rounds that are done, in the provenance of a result."""


def begun_round(case: Case, out: Path, compiled: bool | None = None) -> Round:
    """Return the round that the parts of `out`, or `out` itself, hold; the first round where there are none.

    Without an accuracy there is but one. A damaged file is reported by the writer that goes on with it.
    """
    if case.solver.accuracy is not None and (attributes := _attributes(out)) is not None:
        with suppress(KeyError, TypeError, ValueError):
            effective = json.loads(attributes["effective_case"])
            done = json.loads(attributes["provenance"]).get(ROUNDS, [])
            points = effective["grid"]["points"]
            shape = (points, 1) if isinstance(points, int) else (points[0], points[1])
            before = tuple(Record(**{**one, "points": (one["points"][0], one["points"][1])}) for one in done)
            return Round(case, set_up(case, compiled, Picks(shape, effective["solver"]["refinement"])), before)
    return first_round(case, compiled)


def _attributes(out: Path) -> Mapping[str, Any] | None:
    with suppress(OSError, FileError):
        return read_header(parts_folder(out)).attributes("stopped")
    with suppress(OSError, FileError):
        return read_attributes(out)
    return None


def in_provenance(rounds: Round) -> dict[str, Any]:
    """Return the rounds that are done as the provenance of a result has them; nothing without an accuracy."""
    return {} if rounds.asked.solver.accuracy is None else {ROUNDS: [asdict(one) for one in rounds.before]}


def after(done: Round, out: Path) -> Round | End:
    """Return the round that follows the round whose result is `out`, or why there is none."""
    if done.asked.solver.accuracy is None:
        return End(None)
    with open_result(out) as result:
        return next_round(done, result.history, result.cycle_columns, seconds_of(result.history))
