"""The history of a run with very many increments: right rows from anywhere, and little memory for each."""

from __future__ import annotations

import math
import tracemalloc
from dataclasses import MISSING, astuple, fields

import numpy as np
import pytest

from fretsolve.result.history import BLOCK, History
from fretsolve.result.state import Summary


def summary(step: int) -> Summary:
    """Return a summary whose values all differ, with a NaN and a negative zero."""
    values = {one.name: float(step) + 0.125 * place for place, one in enumerate(fields(Summary))}
    counts = {one.name: 7 * step + place for place, one in enumerate(fields(Summary)) if one.type == "int"}
    return Summary(**values | counts | {"step": step, "stick_center_x": math.nan, "Qx": -0.0})


def test_rows_are_the_summaries_that_were_added():
    long = 5 * BLOCK + 3
    history = History(map(summary, range(long)))
    assert len(history) == long
    for step in (0, 1, BLOCK - 1, BLOCK, 4 * BLOCK - 1, 4 * BLOCK, long - 1):
        for found in (history[step], history[step - long]):
            assert repr(found) == repr(summary(step))  # types, NaN and the sign of zero, too
    assert [one.step for one in history[BLOCK - 2 : BLOCK + 2]] == list(range(BLOCK - 2, BLOCK + 2))
    assert [one.step for one in history[-2:]] == [long - 2, long - 1]
    assert [one.step for one in history] == list(range(long))
    assert history[long:] == []
    for outside in (long, -long - 1):
        with pytest.raises(IndexError):
            history[outside]


@pytest.mark.parametrize("count", [0, 1, BLOCK, 3 * BLOCK + 5])
def test_tables_of_records_make_the_same_history(count):
    summaries = [summary(step) for step in range(count)]
    optional = [one.name for one in fields(Summary) if one.default is not MISSING]
    kept = [one for one in fields(Summary) if one.name not in optional]
    types = [(one.name, "i8" if one.type == "int" else "f8") for one in kept]
    rows = np.array([tuple(getattr(one, name) for name, _ in types) for one in summaries], types)
    history = History.of_rows([rows[: count // 3], rows[count // 3 :]])
    defaults = {one.name: one.default for one in fields(Summary) if one.name in optional}
    assert len(history) == count
    for step in range(0, count, 50):
        wanted = vars(summaries[step]) | defaults
        assert repr(astuple(history[step])) == repr(astuple(Summary(**wanted)))
    history.append(summary(count))
    assert (len(history), history[-1].step) == (count + 1, count)


def test_a_long_history_takes_half_a_kilobyte_per_increment():
    one = summary(0)

    def memory(count: int) -> int:
        tracemalloc.start()
        history = History([one] * count)
        taken, _ = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert len(history) == count
        return taken

    assert (memory(16 * BLOCK) - memory(8 * BLOCK)) / (8 * BLOCK) < 600
