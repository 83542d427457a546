from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from solving import DISSIMILAR, SIMILAR, build

from fretsolve.case.history import PAIRS
from fretsolve.problem.model.load_path import LoadPath
from fretsolve.problem.model.required_terms import derive_model


def path_of(load_path, **parts):
    case = build(grid={"points": 8}, load_path=load_path, **parts)
    return LoadPath(case.stages(), derive_model(case))


def summary(**values):
    """Return what the load path asks of a history: the loads and displacements of a step."""
    names = [name for pair in PAIRS for name in pair]
    return SimpleNamespace(**(dict.fromkeys(names, 0.0) | values))


def test_a_stage_moves_in_equal_steps():
    path = path_of([{"P": 400.0, "increments": 4}])
    assert [path.increment(step, [summary()] * step).normal.values[0] for step in range(4)] == [100, 200, 300, 400]
    assert path.increments == 4


def test_the_end_of_a_stage_is_exact():
    path = path_of([{"P": 0.1, "increments": 3}, {"P": 0.3, "increments": 7}])
    assert path.increment(2, [summary()] * 2).normal.values[0] == 0.1
    assert path.increment(9, [summary()] * 9).normal.values[0] == 0.3


def test_the_rest_stays_as_it_is():
    path = path_of([{"P": 400.0, "increments": 1}, {"Qx": 20.0, "increments": 2}, {"Mz": 3.0, "increments": 1}])
    last = path.increment(3, [summary()] * 3)
    assert last.normal.values == (400.0, 0.0, 0.0)
    assert last.tangential.values == (20.0, 0.0, 3.0)
    assert last.tangential.forced == (True, True, True)
    assert last.stage.number == 3
    assert last.stage.key == ("load_path", 2)


def test_switching_to_displacement_starts_from_where_the_contact_is():
    path = path_of([{"P": 400.0, "increments": 1}, {"Qx": 20.0, "increments": 1}, {"delta_x": 5e-4, "increments": 4}])
    history = [summary(), summary(delta_x=1e-4), *[summary()] * 3]
    increment = path.increment(2, history[:2])
    assert increment.tangential.forced == (False, True, False)
    assert increment.tangential.values[0] == pytest.approx(2e-4)
    assert path.increment(5, history).tangential.values[0] == 5e-4


def test_switching_back_to_force():
    path = path_of([{"P": 400.0, "increments": 1}, {"delta_x": 5e-4, "increments": 1}, {"Qx": 0.0, "increments": 2}])
    back = path.increment(2, [summary(), summary(Qx=30.0)])
    assert back.tangential.forced[0]
    assert back.tangential.values[0] == pytest.approx(15.0)


def test_cycles_are_unrolled():
    cycle = {"cycle": {"times": 3, "stages": [{"Qx": -36.0, "increments": 2}, {"Qx": 36.0, "increments": 3}]}}
    path = path_of([{"P": 400.0, "increments": 1}, cycle])
    assert path.increments == 1 + 3 * 5
    assert path.last_steps == (0, 2, 5, 7, 10, 12, 15)
    assert path.increment(15, [summary()] * 15).stage.number == 7
    assert path.increment(3, [summary()] * 3).tangential.values[0] == pytest.approx(-36.0 + 72.0 / 3)


