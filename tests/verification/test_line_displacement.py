"""Line contacts driven by motions of points at a reference depth: certified values, forces in place of motions, rigs.

The certified pair is a cylinder of 10 mm under 100 N/mm, both bodies of 210 GPa and 0.3, friction 0.5, points 10 mm
deep. The certified values follow from Cerutti's point force integrated along a line.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from line_cases import DISSIMILAR, solve_line
from scipy.integrate import quad

from fretsolve.reference.hertz import HertzLine, RoundedPunch
from fretsolve.reference.line_slip import LineMotion

STEEL = {"young_modulus": 210e3, "poisson_ratio": 0.3}
FRICTION, LOAD, DEPTH = 0.5, 100.0, 10.0
LIMIT = FRICTION * LOAD
CERTIFIED = {0.2: 0.3319849e-3, 0.5: 0.8437161e-3, 0.9: 1.5729763e-3, 1.0: 1.7830410e-3}
"""delta_x by the part of mu P."""
A, B = 2.0 * 0.7 / (210e3 / 2.6), 2.0 * 0.3 / (210e3 / 2.6)
PRESSED = {"P": LOAD}


def solve(*stages, **keys):
    parts = {"bodies": [STEEL, STEEL], "friction": FRICTION, "reference_depth": DEPTH, "grid": {"points": 128}}
    return solve_line(**{**parts, "load_path": [PRESSED, *stages], **keys})


def ends(states):
    """The last summary of each stage."""
    return [state.summary for state in {state.summary.stage: state for state in states}.values()]


@pytest.fixture
def motion():
    return LineMotion(HertzLine(LOAD, 10.0, 2.0 / A), FRICTION, A, DEPTH * math.exp(0.5 * (A + B) / A))


@pytest.mark.parametrize(("part", "delta_x"), CERTIFIED.items())
def test_closed_form(motion, part, delta_x):
    assert motion.on_loading(part * LIMIT) == pytest.approx(delta_x, rel=1e-6)
    assert motion.on_loading(-part * LIMIT) == -motion.on_loading(part * LIMIT)


@pytest.mark.parametrize("contact", [HertzLine(50.0, 10.0, 1e5), RoundedPunch(200.0, 0.5, 100.0, 1e5)])
def test_potential_is_an_integral_of_the_pressure(contact):
    def density(s):
        return float(contact.pressure(np.array([s]))[0]) * math.log(3.0 / s)

    a = contact.half_width
    points = [0.5] if isinstance(contact, RoundedPunch) else None
    assert contact.potential(3.0) == pytest.approx(2.0 * quad(density, 0.0, a, points=points, limit=400)[0], rel=1e-6)


def test_work_is_what_the_loop_of_motions_encloses(motion):
    """By Masing's rule a loop between +-Q has the area 4 Q delta_x less 8 times the integral of delta_x dQ."""
    area = 4.0 * LIMIT * motion.on_loading(LIMIT) - 8.0 * quad(motion.on_loading, 0.0, LIMIT)[0]
    assert motion.work_of_gross_slip == pytest.approx(area, rel=1e-6)


POINTS = (32, 64, 128, 256)
SIZES = (0.255, 0.262, 0.27)


def errors_on(points, size):
    """Relative errors of delta_x under forces, of Qx under motions, and of the onset of gross slip."""
    grid, found = {"points": points, "size": size}, []
    by_force = ends(solve(*({"Qx": part * LIMIT, "increments": 1} for part in CERTIFIED if part < 1.0), grid=grid))
    for row, wanted in zip(by_force[1:], CERTIFIED.values(), strict=False):
        found.append(row.delta_x / wanted - 1.0)
    by_motion = ends(solve(*({"delta_x": value, "increments": 1} for value in CERTIFIED.values()), grid=grid))
    for row, part in zip(by_motion[1:-1], CERTIFIED, strict=False):
        found.append(row.Qx / (part * LIMIT) - 1.0)
    return found


def test_certified_values_and_order_of_the_grid():
    """The root mean square over three sizes of the cells, as the edges of the contact cut cells in each otherwise."""
    errors = {points: np.array([errors_on(points, size) for size in SIZES]) for points in POINTS}
    assert np.abs(errors[128]).max() < 1e-4
    mean = [math.sqrt(np.mean(np.square(errors[points]))) for points in POINTS]
    assert -np.polyfit(np.log(POINTS), np.log(mean), 1)[0] > 1.5


def test_onset_of_gross_slip():
    for part, sticks in ((-3e-4, True), (3e-4, False)):
        last = solve({"delta_x": CERTIFIED[1.0] * (1.0 + part), "increments": 1})[-1].summary
        assert (last.stick_area > 0.0) == sticks


