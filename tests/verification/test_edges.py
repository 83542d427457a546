"""Edge cases of the contact: what a textbook method divides by zero at, and what has no solution."""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from small_cases import SPHERE, write_case
from solving import DISSIMILAR, FRICTION, HERTZ, LOAD, MATERIAL, SIMILAR, A, build, solve, solve_last

from fretsolve import load_case, run
from fretsolve.case.models import Case
from fretsolve.errors import GridEdgeError, NoSolutionError, SlidingError
from fretsolve.reference.hertz import boussinesq_punch, love_cone
from fretsolve.reference.tangential import gross_slip_torque
from fretsolve.result.state import State, Zone

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


class TestTinyContacts:
    def test_a_single_cell_slides_when_dragged(self):
        drag = {"delta_x": 1e-3, "delta_y": 1e-3, "increments": 2}
        state = solve_last(grid={"points": 9, "size": 0.9}, load_path=[{"P": 1e-3}, drag])
        assert state.fields.zone[4, 4] == Zone.SLIP
        assert state.summary.Qx == pytest.approx(FRICTION * 1e-3 / math.sqrt(2), rel=1e-6)

    def test_a_stick_zone_smaller_than_a_cell(self):
        path = [{"P": LOAD}, {"Qx": 0.99999 * FRICTION * LOAD, "increments": 3}]
        state = solve_last(grid={"points": 24}, load_path=path)
        assert state.summary.stick_area <= 4 * (2.4 * A / 24) ** 2
        assert state.summary.Qx == pytest.approx(0.99999 * FRICTION * LOAD, rel=1e-6)


class TestGrossSliding:
    def test_under_displacement_control(self):
        """Far beyond the last sticking point |q| = mu p in every cell and Q = mu P, for dissimilar bodies too."""
        for bodies in (DISSIMILAR, build(grid={"points": 2}).bodies):
            path = [{"P": LOAD, "increments": 2}, {"delta_x": 4e-3, "delta_y": 3e-3, "increments": 4}]
            state = solve_last(bodies=[*bodies], grid={"points": 32}, load_path=path)
            fields, contact = state.fields, state.fields.pressure > 0.0
            length = np.hypot(*fields.shear)[contact]
            assert length == pytest.approx(FRICTION * fields.pressure[contact], rel=1e-6)
            assert (fields.zone[contact] == Zone.SLIP).all()
            assert math.hypot(state.summary.Qx, state.summary.Qy) == pytest.approx(FRICTION * LOAD, rel=1e-3)
            assert state.summary.Qy / state.summary.Qx == pytest.approx(0.75, rel=0.02)

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

    def test_states_before_the_sliding_hold(self, tmp_path):
        states = run(load_case(write_case(tmp_path, CASE + "  - {Qx: 50 N, increments: 10}\n")))
        forces = [next(states).summary.Qx for _ in range(8)]
        with pytest.raises(SlidingError):
            next(states)
        assert forces == pytest.approx([0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0], abs=1e-9)


