"""The fields before the first increment, and what the next one starts from."""

from __future__ import annotations

import numpy as np
import pytest
from solving import DISSIMILAR, build, solve

from fretsolve.elastic import thread_team
from fretsolve.result.state import Zone
from fretsolve.setup.problem_setup import set_up
from fretsolve.simulation.fields_of_increment import precision_of, unloaded

PATH = [{"P": 400.0}, {"Qx": 20.0, "increments": 2}]


def test_unloaded_surfaces_touch_at_their_nearest_points():
    separation = np.array([[3.0, 1.0], [np.inf, 2.5]])
    fields, displacement = unloaded(separation)
    assert fields.gap.tolist() == [[2.0, 0.0], [np.inf, 1.5]]
    assert not any(np.any(field) for field in (fields.pressure, fields.shear, fields.slip, fields.zone, displacement))
    assert fields.shear.shape == displacement.shape == (2, 2, 2)


def test_without_material_there_is_a_gap_everywhere():
    assert np.isinf(unloaded(np.full((2, 2), np.inf))[0].gap).all()


@pytest.mark.parametrize(("precision", "dtype"), [("double", np.float64), ("single", np.float32)])
def test_states_keep_the_precision_and_cannot_be_written_to(precision, dtype):
    parts = {"grid": {"points": 12}, "load_path": PATH, "solver": {"precision": precision, "tolerance": 1e-4}}
    assert precision_of(set_up(build(**parts))) is dtype
    before, last = solve(**parts)[-2:]
    for name in ("pressure", "shear", "slip", "slip_path", "work_density", "gap"):
        field = getattr(last.fields, name)
        assert field.dtype == dtype
        assert not field.flags.writeable
    # slip, its path and the energy go on from those before
    slip = last.fields.slip - before.fields.slip
    path = last.fields.slip_path - before.fields.slip_path
    np.testing.assert_allclose(path, np.hypot(*slip), atol=1e-6 * np.abs(last.fields.slip).max())
    cell = np.prod([0.0 + side / 12 for side in set_up(build(**parts)).grid.size])
    work = (last.fields.work_density - before.fields.work_density).sum(dtype=np.float64) * cell
    assert work == pytest.approx(last.summary.work, rel=1e-4)


def test_fields_in_parts_are_those_of_the_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    """Friction differs from part to part, and cells of each part slip, stick and open."""
    path = [{"P": 400.0, "increments": 2}, {"Qx": 10.0, "increments": 2}, {"P": 150.0, "increments": 2}]
    parts = {"bodies": DISSIMILAR, "grid": {"points": 17}, "friction": {"expression": "0.1 + 0.1*x"}, "load_path": path}
    whole = solve(**parts)
    assert (whole[-1].fields.zone[[4, 12]] == Zone.OPEN).any(axis=1).all()
    monkeypatch.setattr(thread_team, "parts_of", lambda shape: [(0, 5), (5, 9), (9, shape[0])])
    for found, wanted in zip(solve(**parts), whole, strict=True):
        assert found.summary.work == pytest.approx(wanted.summary.work, rel=1e-7)
        for name in ("slip", "slip_path", "work_density"):
            one, other = getattr(found.fields, name), getattr(wanted.fields, name)
            np.testing.assert_allclose(one, other, atol=1e-7 * np.abs(other).max(), err_msg=name)


def test_friction_and_its_limit_are_kept_where_the_case_asks_for_them():
    fields = ["pressure", "shear", "friction", "shear_bound"]
    friction = {"expression": "0.1 + 0.2*x"}
    (state,) = solve(grid={"points": 12}, friction=friction, output={"fields": fields})
    assert state.fields.friction is not None and state.fields.shear_bound is not None
    np.testing.assert_allclose(state.fields.shear_bound, state.fields.friction * state.fields.pressure, rtol=1e-12)
    x = set_up(build(grid={"points": 12}, friction=friction)).grid.x
    np.testing.assert_allclose(state.fields.friction, np.repeat(0.1 + 0.2 * x[:, None], 12, axis=1), rtol=1e-9)
