"""Solving loops on several processes, and values that have no solution."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from fitting import FIT_CASE, mindlin_branch, record, write_record
from small_cases import write_case

import fretsolve.sweep.fit.evaluation as evaluation
from fretsolve.sweep.fit.evaluation import LoopSolver
from fretsolve.sweep.fit.model_loop import LoopModel
from fretsolve.sweep.fit.plan import FitRequest, make_fit_plan


@pytest.fixture
def model(tmp_path: Path) -> LoopModel:
    loop = write_record(tmp_path / "loop.csv", record(mindlin_branch(0.1, 50e3, 4e-3)))
    case = write_case(tmp_path, FIT_CASE.replace("points: 24", "points: 8"))
    return make_fit_plan(FitRequest(case, (), loop, ("friction",))).models[0]


@pytest.mark.slow
def test_processes_give_the_same_bits(model: LoopModel, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(evaluation, "WORTH_PROCESSES", 0.0)
    points = [[0.1], [0.12], [0.15]]
    with closing(LoopSolver(1)) as one, closing(LoopSolver(2)) as two:
        two.solve(model, [[0.11]])
        for here, there in zip(one.solve(model, points), two.solve(model, points), strict=True):
            assert here is not None
            assert there is not None
            np.testing.assert_array_equal(here.force, there.force)
        assert (one.solved, two.solved) == (3, 4)


def test_values_that_the_case_refuses_have_no_loop(model: LoopModel) -> None:
    assert LoopSolver(1).solve(model, [[-0.1]]) == [None]
