"""Wear with what else a case may have: each wears off alpha times the energy that it dissipates, where it slips."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import invoke
from line_cases import line_case
from small_cases import write_case
from solving import build

from fretsolve import open_result, run
from fretsolve.result.state import State

ALPHA = 1e-7
UNLIKE = [{"young_modulus": 200e3, "poisson_ratio": 0.3}, {"young_modulus": 70e3, "poisson_ratio": 0.2}]
CELLS, SIZE = 18, 0.9


def path_of(most: dict[str, Any], represents: int = 12000) -> list[Any]:
    """Return a path that presses and goes to and fro between `most` and its opposite."""
    there, back = {**most, "increments": 2}, {**_opposite(most), "increments": 2}
    cycle = {"represents": represents, "jump": 4000, "stages": [back, there]}
    return [{"P": 400.0}, there, {"cycle": cycle}]


def _opposite(values: dict[str, Any]) -> dict[str, Any]:
    return {name: _opposite(value) if isinstance(value, dict) else -value for name, value in values.items()}


def wear(most: dict[str, Any], **keys: Any) -> State:
    """Return the end of a run in which each increment has the volume alpha W to rounding."""
    usual = {"grid": {"points": CELLS, "size": SIZE}, "friction": 0.1}
    output = {"fields": ["pressure", "zone", "wear_depth", "work_density"]}
    case = build(wear={"law": "energy", "alpha": ALPHA}, load_path=path_of(most), output=output, **{**usual, **keys})
    return _checked(list(run(case)))


def _checked(states: list[State]) -> State:
    for row in (state.summary for state in states):
        assert row.wear_volume == pytest.approx(ALPHA * row.work_total, rel=1e-12, abs=0.0)
    last = states[-1]
    assert last.summary.cycles == 12000.0
    assert sum(state.summary.jump > 1.0 for state in states) == 3
    assert last.fields.wear_depth is not None
    np.testing.assert_allclose(last.fields.wear_depth, ALPHA * last.fields.work_density, rtol=1e-12)
    return last


@cache
def similar_bodies() -> State:
    return wear({"Qx": 30.0})


def test_dissimilar_bodies() -> None:
    last = wear({"Qx": 30.0}, bodies=UNLIKE)
    depth = last.fields.wear_depth
    largest = depth.max()
    np.testing.assert_allclose(depth, depth[:, ::-1], atol=1e-4 * largest)  # nothing tells y from -y
    middle = CELLS // 2
    assert depth[middle - 1 : middle + 1, middle - 1 : middle + 1].max() < 0.02 * largest  # a ring
    assert last.summary.wear_volume != pytest.approx(similar_bodies().summary.wear_volume, rel=0.1)


def test_a_map_of_heights_wears_as_the_shape_that_it_gives(tmp_path: Path) -> None:
    x = (np.arange(CELLS) - 0.5 * (CELLS - 1)) * SIZE / CELLS
    np.save(tmp_path / "sphere.npy", np.add.outer(x**2, x**2) / 20.0)
    heights = {"file": str(tmp_path / "sphere.npy"), "spacing": SIZE / CELLS}
    last, sphere = wear({"Qx": 30.0}, surface={"heights": heights}), similar_bodies()
    assert last.summary.wear_volume == pytest.approx(sphere.summary.wear_volume, rel=1e-6)
    np.testing.assert_allclose(last.fields.wear_depth, sphere.fields.wear_depth, atol=1e-11)


def test_a_sharp_punch_wears_though_nothing_stands_beside_it() -> None:
    # Its shear has the shape of its pressure, so that it slips everywhere or nowhere (Cattaneo 1938).
    stuck, sliding = (
        wear(most, surface={"punch": {"radius": 0.2}}, grid={"points": CELLS, "size": 0.5})
        for most in ({"Qx": 30.0}, {"delta_x": 0.005})
    )
    assert stuck.summary.wear_volume == pytest.approx(0.0, abs=1e-12 * sliding.summary.wear_volume)
    depth = sliding.fields.wear_depth
    worn = depth > 0.0
    assert worn.sum() == sliding.summary.contact_cells > 0
    assert depth[worn].min() > 0.1 * depth.max()
    assert not worn[0].any() and not worn[:, 0].any()


def test_bulk_stress_wears_one_side_more() -> None:
    last = wear({"Qx": 24.0, "bulk_2": {"xx": 142.281, "yy": 29.780}})
    depth, half = last.fields.wear_depth, CELLS // 2
    assert last.summary.stick_center_x > 0.0
    assert depth[:half].sum() > 1.2 * depth[half:].sum()


def test_two_coefficients_turn_with_their_axes() -> None:
    along_x = wear({"Qx": 30.0}, friction={"coefficient": [0.1, 0.2]})
    along_y = wear({"Qy": 30.0}, friction={"coefficient": [0.2, 0.1]})
    np.testing.assert_allclose(along_x.fields.wear_depth, along_y.fields.wear_depth.T, rtol=1e-6, atol=1e-12)
    assert along_x.summary.wear_volume == pytest.approx(along_y.summary.wear_volume, rel=1e-9)


def test_friction_that_runs_in_wears_less_and_less() -> None:
    steady = similar_bodies()
    friction = {"initial": 0.1, "final": 0.3, "slip": 1e-4}
    case = build(
        friction=friction,
        grid={"points": CELLS, "size": SIZE},
        wear={"law": "energy", "alpha": ALPHA},
        load_path=path_of({"Qx": 30.0}),
        output={"fields": ["friction", "wear_depth"]},
    )
    states = list(run(case))
    for row in (state.summary for state in states):
        assert row.wear_volume == pytest.approx(ALPHA * row.work_total, rel=1e-12, abs=0.0)
    last = states[-1]
    assert last.fields.friction.max() > 0.2  # in the slip annulus
    assert last.summary.wear_volume < 0.5 * steady.summary.wear_volume
    assert last.summary.stick_radius > 1.1 * steady.summary.stick_radius


@pytest.mark.parametrize("bulk", [False, True], ids=["force", "and bulk stress"])
def test_line_contacts(bulk: bool) -> None:
    most = {"Qx": 12.0, "bulk_2": {"xx": 60.0}} if bulk else {"Qx": 12.0}
    stages = path_of(most)
    case = line_case(
        grid={"points": 48, "size": 0.4},
        load_path=[{"P": 100.0}, *stages[1:]],
        wear={"law": "energy", "alpha": ALPHA},
        output={"fields": ["wear_depth", "work_density"]},
    )
    depth = _checked(list(run(case))).fields.wear_depth[:, 0]
    left, right = depth[:24].sum(), depth[24:].sum()
    assert left > 1.2 * right if bulk else left == pytest.approx(right, rel=1e-6)


EDGE = """\
bodies: [{young_modulus: 200 GPa, poisson_ratio: 0.3}, {young_modulus: 200 GPa, poisson_ratio: 0.3}]
surface: {sphere: {radius: 10 mm}}
grid: {points: 16, size: 0.7 mm}
friction: 0.1
wear: {law: energy, alpha: 2.84e-6 mm^3/J}
load_path:
  - {P: 400 N}
  - {delta_x: 15 um, increments: 1}
  - cycle:
      represents: 1e6
      jump: 20000
      stages: [{delta_x: -15 um, increments: 1}, {delta_x: 15 um, increments: 1}]
"""


def test_a_scar_that_reaches_the_edge_of_the_grid_ends_the_run_and_keeps_what_is_solved(tmp_path: Path) -> None:
    path = write_case(tmp_path, EDGE)
    done = invoke("run", path, "-q")
    assert done.exit_code == 3
    message = done.stderr.splitlines()[-1]
    assert "the contact reaches the edge (-x, +x, -y, +y)" in message
    # the size advised is that which the warning before the run names, not one for the contact before wear
    room = re.search(r"([0-9.]+) mm would leave room", done.stderr)
    assert room is not None and f"size: [{room[1]} mm, {room[1]} mm] would do" in message
    with open_result(path.with_suffix(".h5")) as result:
        cycles, volume = result.history["cycles"], result.history["wear_volume"]
        assert 20000.0 < cycles[-1] < 1e6
        assert volume[-1] == pytest.approx(2.84e-9 * result.history["work_total"][-1], rel=1e-12)
        kept = len(cycles)
    # a larger grid is another case; with this one the run stops at the same place again
    assert invoke("run", path, "-q", "--resume").exit_code == 3
    with open_result(path.with_suffix(".h5")) as result:
        assert len(result.history["cycles"]) == kept