class TestUnloading:
    def test_to_nothing_and_back(self):
        path = [
            {"P": LOAD, "increments": 2},
            {"Qx": 10.0, "increments": 1},
            {"Qx": 0.0, "increments": 1},
            {"P": 0.0, "increments": 4},
            {"P": LOAD, "increments": 2},
            {"Qx": 10.0, "increments": 1},
        ]
        for bodies in (DISSIMILAR, build(grid={"points": 2}).bodies):
            states = solve(bodies=[*bodies], grid={"points": 24}, load_path=path)
            empty = states[7]
            assert empty.summary.P == 0.0
            assert not empty.fields.pressure.any()
            assert not empty.fields.shear.any()
            assert not empty.displacement.any()
            assert abs(empty.summary.delta_z) < 0.01 * HERTZ.delta_z
            assert empty.fields.gap.min() >= -1e-15  # mm: rounding of the separation
            again, first = states[-1], states[2]
            assert again.fields.pressure == pytest.approx(first.fields.pressure, abs=2e-4 * HERTZ.max_pressure)
            assert again.summary.Qx == pytest.approx(10.0)

    def test_pulling_off_by_displacement(self):
        path = [{"delta_z": 9e-3}, {"delta_z": -1e-3}, {"delta_z": 9e-3}]
        states = solve(grid={"points": 24, "size": 0.75}, load_path=path)
        assert [bool(state.fields.pressure.any()) for state in states] == [True, False, True]
        assert states[1].fields.gap.min() >= 1e-3
        assert abs(states[2].summary.P / states[0].summary.P - 1.0) < 1e-6


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

    def test_heights(self, tmp_path):
        x = np.linspace(-1.0, 1.0, 81)
        np.save(tmp_path / "map.npy", (x[:, None] ** 2 + x[None, :] ** 2) / 20.0)
        text = CASE.replace("{sphere: {radius: 10 mm}}", "{heights: {file: map.npy, spacing: 0.025 mm}}")
        state = list(run(load_case(write_case(tmp_path, text))))[-1]
        assert state.summary.max_pressure == pytest.approx(HERTZ.max_pressure, rel=0.01)

    def test_displacement_control(self):
        state = solve_last(grid={"points": 32}, load_path=[{"delta_z": HERTZ.delta_z}])
        assert abs(state.summary.P - LOAD) < 2e-3 * LOAD


class TestOtherSurfaces:
    def test_cone(self):
        """Love: the approach; the pressure's peak is a logarithm and its contact radius counts cells."""
        exact = love_cone(LOAD, 0.02, MATERIAL.contact_modulus)
        state = solve_last(surface={"cone": {"angle": 0.02}}, grid={"points": 96}, friction=0)
        assert state.summary.delta_z == pytest.approx(exact.delta_z, rel=2e-3)
        assert state.summary.contact_radius == pytest.approx(exact.contact_radius, rel=2.4 / 96)

    def test_flat_punch(self):
        """Boussinesq: a sharp edge is known to half a cell only, so the approach errs by h/2a at most."""
        exact = boussinesq_punch(LOAD, 0.3, MATERIAL.contact_modulus)
        state = solve_last(surface={"punch": {"radius": 0.3}}, grid={"points": 96, "size": 0.7}, friction=0)
        assert state.summary.delta_z == pytest.approx(exact.delta_z, rel=0.5 * 0.7 / 96 / 0.3)
        assert state.summary.contact_radius == pytest.approx(0.3, rel=0.01)

    def test_rigid_body(self):
        """A rigid sphere doubles E*; with friction, Dundurs' constant of nu = 0.3 couples and stiffens a little."""
        bodies = ["rigid", {"young_modulus": 200e3, "poisson_ratio": 0.3}]
        free = solve_last(bodies=bodies, grid={"points": 48}, friction=0)
        assert free.summary.delta_z == pytest.approx(HERTZ.delta_z / 2 ** (2 / 3), rel=1e-3)
        rough = solve_last(bodies=bodies, grid={"points": 48}, friction=0.3, load_path=[{"P": LOAD, "increments": 4}])
        assert 0.95 < rough.summary.delta_z / free.summary.delta_z < 0.999

    def test_rectangular_area(self):
        square = solve_last(grid={"points": 40, "size": 0.8}, solver={"tolerance": 1e-9})
        wide = solve_last(grid={"points": [60, 40], "size": [1.2, 0.8]}, solver={"tolerance": 1e-9})
        assert wide.fields.pressure[10:50] == pytest.approx(square.fields.pressure, abs=1e-5 * HERTZ.max_pressure)


def sheared_case(dissimilar: bool, *stages: dict[str, float]) -> Case:
    load_path = [{"P": LOAD, "increments": 2}, {"Qx": 25.0, "increments": 2}, *stages]
    bodies = DISSIMILAR if dissimilar else SIMILAR
    return build(bodies=bodies, grid={"points": 24, "size": 0.75}, load_path=load_path)