class TestAutomaticIncrements:
    @pytest.mark.parametrize(
        ("parts", "stages", "counts"),
        [
            ({"bodies": SIMILAR}, [{"P": 400.0}], [1]),
            ({"bodies": SIMILAR, "friction": 0}, [{"P": 400.0}, {"delta_x": 1e-3}], [1, 1]),
            ({"bodies": DISSIMILAR, "friction": 0}, [{"P": 400.0}], [1]),
            ({"bodies": DISSIMILAR}, [{"P": 400.0}], [24]),
            ({"bodies": DISSIMILAR, "coupling": "tangential"}, [{"P": 400.0}], [1]),
            ({"bodies": SIMILAR}, [{"P": 400.0}, {"Qx": 36.0}], [1, 10]),
            ({"bodies": SIMILAR}, [{"P": 400.0}, {"Qx": 36.0}, {"Qx": -36.0}], [1, 10, 10]),
            ({"bodies": SIMILAR}, [{"P": 400.0}, {"Qx": 36.0}, {"P": 600.0}], [1, 10, 12]),
            ({"bodies": SIMILAR}, [{"P": 400.0}, {"Qx": 36.0}, {"Qx": 0.0}, {"P": 50.0}], [1, 10, 10, 33]),
            ({"bodies": DISSIMILAR}, [{"P": 400.0}, {"Qx": 39.9}, {"Qx": -39.9}], [24, 22, 22]),
            ({"bodies": DISSIMILAR}, [{"P": 400.0}, {"Mz": 2.0}, {"delta_x": 1e-3}], [24, 20, 20]),
            ({"bodies": DISSIMILAR}, [{"delta_z": 9e-3}, {"Qx": 1.0}], [24, 20]),
        ],
    )
    def test_as_many_as_the_stage_needs(self, parts, stages, counts):
        assert path_of(stages, **parts).counts == tuple(counts)

    def test_a_number_given_is_taken(self):
        assert path_of([{"P": 400.0, "increments": 7}], bodies=DISSIMILAR).increments == 7


def test_coupling_that_is_asked_for_between_equal_bodies_takes_no_more_increments():
    assert path_of([{"P": 400.0}], bodies=SIMILAR, coupling="full").increments == 1
    assert path_of([{"P": 400.0}], bodies=DISSIMILAR, coupling="full").increments == 24


def loads(path, stage, name):
    """Return what is imposed at the end of each increment of a stage."""
    first = sum(path.counts[:stage])
    steps = range(first, first + path.counts[stage])
    increments = [path.increment(step, [summary()] * step) for step in steps]
    return np.array([i.normal.values[0] if name == "P" else i.tangential.values[0] for i in increments])


class TestGradedSteps:
    def test_a_growing_load_takes_increments_of_about_equal_radius_that_end_small(self):
        load = loads(path_of([{"P": 400.0}], bodies=DISSIMILAR), 0, "P")
        radius = np.diff(np.concatenate([[0.0], np.cbrt(load / 400.0)]))
        assert radius[1:15] == pytest.approx(radius[1], rel=0.2)
        assert (np.diff(radius[15:]) < 0.0).all()
        assert load[-2] > 0.985 * 400.0
        assert load[-1] == 400.0

    def test_the_stick_radius_falls_in_about_equal_steps(self):
        path = path_of([{"P": 400.0, "increments": 1}, {"Qx": 39.0}, {"Qx": -39.0}], bodies=DISSIMILAR)
        rising, falling = loads(path, 1, "Qx"), loads(path, 2, "Qx")
        radius = np.cbrt(1.0 - rising / 40.0)
        assert -np.diff(radius)[:10] == pytest.approx(-np.diff(radius)[0], rel=0.3)
        assert falling == pytest.approx(39.0 - 2.0 * rising, abs=1e-9)  # after a reversal, half of the change counts

    def test_halved_counts_have_common_points(self):
        """The coarse runs of error bars are compared at these."""
        path = path_of([{"P": 400.0}, {"Qx": 36.0}], bodies=DISSIMILAR)
        doubled = path.with_counts([2 * count for count in path.counts])
        assert loads(doubled, 0, "P")[1::2] == pytest.approx(loads(path, 0, "P"), rel=1e-12)
        assert loads(doubled, 1, "Qx")[1::2] == pytest.approx(loads(path, 1, "Qx"), rel=1e-12)

    def test_the_spacing_can_be_asked_for(self):
        graded = path_of([{"P": 400.0, "increments": 4, "spacing": "graded"}], bodies=SIMILAR)
        equal = path_of([{"P": 400.0, "spacing": "equal"}], bodies=DISSIMILAR)
        assert graded.graded == (True,)
        assert loads(graded, 0, "P")[0] < 90.0
        assert equal.graded == (False,)
        assert loads(equal, 0, "P") == pytest.approx(400.0 / 24.0 * np.arange(1, 25))
