"""The rounds of an accuracy: what is picked for the next one, where they end, and that a result goes on with them."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from solving import DISSIMILAR, SPHERE, build

import fretsolve
from fretsolve.errors import CaseError
from fretsolve.result.verdict import Judged
from fretsolve.simulation.accuracy.in_memory import solved
from fretsolve.simulation.accuracy.rounds import AIM, MOST_FINER, Judgement, _factors, first_round, judge
from fretsolve.simulation.problem_setup import set_up

SHEARED = [{"P": 400.0}, {"Qx": 36.0}]


def bars(*relative: tuple[float, float]) -> list[Judged]:
    """Quantities at the end of two stages, each with its bar and the part of it that increments explain."""
    ends = np.array([0, 1])
    return [
        Judged("delta_x", "delta_x_corrected", 1.0, np.full(2, bar), np.full(2, part), ends + 1, ends)
        for bar, part in relative
    ]


def path_dependent() -> Any:
    return set_up(build(bodies=DISSIMILAR, load_path=SHEARED, solver={"accuracy": 0.01}))


def test_cells_are_refined_by_the_power_of_their_errors() -> None:
    setup = path_dependent()
    cells, increments = _factors(setup, bars((0.01, 0.0)), 0.005 / AIM)
    assert cells == pytest.approx(2.0 ** (1.0 / 1.4), rel=0.08)  # of the factors that are tried the next larger one
    assert cells >= 2.0 ** (1.0 / 1.4)
    assert increments == 1.0


def test_increments_are_refined_by_first_order() -> None:
    cells, increments = _factors(path_dependent(), bars((0.012, 0.012)), 0.01 / AIM)
    assert (cells, increments) == (1.0, pytest.approx(2.0**0.5))


def test_where_both_count_the_cheaper_way_is_taken() -> None:
    """Increments cost less than cells, so they are refined further than cells alone would ask for."""
    cells, increments = _factors(path_dependent(), bars((0.010, 0.006)), 0.008 / AIM)
    left = math.hypot(0.008 * cells**-1.4, 0.006 / increments)
    assert left <= 0.008
    assert increments > cells > 1.0


def test_no_round_is_more_than_twice_as_fine() -> None:
    assert _factors(path_dependent(), bars((9.0, 1.0)), 1e-4) == (MOST_FINER, MOST_FINER)


def test_what_may_not_grow_ends_the_rounds_if_it_leaves_too_much() -> None:
    setup = path_dependent()
    assert _factors(setup, bars((0.012, 0.006)), 0.01, (False, True)) == (1.0, 1.0)
    cells, increments = _factors(setup, bars((0.012, 0.011)), 0.01, (False, True))
    assert cells == 1.0 and increments > 1.0
    cells, increments = _factors(setup, bars((0.012, 0.006)), 0.01, (True, False))
    assert cells > 1.0 and increments == 1.0
    assert _factors(setup, bars((0.012, 0.011)), 0.01, (True, False)) == (1.0, 1.0)


@pytest.mark.slow
def test_increments_that_change_nothing_end_the_rounds() -> None:
    """One stage has few increments, which are kept, and the error that they leave stays behind."""
    path = [{"P": 400.0, "increments": 2}, {"Qx": 10.0}]
    asked = {"accuracy": {"target": 0.05, "of": ["work_total"]}}
    last, _, known = solved(build(bodies=DISSIMILAR, load_path=path, grid={"points": 36}, solver=asked))
    assert known is not None and not known.met
    assert known is not None and known.reason == "no round follows: the last two rounds have hardly lowered the error"
    assert len(last.before) == 2


def test_a_sphere_is_known_as_well_as_asked_for() -> None:
    """Against Hertz and Mindlin; each bar holds."""
    case = build(load_path=SHEARED, friction=0.1, solver={"accuracy": 0.005}, grid={})
    last, states, known = solved(case)
    assert known is not None and known.met
    assert known.worst <= 0.005
    hertz, mindlin = last.setup.closed_forms.hertz[1], last.setup.closed_forms.tangential(1)
    assert states[-1].summary.delta_z == pytest.approx(hertz.delta_z, rel=0.005)
    assert states[-1].summary.contact_radius == pytest.approx(hertz.contact_radius, rel=0.005)
    assert states[-1].summary.work_total == pytest.approx(mindlin.dissipated_energy(), rel=0.03)  # uncoupled form
    sizes = [one.points[0] for one in last.before] + [last.setup.grid.nx]
    assert all(low < high <= 2 * low for low, high in pairwise(sizes))
    assert list(fretsolve.run(case))[-1].summary.work_total == states[-1].summary.work_total


def test_given_points_are_kept() -> None:
    case = build(load_path=SHEARED, solver={"accuracy": 1e-4}, grid={"points": 24})
    last, _, known = solved(case)
    assert last.before == ()
    assert known is not None and known.reason == "no round follows: grid.points is given"


@pytest.mark.parametrize(
    ("at_most", "says"), [({"cells": 1000}, "at_most.cells is 1000"), ({"time": "1 ms"}, "at_most.time is 0.001 s")]
)
def test_limits_end_the_rounds_with_the_cost_of_the_next_one(at_most: dict[str, Any], says: str) -> None:
    accuracy = {"target": 1e-3, "at_most": at_most}
    last, states, known = solved(build(load_path=SHEARED, solver={"accuracy": accuracy}, grid={}))
    assert last.before == ()
    assert states[-1].errors is not None, "the first round is given with its bars"
    assert known is not None and known.reason.startswith("the next round would take ")
    assert known is not None and known.reason.endswith(says)
    assert f"{2 * last.setup.grid.nx} x " in known.reason


def test_without_an_accuracy_there_is_one_round() -> None:
    only = first_round(build(load_path=SHEARED, grid={"points": 16}))
    assert judge(only, {}, lambda: None, 1.0) == Judgement(None)


def test_a_map_that_is_coarser_than_the_cells_takes_no_fewer_points(tmp_path: Path) -> None:
    file = tmp_path / "map.npy"
    np.save(file, np.zeros((16, 16)))
    surface = [SPHERE, {"heights": {"file": str(file), "spacing": 0.1}}]
    last, _, known = solved(build(bodies=DISSIMILAR, surface=surface, load_path=SHEARED, solver={"accuracy": 1e-3}))
    assert known is not None and "as small as the spacing of the height map" in known.reason
    assert all(one.points == last.setup.grid.shape for one in last.before)


@pytest.mark.slow
def test_a_first_round_without_error_bars_is_followed_by_a_finer_one() -> None:
    """Of the torque friction carries 0.9994 on the coarsest grid, so that it has no solution there."""
    last, states, known = solved(
        build(friction=0.3, load_path=[{"P": 400.0}, {"Mz": 21.2}], grid={}, solver={"accuracy": 0.05})
    )
    assert last.before[0].quantity == ""
    assert known is not None and known.met
    assert states[-1].errors is not None and math.isfinite(states[-1].errors.P_error)


@pytest.mark.slow
def test_increments_grow_where_they_are_the_whole_error_of_equal_bodies() -> None:
    """Next to gross slip the energy depends on them, though one increment has the right shear traction."""
    path, asked = [{"P": 40.0}, {"Qx": 11.995}], {"accuracy": {"target": 0.02, "of": ["work_total"]}}
    last, states, known = solved(build(friction=0.3, load_path=path, solver=asked))
    mindlin = last.setup.closed_forms.tangential(1)
    assert known is not None and known.met
    assert last.setup.load_path.counts[1] > 10
    assert states[-1].summary.work_total == pytest.approx(mindlin.dissipated_energy(), rel=0.1)  # Poisson's ratio


def test_rounds_do_not_go_on_from_a_state() -> None:
    case = build(load_path=SHEARED, solver={"accuracy": 0.2})
    state = next(fretsolve.run(case))
    with pytest.raises(CaseError, match="a state belongs to one round"):
        fretsolve.run(case, state, [state.summary])
