from __future__ import annotations

from dataclasses import asdict, fields
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from small_cases import SPHERE, write_case
from solving import DISSIMILAR, build

from fretsolve import load_case, run
from fretsolve.elastic import convolution, fftw, thread_team
from fretsolve.errors import CaseError, SlidingError
from fretsolve.simulation.simulation import set_up

PARTS = {
    "bodies": DISSIMILAR,
    "grid": {"points": [54, 47], "size": [0.8, 0.78]},
    "load_path": [
        {"P": 400.0, "increments": 2},
        {"Qx": 25.0, "Mz": 1.0, "increments": 2},
        {"delta_x": -2e-4, "increments": 2},
        {"P": 300.0, "increments": 2},
    ],
}


@pytest.fixture(scope="module")
def states():
    return list(run(build(**PARTS)))


def assert_same(found, wanted):
    for part in ("pressure", "shear", "slip", "slip_path", "work_density", "zone", "gap"):
        np.testing.assert_array_equal(getattr(found.fields, part), getattr(wanted.fields, part))
    np.testing.assert_array_equal(found.displacement, wanted.displacement)
    without_time = [{k: v for k, v in asdict(s.summary).items() if k != "wall_time"} for s in (found, wanted)]
    assert without_time[0] == without_time[1]


@pytest.mark.parametrize("done", [1, 3, 5])
def test_resuming_gives_the_same_to_the_last_bit(states, done):
    """From a stage's middle, and from one that switches control and so looks back in the history."""
    history = [state.summary for state in states[:done]]
    resumed = list(run(build(**PARTS), states[done - 1], history))
    assert len(resumed) == len(states) - done
    for found, wanted in zip(resumed, states[done:], strict=True):
        assert_same(found, wanted)


@pytest.mark.slow
def test_threads_change_no_bit(monkeypatch):
    monkeypatch.setattr(convolution, "MOST_BATCHED_POINTS", 0)
    monkeypatch.setattr(fftw, "CACHE_BYTES", 2048)  # blocks enough to share out
    monkeypatch.setattr(thread_team, "PART_CELLS", 64)
    for found, wanted in zip(run(build(**PARTS), threads=3), run(build(**PARTS)), strict=True):
        assert_same(found, wanted)


def test_summary_follows_from_the_fields(states):
    grid = set_up(build(**PARTS)).grid
    for state in states:
        summary, zone = state.summary, state.fields.zone
        found = [part.sum() * grid.cell_area for part in (state.fields.pressure, *state.fields.shear)]
        assert found == pytest.approx([summary.P, summary.Qx, summary.Qy], abs=1e-12)
        assert (summary.contact_cells, summary.stick_cells) == (np.count_nonzero(zone), np.count_nonzero(zone == 1))
        # A front lies within a cell of the count's: a ring of two thirds of a cell at most.
        for area, cells in ((summary.contact_area, summary.contact_cells), (summary.stick_area, summary.stick_cells)):
            counted = cells * grid.cell_area
            assert abs(area - counted) < 0.7 * np.sqrt(np.pi * counted * grid.cell_area) * 2
        assert np.pi * summary.contact_radius**2 == pytest.approx(summary.contact_area)
        assert np.pi * summary.stick_radius**2 == pytest.approx(summary.stick_area)
        assert summary.max_pressure == state.fields.pressure.max()
        assert summary.max_shear == pytest.approx(np.hypot(*state.fields.shear).max(), rel=1e-15)
        assert summary.wall_time > 0.0
        assert all(type(getattr(summary, field.name)) in (int, float) for field in fields(summary))


def test_states_do_not_share_what_later_increments_write(states):
    """A state that is kept must not change while the run goes on."""
    kept = []
    for state in run(build(**PARTS)):
        kept.append((state, state.fields.pressure.copy(), state.fields.shear.copy(), state.displacement.copy()))
    for state, pressure, shear, displacement in kept:
        np.testing.assert_array_equal(state.fields.pressure, pressure)
        np.testing.assert_array_equal(state.fields.shear, shear)
        np.testing.assert_array_equal(state.displacement, displacement)


class TestErrorsAreLocated:
    TEXT = f"""\
{SPHERE}load_path:
  - {{P: 400 N}}
  - cycle:
      times: 2
      stages:
        - {{Qx: 10 N, increments: 1}}
        - {{Qx: 60 N, increments: 1}}
"""

    def located(self, folder: Path, text: str, kind):
        path = write_case(folder, text)
        with pytest.raises(kind) as caught:
            list(run(load_case(path)))
        return path, caught.value

    def test_sliding_in_a_cycle(self, tmp_path):
        path, error = self.located(tmp_path, self.TEXT, SlidingError)
        assert str(error).startswith(f"{path}:13: stage.3.Qx: gross slip")
        assert str(error).endswith("(increment 2, stage 3)")

    def test_no_size_to_be_found(self, tmp_path):
        text = self.TEXT.replace("sphere: {radius: 10 mm}", "cylinder: {radius: 10 mm, axis: x}")
        path, error = self.located(tmp_path, text, CaseError)
        assert str(error).startswith(f"{path}:5: grid.size: auto finds no size that holds the contact")

    def test_map_that_does_not_fit(self, tmp_path):
        np.save(tmp_path / "map.npy", np.zeros(5))
        text = self.TEXT.replace("sphere: {radius: 10 mm}", "heights: {file: map.npy, spacing: 1 um}")
        path, error = self.located(tmp_path, text.replace("points: 16", "points: 16, size: 1 um"), CaseError)
        assert str(error).startswith(f"{path}:4: surface")


def test_states_cannot_be_written_to():
    """The next increment starts from the arrays that were given out."""
    (state,) = run(build(grid={"points": 16, "size": 0.8}, load_path=[{"P": 400.0}]))
    for array in (*vars(state.fields).values(), state.displacement):
        assert array is None or not array.flags.writeable


def test_work_is_the_sum_of_its_density():
    path = [{"P": 400.0}, *({"Qx": force, "increments": 3} for force in (30.0, -30.0))]
    states = list(run(build(bodies=DISSIMILAR, grid={"points": 24, "size": 0.72}, load_path=path)))
    for before, after in pairwise(states):
        assert after.summary.work_total == pytest.approx(after.fields.work_density.sum() * 0.03**2, rel=1e-12)
        assert after.summary.work_total - before.summary.work_total == pytest.approx(after.summary.work, abs=1e-15)
        assert (after.fields.work_density >= before.fields.work_density).all()
    assert states[-1].summary.work_total > 0.0


@pytest.mark.parametrize("compiled", ["0", "1"])
def test_after_a_loss_of_contact_the_stick_zone_is_that_of_a_first_shear(monkeypatch, compiled):
    monkeypatch.setenv("FRETSOLVE_NUMBA", compiled)
    path = [{"P": 400.0}, {"Qx": 30.0, "increments": 3}, {"Qx": 0.0, "increments": 2}, {"P": 0.0, "increments": 2}]
    path += [{"P": 400.0}, {"Qx": 30.0, "increments": 3}]
    found = list(run(build(grid={"points": 40, "size": 0.7}, friction=0.1, load_path=path)))
    first, again = found[3].summary, found[-1].summary
    assert found[7].summary.contact_cells == 0 and first.stick_radius < 0.7 * first.contact_radius
    assert again.stick_radius == pytest.approx(first.stick_radius, rel=1e-5)
    assert again.stick_half_width_x == pytest.approx(first.stick_half_width_x, rel=1e-5)
