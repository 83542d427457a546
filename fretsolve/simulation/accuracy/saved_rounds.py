"""Find the round of an accuracy that a result holds, or the parts of a result, to go on with it."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

from fretsolve.errors import FileError
from fretsolve.problem.setup.picked_settings import Picks
from fretsolve.result import HistoryWriter, RunHeader, open_result
from fretsolve.result.parts import parts_folder
from fretsolve.result.reader import read_attributes, read_header
from fretsolve.simulation.accuracy.rounds import End, Record, Round, next_round, seconds_of
from fretsolve.simulation.problem_setup import set_up
from fretsolve.simulation.run_to_file import Stop, run_header

ROUNDS, PICKED_KEYS = "rounds", "picked_keys"
"""Names of the rounds that are done, and of the keys of the case that the rounds pick, in a result's provenance."""


def begun_round(first: Round, out: Path) -> Round:
    """Return the round that the parts of `out`, or `out` itself, hold; the first round where there are none.

    Without an accuracy there is but one. A damaged file is reported by the writer that goes on with it.
    """
    case = first.asked
    if case.solver.accuracy is not None and (attributes := _attributes(out)) is not None:
        with suppress(KeyError, TypeError, ValueError):
            effective = json.loads(attributes["effective_case"])
            done = json.loads(attributes["provenance"]).get(ROUNDS, [])
            points = effective["grid"]["points"]
            shape = (points, 1) if isinstance(points, int) else (points[0], points[1])
            before = tuple(Record(**{**one, "points": (one["points"][0], one["points"][1])}) for one in done)
            return Round(
                case, set_up(case, first.setup.compiled, Picks(shape, effective["solver"]["refinement"])), before
            )
    return first


def _attributes(out: Path) -> Mapping[str, Any] | None:
    with suppress(OSError, FileError):
        return read_header(parts_folder(out)).attributes("stopped")
    with suppress(OSError, FileError):
        return read_attributes(out)
    return None


def in_provenance(rounds: Round) -> dict[str, Any]:
    """Return the rounds that are done as the provenance of a result has them; nothing without an accuracy."""
    if rounds.asked.solver.accuracy is None:
        return {}
    keys = {"grid.points": rounds.picks_points, "solver.refinement": rounds.picks_increments}
    return {
        ROUNDS: [asdict(one) for one in rounds.before],
        PICKED_KEYS: [key for key, is_picked in keys.items() if is_picked],
    }


def rounds_into(
    writer: HistoryWriter, first: Round, header_of: Callable[[Round], RunHeader], stop: Stop
) -> Iterator[Round]:
    """Yield one round after the other, each to be solved into the result of `writer` before the next one is asked for.

    header_of: returns the header of a round's result; stop: after which no round begins. Raises FileError.
    """
    current = first
    while True:
        yield current
        following = after(current, writer.out)
        if isinstance(following, End) or stop.requested:
            return
        current = following
        writer.begin_anew(header_of(current))


def after(done: Round, out: Path) -> Round | End:
    """Return the round that follows the round whose result is `out`, or why there is none."""
    if done.asked.solver.accuracy is None:
        return End(None)
    with open_result(out) as result:
        return next_round(done, result.history, result.cycle_columns, seconds_of(result.history))


def header_of_round(threads: int, overrides: Sequence[str], current: Round) -> RunHeader:
    """Return the header of the result of a round, see `run_header`."""
    return run_header(current.setup, threads, overrides, in_provenance(current))
