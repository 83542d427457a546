"""Cases are put into tasks for Dask."""

from __future__ import annotations

from dataclasses import replace

from fretsolve.sweep.dask import TASKS_PER_THREAD, in_tasks
from fretsolve.sweep.manifest import Manifest


def test_tasks_are_some_per_thread_more_of_long_cases_and_have_each_case_once(manifest: Manifest) -> None:
    def tasks(count: int, seconds: float) -> list[Manifest]:
        rows = [replace(manifest.rows[0], index=index, seconds=seconds) for index in range(count)]
        found = in_tasks(manifest, rows, threads=2)
        assert sorted(row.index for task in found for row in task.rows) == list(range(count))
        return found

    assert len(tasks(4, 0.1)) == 4
    assert len(tasks(100, 0.01)) == 2 * TASKS_PER_THREAD
    assert len(tasks(1000, 0.1)) == 100
    assert len(tasks(1000, 600.0)) == 1000
    assert [row.index for row in tasks(40, 0.01)[0].rows] == [0, 20]