@cache
def sheared(dissimilar: bool) -> list[State]:
    return list(run(sheared_case(dissimilar)))


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

    @pytest.mark.parametrize("dissimilar", [False, True])
    @pytest.mark.parametrize("name", ["P", "delta_z", "Qx", "delta_x"])
    @pytest.mark.parametrize("step", [0.0, 1e-9, -1e-9, 1e-5])
    def test_steps_of_next_to_nothing(self, dissimilar, name, step):
        """A stage that holds a load or hardly moves it: residuals relative to its motion must not ask for the
        impossible, and what was solved before must hold on."""
        states = sheared(dissimilar)
        before = states[-1]
        case = sheared_case(dissimilar, {name: getattr(before.summary, name) * (1.0 + step), "increments": 1})
        (after,) = run(case, before, [state.summary for state in states])
        assert after.fields.shear == pytest.approx(before.fields.shear, abs=1e-3 * HERTZ.max_pressure)
        assert after.summary.work <= 1e-4 * before.summary.work_total

    def test_a_stage_starts_from_where_the_contact_was(self):
        path = [{"P": LOAD}, {"Qx": 20.0, "increments": 2}, {"delta_x": 1e-3, "increments": 4}]
        states = solve(grid={"points": 24}, load_path=path)
        motion = [state.summary.delta_x for state in states[2:]]
        assert np.diff(motion) == pytest.approx((1e-3 - motion[0]) / 4)


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


@pytest.mark.parametrize("tilt", [(1e-3, 7e-4), (-9.5e-4, 3.3e-4), (1.7e-4, -5.1e-4)])
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


def test_a_punch_that_coarse_grids_cannot_see():
    parts = {"surface": {"punch": {"radius": 0.01}}, "grid": {"points": 64, "size": 0.72}}
    last = solve(**parts, load_path=[{"P": 1}])[-1]
    assert pytest.approx(1.0) == last.summary.P


def test_start_and_history_belong_together():
    case = build(grid={"points": 16}, load_path=[{"P": 400}, {"P": 500}])
    first = next(run(case))
    with pytest.raises(ValueError, match="last increment of history"):
        next(run(case, first, []))


def test_torque_near_the_limit_of_coupled_bodies():
    """The pressure that carries more than Hertz's is found, though the load is beyond what Hertz's carries."""
    parts = {"bodies": DISSIMILAR, "friction": 0.3, "grid": {"points": 48}}
    loads = [{"P": 400, "increments": 5}, {"Mz": 17.6, "increments": 5}]
    turned = solve(**parts, load_path=[*loads, {"phi_z": 0.1, "increments": 1}])[-1]
    carried = solve(**parts, load_path=[*loads, {"Mz": 0.995 * turned.summary.Mz, "increments": 1}])[-1]
    assert carried.summary.Mz == pytest.approx(0.995 * turned.summary.Mz)


@pytest.mark.slow
def test_thousands_of_spots(tmp_path):
    """White noise under a punch: the contact zone must not run in circles (a third of the cells are in contact)."""
    points = 240
    heights = 1e-3 * np.random.default_rng(0).standard_normal((points + 17, points + 17))
    np.save(tmp_path / "noise.npy", heights)
    rough = {"heights": {"file": str(tmp_path / "noise.npy"), "spacing": 1.2 / points}}
    case = build(
        bodies=[{"young_modulus": 2e5, "poisson_ratio": 0.0}] * 2,
        friction=0,
        grid={"points": points, "size": 1.2},
        load_path=[{"P": 4000}],
        surface=[rough, {"punch": {"radius": 0.55}}],
    )
    (state,) = run(case)
    assert state.summary.residual_gap < 1e-6
    assert state.summary.iterations_normal < 200
    assert 15000 < state.summary.contact_cells < 25000