def test_reversals_and_gross_slip(motion):
    """Masing's rule: from gross slip the contact comes back by twice the first loading under half of the change."""
    path = [{"delta_x": value, "increments": 3} for value in (5e-3, 4e-3, -5e-3, -3.5e-3, -3.9e-3)]
    rows = ends(solve(*path))[1:]
    assert [row.stick_cells == 0 for row in rows] == [True, False, True, False, False]
    assert [rows[0].Qx, rows[2].Qx] == pytest.approx([LIMIT, -LIMIT], rel=1e-6)
    assert 5e-3 - 2.0 * motion.on_loading(0.5 * (LIMIT - rows[1].Qx)) == pytest.approx(4e-3, abs=1e-4 * 1e-3)
    assert -5e-3 + 2.0 * motion.on_loading(0.5 * (LIMIT + rows[3].Qx)) == pytest.approx(-3.5e-3, abs=1e-4 * 1.5e-3)
    inner = 2.0 * motion.on_loading(0.5 * (rows[3].Qx - rows[4].Qx))
    assert inner == pytest.approx(0.4e-3, rel=1e-3)


@pytest.mark.parametrize("bodies", [[STEEL, STEEL], DISSIMILAR])
def test_a_motion_does_what_its_force_does(bodies):
    """In partial slip, with a reversal."""
    parts = {"bodies": bodies, "grid": {"points": 64}, "solver": {"tolerance": 1e-8}}
    path = [{"delta_x": 1.4e-3, "increments": 8}, {"delta_x": -0.3e-3, "increments": 8}]
    driven = solve(*path, **parts)
    rows = [state.summary for state in driven if state.summary.stage > 1]
    forced = solve(*({"Qx": row.Qx, "increments": 1} for row in rows), **parts)
    for one, other in zip(driven[-16:], forced[-16:], strict=True):
        assert other.summary.delta_x == pytest.approx(one.summary.delta_x, abs=1e-6 * 1e-3)
        assert np.abs(other.fields.shear - one.fields.shear).max() < 1e-4 * one.summary.max_shear


@pytest.mark.parametrize("bodies", [[STEEL, STEEL], DISSIMILAR])
def test_a_rig_per_mm_does_what_the_motion_less_its_give_does(bodies):
    stiffness = 20e3
    parts = {"bodies": bodies, "grid": {"points": 64}, "solver": {"tolerance": 1e-8}}
    path = [{"actuator_x": value, "increments": 4} for value in (3e-3, 8e-3, -8e-3)]
    on_rig = solve(*path, rig={"stiffness_x": stiffness}, **parts)
    rows = [state.summary for state in on_rig if state.summary.stage > 1]
    for row in rows:
        assert row.actuator_x == pytest.approx(row.delta_x + row.Qx / stiffness, abs=1e-9)
        assert row.spring_energy == pytest.approx(0.5 * row.Qx**2 / stiffness, rel=1e-9)
    moved = solve(*({"delta_x": row.delta_x, "increments": 1} for row in rows), **parts)
    for row, state in zip(rows, moved[-len(rows) :], strict=True):
        assert state.summary.Qx == pytest.approx(row.Qx, abs=1e-5 * LIMIT)
    sliding = [row for row in rows if not row.stick_cells]
    assert sliding and all(abs(row.Qx) == pytest.approx(LIMIT, rel=1e-6) for row in sliding)


def test_a_rig_takes_its_part_of_the_motion(motion):
    last = solve({"actuator_x": 3e-3, "increments": 4}, rig={"stiffness_x": 20e3})[-1].summary
    assert motion.on_loading(last.Qx) + last.Qx / 20e3 == pytest.approx(3e-3, rel=1e-4)


@pytest.mark.parametrize("bodies", [[STEEL, STEEL], DISSIMILAR])
@pytest.mark.parametrize("bulk", [{}, {"bulk_2": {"xx": 50.0}}])
def test_all_slips_in_gross_slip_with_a_certificate_that_says_so(bodies, bulk):
    """The force stays, while the motion is real: no cell counts as stick, and the energy is force times motion."""
    sizes = {"grid": {"points": 64, "size": 0.26}, "bodies": bodies}
    states = solve({"delta_x": 5e-3, "increments": 2, **bulk}, {"delta_x": 25e-3, "increments": 2}, **sizes)
    for state in states[-2:]:
        row = state.summary
        assert row.stick_cells == 0 and row.stick_radius == 0.0
        assert max(row.residual_slip, row.residual_bound, row.residual_load) < 1e-6
        assert pytest.approx(LIMIT, rel=1e-6) == row.Qx
        assert row.work == pytest.approx(LIMIT * 10e-3, rel=1e-3)
