"""Least errors: how they fall with the cells, and where there are none."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from line_cases import LOAD as LINE_LOAD
from line_cases import line_case
from solving import DISSIMILAR, FRICTION, HERTZ, LOAD, MATERIAL, SPHERE, build

from fretsolve.reference.tangential import cattaneo_mindlin
from fretsolve.result.state import ESTIMATED
from fretsolve.simulation.error_bars.coarse_runs import values_of
from fretsolve.simulation.error_bars.floors import Cells, ShearPath, floors
from fretsolve.simulation.problem_setup import set_up
from fretsolve.simulation.simulation import run

PUNCH = {"surface": {"punch": {"radius": 0.3}}, "friction": 0.0, "load_path": [{"P": LOAD}]}


def least(case: Any) -> dict[str, float]:
    """Return the least errors at the end of a case."""
    setup, path, largest = set_up(case), ShearPath(), np.zeros(len(ESTIMATED))
    for state in run(setup):
        path = path.after(state.summary, setup.model.friction * state.summary.P, 1)
        largest = np.fmax(largest, np.abs(values_of(state.summary)))
    found = floors(Cells.of(setup), state, dict(zip(ESTIMATED, largest.tolist(), strict=True)), path, 0.0)
    return dict(zip(ESTIMATED, found.tolist(), strict=True))


def sphere(points: int, **parts: Any) -> dict[str, float]:
    return least(build(**{"grid": {"points": points, "size": 0.8}, "load_path": [{"P": LOAD}], **parts}))


def test_sums_of_a_smooth_contact_are_of_second_order_and_its_edges_of_first() -> None:
    coarse, fine = sphere(24), sphere(48)
    for name, ratio in (("delta_z", 4.0), ("My", 4.0), ("contact_half_width_x", 2.0), ("stick_center_x", 2.0)):
        assert coarse[name] / fine[name] == pytest.approx(ratio, rel=0.1), name


def test_a_body_that_ends_has_errors_of_first_order() -> None:
    coarse, fine = (least(build(**PUNCH, grid={"points": points, "size": 0.9})) for points in (24, 48))
    assert coarse["delta_z"] / fine["delta_z"] == pytest.approx(2.0, rel=0.1)
    assert coarse["delta_z"] > 5.0 * sphere(24)["delta_z"]


def test_a_sharp_edge_in_contact_leaves_the_largest_pressure_unbounded() -> None:
    assert math.isinf(least(build(**PUNCH, grid={"points": 24, "size": 0.9}))["max_pressure"])
    assert math.isfinite(sphere(24)["max_pressure"])


def test_without_shear_like_bodies_dissipate_nothing_and_all_of_them_stick() -> None:
    found = sphere(24)
    assert (found["work"], found["work_total"], found["delta_x"], found["Qx"]) == (0.0, 0.0, 0.0, 0.0)
    assert found["stick_radius"] == pytest.approx(found["contact_radius"])


@pytest.mark.parametrize("share", [0.01, 0.1])
def test_energy_of_an_annulus_that_no_cell_shows_is_that_of_mindlin(share: float) -> None:
    force = share * FRICTION * LOAD
    exact = cattaneo_mindlin(HERTZ, FRICTION, force, MATERIAL.tangential).work_per_cycle / 4.0
    found = sphere(24, coupling="none", load_path=[{"P": LOAD}, {"Qx": force}])["work_total"]
    assert exact < found < 2.0 * exact


def test_a_stick_zone_may_hide_in_a_cell_until_all_slides() -> None:
    nearly, slid = (sphere(24, load_path=[{"P": LOAD}, {"delta_x": way, "increments": 4}]) for way in (1.3e-3, 4e-3))
    assert slid["stick_radius"] < 0.05 * HERTZ.contact_radius
    assert nearly["stick_radius"] > slid["stick_radius"]


def test_motion_is_known_less_where_next_to_nothing_slips() -> None:
    little, much = (
        sphere(24, load_path=[{"P": LOAD}, {"Qx": share * FRICTION * LOAD}])["delta_x"]
        / cattaneo_mindlin(HERTZ, FRICTION, share * FRICTION * LOAD, MATERIAL.tangential).delta_x
        for share in (0.01, 0.9)
    )
    assert little > 10.0 * much


def test_displacements_of_a_line_contact_have_no_error_and_its_moment_more_than_on_an_area() -> None:
    found = least(line_case(grid={"points": 32}, load_path=[{"P": LINE_LOAD}]))
    assert found["delta_z"] == found["delta_x"] == 0.0
    assert found["My"] > 0.0 and found["phi_y"] > 0.0


def test_unlike_bodies_dissipate_as_they_are_pressed() -> None:
    assert sphere(24, bodies=DISSIMILAR)["work_total"] > 0.0


def test_heights_that_cells_miss_add_to_all_values(tmp_path: Path) -> None:
    x = np.arange(-180, 181) * 2e-3
    np.save(tmp_path / "waves.npy", 1e-5 * np.sin(2.0 * np.pi * x[:, None] / 0.02) * np.ones_like(x))
    surface = [SPHERE, {"heights": {"file": str(tmp_path / "waves.npy"), "spacing": 2e-3}}]
    rough = least(build(surface=surface, friction=0.0, grid={"points": 36, "size": 0.71}, load_path=[{"P": LOAD}]))
    smooth = sphere(36, friction=0.0, grid={"points": 36, "size": 0.71})
    for name in ("delta_z", "contact_radius", "contact_half_width_x", "max_pressure"):
        assert rough[name] > smooth[name], name
