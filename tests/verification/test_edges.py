"""Edge cases of the contact: what a textbook method divides by zero at, and what has no solution."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from small_cases import SPHERE, write_case
from solving import DISSIMILAR, FRICTION, HERTZ, LOAD, solve, solve_last

from fretsolve import load_case, run
from fretsolve.errors import GridEdgeError, NoSolutionError, SlidingError
from fretsolve.reference.tangential import gross_slip_torque

CASE = SPHERE.replace("16", "24") + "load_path:\n  - {P: 400 N}\n"


def failure(path: Path) -> NoSolutionError:
    with pytest.raises(NoSolutionError) as caught:
        list(run(load_case(path)))
    return caught.value


class TestWithoutFriction:
    def test_no_shear_and_no_work(self):
        states = solve(friction=0, grid={"points": 24}, load_path=[{"P": LOAD}, {"delta_x": 1e-3, "increments": 2}])
        assert not states[-1].fields.shear.any()
        assert states[-1].summary.work_total == 0.0
        assert states[-1].summary.delta_x == 1e-3
        contact = states[-1].fields.pressure > 0.0
        assert states[-1].fields.slip[0][contact] == pytest.approx(1e-3)

    def test_any_shear_force_slides(self, tmp_path):
        text = CASE.replace("friction: 0.1", "friction: 0") + "  - {Qx: 1 N}\n"
        error = failure(write_case(tmp_path, text))
        assert isinstance(error, SlidingError)
        assert error.line == 9

    def test_dissimilar_bodies_slip_as_the_pressure_moves_them(self):
        """Without friction C moves the surfaces: outward or inward by the displacement under a Hertz pressure."""
        state = solve_last(
            bodies=DISSIMILAR, friction=0, grid={"points": 24}, output={"fields": ["slip"]}, load_path=[{"P": LOAD}]
        )
        assert state.summary.max_pressure == pytest.approx(HERTZ.max_pressure, rel=0.005)
        assert np.abs(state.fields.slip).max() > 1e-5


class TestGrossSliding:
    def test_spinning(self):
        state = solve_last(grid={"points": 48}, load_path=[{"P": LOAD}, {"phi_z": 0.05, "increments": 1}])
        assert state.summary.Mz == pytest.approx(gross_slip_torque(HERTZ, FRICTION), rel=2e-3)
        assert state.summary.stick_area == 0.0

    @pytest.mark.parametrize(
        ("stage", "component", "size"),
        [
            ("{Qx: 40.5 N}", "Qx", "mu P = 40"),
            ("{Qy: -41 N, increments: 1}", "Qy", "mu P = 40"),
            ("{Mz: 7.5 N mm, increments: 3}", "Mz", "Mz = "),
            ("{Qx: 30 N, Qy: 30 N, increments: 1}", "Qx", "mu P = 40"),
        ],
    )
    def test_under_force_control(self, tmp_path, stage, component, size):
        error = failure(write_case(tmp_path, CASE + f"  - {stage}\n"))
        assert isinstance(error, SlidingError)
        assert error.exit_code == 3
        assert error.key == ("stage", 2, component)
        assert error.line == 9
        assert size in str(error)
        assert "\n" not in str(error)


class TestGridEdge:
    def test_a_tilted_contact_that_leaves_the_grid(self, tmp_path):
        text = CASE.replace("P: 400 N", "P: 400 N, My: 60 N mm").replace("24}", "24, size: 0.75 mm}")
        error = failure(write_case(tmp_path, text))
        assert isinstance(error, GridEdgeError)
        assert "+x" in str(error)
        advice = str(error).split("size: [")[1].split("]")[0]
        state = list(run(load_case(tmp_path / "case.yaml", [f"grid.size=[{advice}]"])))[-1]
        assert state.summary.My == pytest.approx(60.0)


class TestEverySurfaceIsSized:
    """`size: auto` holds the contact, with room around it but not much."""

    @pytest.mark.parametrize(
        "surface",
        [
            {"sphere": {"radius": 10.0}},
            {"sphere": {"radius": 10.0, "center": [0.2, 0.0]}},
            {"ellipsoid": {"radius_x": 5.0, "radius_y": 40.0, "angle": 0.6}},
            {"cylinder": {"radius": 10.0, "axis": "y", "length": 2.0, "end_radius": 0.5}},
            {"cylinder": {"radius": 10.0, "axis": "x", "crown_radius": 200.0}},
            {"cone": {"angle": 0.02}},
            {"punch": {"radius": 0.3, "edge_radius": 0.1}},
            {"punch": {"half_width": 0.4}},
            [{"sphere": {"radius": 20.0}}, {"cylinder": {"radius": 20.0, "axis": "x"}}],
        ],
        ids=lambda surface: "-".join(surface) if isinstance(surface, dict) else "sum",
    )
    def test_load(self, surface):
        state = solve_last(surface=surface, grid={"points": 32})
        contact = state.fields.pressure > 0.0
        assert abs(state.summary.P - LOAD) < 1e-6 * LOAD
        assert 0.5 * 32 <= np.count_nonzero(contact.any(axis=1)) <= 30
        assert 0.25 * 32 <= np.count_nonzero(contact.any(axis=0)) <= 30


class TestOtherSurfaces:
    def test_rigid_body(self):
        """A rigid sphere doubles E*; with friction, Dundurs' constant of nu = 0.3 couples and stiffens a little."""
        bodies = ["rigid", {"young_modulus": 200e3, "poisson_ratio": 0.3}]
        free = solve_last(bodies=bodies, grid={"points": 48}, friction=0)
        assert free.summary.delta_z == pytest.approx(HERTZ.delta_z / 2 ** (2 / 3), rel=1e-3)
        rough = solve_last(bodies=bodies, grid={"points": 48}, friction=0.3, load_path=[{"P": LOAD, "increments": 4}])
        assert 0.95 < rough.summary.delta_z / free.summary.delta_z < 0.999


