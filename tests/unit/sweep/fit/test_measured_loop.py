"""Cutting a record into the half cycles of its last whole cycle."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from fitting import mindlin_branch, record

from fretsolve.errors import CaseError
from fretsolve.sweep.fit.measured_loop import MeasuredLoop, cut, noise_of

BRANCH = mindlin_branch(0.1, 50e3, 4e-3)
FILE = Path("loop.csv")


def cut_record(offset: bool = True, **options: float | bool) -> MeasuredLoop:
    _, force, motion = record(BRANCH, **options)
    return cut(force, motion, FILE, offset=offset)


@pytest.mark.parametrize("start", [0.0, 0.1, 0.25, 0.3, 0.5, 0.75, 0.9])
@pytest.mark.parametrize("cycles", [1.0, 1.6, 3.2])
def test_records_that_start_anywhere(start: float, cycles: float) -> None:
    loop = cut_record(start=start, cycles=cycles, drifts=False)
    assert abs(len(loop.force) - 200) <= 2
    np.testing.assert_allclose(np.abs(loop.ends), 4e-3, rtol=2e-3)
    assert loop.ends[0] == pytest.approx(-loop.ends[1], rel=1e-3)
    for branch, (start_of_it, end) in enumerate(zip(loop.ends, loop.ends[1:], strict=False)):
        motion = loop.motion[loop.branch == branch]
        assert np.all(np.sign(end - start_of_it) * np.diff(motion) >= 0.0)


def test_offset_and_drift_of_the_motion_are_taken_out() -> None:
    drifting, still = cut_record(), cut_record(drifts=False)
    np.testing.assert_allclose(drifting.motion, still.motion, atol=1e-5)
    assert drifting.ends[0] == drifting.ends[2] == -drifting.ends[1]


def test_without_offset_the_motion_stays_as_measured() -> None:
    _, force, motion = record(BRANCH)
    loop = cut(force, motion, FILE, offset=False)
    order = np.round(loop.time * len(loop.time)).astype(int)
    np.testing.assert_allclose(loop.motion, motion[order], atol=1e-6)
    # turns at 1.25, 1.75, 2.25 cycles: +-1 with an offset of 0.3 and a drift of 0.02
    np.testing.assert_allclose(loop.ends, 4e-3 * np.array([1.325, -0.665, 1.345]), rtol=2e-3)


def test_noise_turns_nothing_and_hardly_moves_the_turns() -> None:
    ends = np.array([cut_record(seed=seed, noise=0.01, shake=0.01).ends[:2] for seed in range(20)])
    np.testing.assert_allclose(np.abs(ends).mean(), 4e-3, rtol=2e-3)
    assert np.abs(np.abs(ends) - 4e-3).max() < 0.01 * 4e-3


def test_edge_of_a_triangle() -> None:
    motion = np.abs((np.arange(450) / 100.0 + 0.5) % 2.0 - 1.0) * 8e-3 - 4e-3
    loop = cut(motion * 1e4, motion, FILE, offset=True)
    np.testing.assert_allclose(np.abs(loop.ends), 4e-3, rtol=1e-9)


def test_scatter_along_a_record() -> None:
    random = np.random.default_rng(3)
    smooth = np.sin(np.linspace(0.0, 12.0, 600))
    assert noise_of(smooth) < 1e-4
    assert noise_of(smooth + random.normal(0.0, 0.02, 600)) == pytest.approx(0.02, rel=0.15)


@pytest.mark.parametrize(("cycles", "times"), [(0.2, "does not turn"), (0.4, "turns once"), (0.85, "turns twice")])
def test_no_whole_cycle(cycles: float, times: str) -> None:
    with pytest.raises(CaseError) as caught:
        cut_record(start=0.1, cycles=cycles)
    said = f"loop.csv: holds no whole cycle: the motion {times}; a motion there and back is needed"
    assert str(caught.value) == said


def test_cycle_of_few_points() -> None:
    with pytest.raises(CaseError) as caught:
        cut_record(points=8, cycles=3.0)
    assert str(caught.value).endswith("points; at least 10 are needed")
