from __future__ import annotations

import tracemalloc
from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from solving import DISSIMILAR, SIMILAR, build

from fretsolve.case.history import PAIRS
from fretsolve.problem.model.load_path import LoadPath, imposed_along
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


def blocks(count, **cycle):
    stages = [{"Qx": 18.0, "increments": 2}, {"Qx": -18.0, "increments": 3}]
    return [
        {"P": 400.0, "increments": 2},
        {"cycle": {"stages": stages, **(cycle or {"times": count})}},
        {"Qx": 5.0, "increments": 1},
    ]


def stage_by_search(path, step):
    """Return the number of the stage of a step by going through all stages."""
    return next(stage.number for stage, last in zip(path.stages, path.last_steps, strict=True) if step <= last)


def test_the_stage_of_each_increment():
    path = path_of(blocks(3))
    assert path.last_steps == (1, 3, 6, 8, 11, 13, 16, 17)
    found = [path.increment(step, [summary()] * step).stage.number for step in range(path.increments)]
    assert found == [1, 1, 2, 2, 3, 3, 3, 4, 4, 5, 5, 5, 6, 6, 7, 7, 7, 8]
    assert [step for step in range(path.increments) if path.ends_stage(step)] == list(path.last_steps)
    assert not path.ends_stage(path.increments)
    assert path.imposed_at(path.increments) == frozenset()
    assert path.growth(path.increments) is None


def test_the_stage_of_each_increment_without_some_stages():
    whole = path_of(blocks(4))
    path = whole.without({4, 5, 8, 9})
    assert [stage.number for stage in path.stages] == [1, 2, 3, 6, 7, 10]
    found = [path.increment(step, [summary()] * step).stage.number for step in range(path.increments)]
    assert found == [stage_by_search(path, step) for step in range(path.increments)]
    assert [path.steps_of(1, turn) for turn in (1, 3)] == [(2, 6), (7, 11)]
    assert whole.steps_of(1, 3) == (12, 16)  # which is as it was


def row(path, step, energy):
    """Return a summary of cycles that dissipate ever less, by a part that `energy` takes off for each cycle."""
    turn = path.increment(step, [summary(stage=1)] * step).stage.number // 2
    return summary(
        P=400.0,
        delta_z=1e-3,
        contact_radius=0.2,
        delta_x=1e-3 * (step % 5),
        Qx=18.0 * (step % 5),
        stage=stage_by_search(path, step),
        work_total=float(sum(1.0 + energy**one for one in range(turn))),
    )


def test_a_path_that_was_followed_is_the_path_that_the_run_left():
    path = path_of(blocks(0, until="periodic", tolerance=0.01, at_most=40))
    history, left = [], path
    while (step := len(history)) < (left := left.after(history)).increments:
        history.append(row(path, step, 0.1) if step < 60 else row(left, step, 0.1))
    followed = path.followed(history)
    assert followed.stages == left.stages
    assert followed.last_steps == left.last_steps
    assert len(path.stages) > len(left.stages) > 4
    assert path.followed(history[:7]).stages == path.stages


class CountedHistory(Sequence):
    """The history of a path that counts the rows that are read."""

    def __init__(self, path, length):
        self.path, self.length, self.read = path, length, 0

    def __len__(self):
        return self.length

    def __getitem__(self, index):
        places = range(self.length)[index]
        if isinstance(places, range):
            return [self[place] for place in places]
        self.read += 1
        return summary(stage=stage_by_search(self.path, places), work_total=0.5 * places**2, contact_radius=0.2)


def test_what_a_step_costs_does_not_grow_with_the_path():
    def read(cycles):
        path = path_of(blocks(0, until="periodic", tolerance=0.01, at_most=cycles))
        history = CountedHistory(path, path.steps_of(1, cycles - 1)[1] + 1)
        assert path.after(history) is path
        path.increment(len(history), history)
        return history.read

    assert read(20) == read(400) == 1 + 3 * 5 + 1  # three cycles, where they begin and what the next stage starts from


def test_repeated_stages_share_their_loads():
    path = path_of(blocks(50))
    assert len({id(loads) for loads in path.imposed}) == 4
    assert path.imposed[-1]["Qx"] == 5.0
    assert [loads["Qx"] for loads in path.imposed[:5]] == [0.0, 18.0, -18.0, 18.0, -18.0]


def test_loads_that_are_shared_keep_the_sign_of_zero():
    case = build(grid={"points": 8}, load_path=[{"P": 400.0}, {"Qx": 0.0}, {"Qx": 0.0}, {"Qx": 0.0}])
    pressed, *others = case.stages()
    zeros = zip(others, (0.0, -0.0, 0.0), strict=True)
    stages = [pressed, *(replace(one, targets=(("Qx", zero),)) for one, zero in zeros)]
    found = imposed_along(stages, derive_model(case))
    assert [repr(loads["Qx"]) for loads in found] == ["0.0", "0.0", "0.0", "-0.0", "0.0"]
    assert found[2] is found[4]


def test_the_memory_of_a_path_grows_with_its_stages_alone():
    def memory(cycles):
        load_path = blocks(cycles)
        tracemalloc.start()
        path = path_of(load_path)
        taken, _ = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert len(path.stages) == 2 * cycles + 2
        return taken

    memory(10)
    assert (memory(400) - memory(200)) / 400 < 700  # bytes per stage