class TestControl:
    def test_switching_to_displacement_and_back(self):
        """From force to displacement control nothing jumps: a stage that stays where it is changes nothing."""
        start = [{"P": LOAD, "increments": 2}, {"Qx": 25.0, "increments": 2}]
        parts = {"bodies": DISSIMILAR, "grid": {"points": 32}}
        forced = solve_last(**parts, load_path=start)
        held = {"delta_x": forced.summary.delta_x, "increments": 1}
        states = solve(**parts, load_path=[*start, held, {"Qx": 25.0, "increments": 1}])
        for state in states[-2:]:
            assert state.summary.Qx == pytest.approx(25.0, rel=1e-6)
            assert state.summary.delta_x == pytest.approx(forced.summary.delta_x, rel=1e-6)
            assert state.fields.shear == pytest.approx(forced.fields.shear, abs=1e-5 * HERTZ.max_pressure)
            assert state.summary.work < 3e-6 * forced.summary.work_total  # three times the tolerance


def test_an_offset_of_the_surfaces_changes_nothing(tmp_path):
    """The gap is measured against the elastic displacement, so a map far from its zero is solved as well."""
    side = np.linspace(-0.5, 0.5, 201)
    heights = np.add.outer(side**2, side**2) / 20
    found = []
    for offset in (0.0, 1e4):
        np.save(tmp_path / "map.npy", heights + offset)
        surface = {"heights": {"file": str(tmp_path / "map.npy"), "spacing": 0.005}}
        found.append(solve(surface=surface, grid={"points": 48, "size": 0.8}, load_path=[{"P": 400}])[-1])
    assert found[1].summary.max_pressure == pytest.approx(found[0].summary.max_pressure, rel=1e-6)
    assert found[1].summary.delta_z - 1e4 == pytest.approx(found[0].summary.delta_z, rel=1e-5)


@pytest.mark.parametrize("tilt", [(1e-3, 7e-4)])
def test_a_tilted_contact_is_unloaded_to_nothing(tilt):
    load_path = [{"P": 400, "phi_x": tilt[0], "phi_y": tilt[1]}, {"P": 0}]
    last = solve(grid={"points": 48, "size": 0.9}, load_path=load_path)[-1]
    assert last.summary.contact_area == 0.0
    assert last.fields.gap.min() == pytest.approx(0.0, abs=1e-15)


def test_contact_at_the_edge_of_a_height_map_is_an_error(tmp_path):
    side = np.linspace(-0.2, 0.2, 81)
    np.save(tmp_path / "map.npy", np.add.outer(side**2, side**2) / 20)
    surface = {"heights": {"file": str(tmp_path / "map.npy"), "spacing": 0.005}}
    with pytest.raises(GridEdgeError, match="edge of the height map"):
        solve(surface=surface, grid={"points": 48, "size": 0.8}, load_path=[{"P": 400}])


def test_torque_near_the_limit_of_coupled_bodies():
    """The pressure that carries more than Hertz's is found, though the load is beyond what Hertz's carries."""
    parts = {"bodies": DISSIMILAR, "friction": 0.3, "grid": {"points": 48}}
    loads = [{"P": 400, "increments": 5}, {"Mz": 17.6, "increments": 5}]
    turned = solve(**parts, load_path=[*loads, {"phi_z": 0.1, "increments": 1}])[-1]
    carried = solve(**parts, load_path=[*loads, {"Mz": 0.995 * turned.summary.Mz, "increments": 1}])[-1]
    assert carried.summary.Mz == pytest.approx(0.995 * turned.summary.Mz)
