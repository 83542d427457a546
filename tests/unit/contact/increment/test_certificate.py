"""The certificate finds errors of a right solution, and the zones of its cells."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from solving import DISSIMILAR, FRICTION, MOTIONS, build, solve

from fretsolve.contact.increment.certificate import Solution, Verifier
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.problem.friction.limit import FrictionLimit
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.result.state import Zone
from fretsolve.simulation.problem_setup import set_up

PARTS = {
    "bodies": DISSIMILAR,
    "grid": {"points": 24, "size": 0.75},
    "load_path": [{"P": 400.0, "increments": 2}, {"Qx": 30.0, "Qy": 4.0, "Mz": 1.0, "increments": 2}],
    "solver": {"tolerance": 1e-9},
}
NORMAL = LoadControl((True, False, False), (400.0, 0.0, 0.0))
TANGENTIAL = LoadControl((True, True, True), (30.0, 4.0, 1.0))
RESIDUALS = ("gap", "stick", "slip", "bound", "load")
CELL = (12, 12)


@pytest.fixture(scope="module")
def solved():
    """Scene, operator, verifier, and a right solution from the last two states."""
    setup = set_up(build(**PARTS))
    grid, model = setup.grid, setup.model
    before, after = solve(**PARTS)[-2:]
    operator = ElasticOperator(grid.shape, (grid.dx, grid.dy), model.compliances, model.terms)
    verifier = Verifier(setup.separation(), FRICTION, grid, 1e-9)
    rigid, start = (np.array([getattr(state.summary, name) for name in MOTIONS]) for state in (after, before))
    fields = after.fields
    solution = Solution(
        fields.pressure,
        fields.shear,
        np.empty(grid.shape),
        after.displacement,
        rigid,
        rigid - start,
        before.displacement,
        FrictionLimit(FRICTION),
        0.0,
    )
    return operator, verifier, displaced(operator, solution)


def displaced(operator, solution):
    """The solution with the displacements that belong to its tractions."""
    uz, displacement = np.empty_like(solution.uz), np.empty_like(solution.displacement)
    operator.all(solution.pressure, solution.shear, uz, displacement)
    return replace(solution, uz=uz, displacement=displacement)


def pressed(operator, solution, changed):
    """The solution with the displacements of a pressure to which `changed` adds, by cell."""
    pressure = solution.pressure.copy()
    for cell, value in changed.items():
        pressure[cell] += value
    return displaced(operator, replace(solution, pressure=pressure))


def residuals(verifier, solution):
    certificate = verifier.verify(solution, NORMAL, TANGENTIAL).certificate
    return {name: getattr(certificate, name) for name in RESIDUALS}


def test_a_solution_is_certified(solved):
    _, verifier, solution = solved
    verified = verifier.verify(solution, NORMAL, TANGENTIAL)
    assert verified.certificate.worst < 1e-9
    assert set(np.unique(verified.zone)) == {Zone.OPEN, Zone.STICK, Zone.SLIP}
    assert (verified.gap[verified.zone == Zone.OPEN] > 0.0).all()
    assert not verified.slip[:, verified.zone == Zone.OPEN].any()


@pytest.mark.parametrize("error", [1e-2, 1e-6])
class TestSpoilt:
    def test_pressure_of_one_cell(self, solved, error):
        operator, verifier, solution = solved
        found = residuals(verifier, pressed(operator, solution, {CELL: error * solution.pressure[CELL]}))
        assert found["gap"] > 0.01 * error
        assert found["load"] > 1e-3 * error

    def test_cell_left_out_of_the_contact(self, solved, error):
        operator, verifier, solution = solved
        left_out = pressed(operator, solution, {CELL: -solution.pressure[CELL]})
        assert residuals(verifier, left_out)["gap"] > 0.01 > error / 2

    def test_approach(self, solved, error):
        _, verifier, solution = solved
        rigid = solution.rigid.copy()
        rigid[0] *= 1.0 + error
        found = residuals(verifier, replace(solution, rigid=rigid))
        assert found["gap"] == pytest.approx(error, rel=0.01)
        assert found["stick"] < 1e-9

    def test_tilt(self, solved, error):
        _, verifier, solution = solved
        rigid = solution.rigid + error * np.array([0.0, 0.0, 1e-2, 0.0, 0.0, 0.0])
        assert residuals(verifier, replace(solution, rigid=rigid))["gap"] > 0.05 * error

    def test_shear_beyond_the_friction_limit(self, solved, error):
        operator, verifier, solution = solved
        shear = solution.shear.copy()
        slipping = np.unravel_index(np.argmax(np.hypot(*shear)), shear.shape[1:])
        shear[(slice(None), *slipping)] *= 1.0 + error
        found = residuals(verifier, displaced(operator, replace(solution, shear=shear)))
        assert found["bound"] > 0.5 * error

    def test_shear_in_the_stick_zone(self, solved, error):
        """It is below the friction limit, but the cell no longer sticks."""
        operator, verifier, solution = solved
        zone = verifier.verify(solution, NORMAL, TANGENTIAL).zone
        sticking = np.argwhere(zone == Zone.STICK)[5]
        shear = solution.shear.copy()
        shear[(0, *sticking)] -= error * FRICTION * solution.pressure.max()
        found = residuals(verifier, displaced(operator, replace(solution, shear=shear)))
        assert found["stick"] > 0.01 * error
        assert found["bound"] < 1e-6

    def test_direction_of_the_shear(self, solved, error):
        """Turned on the friction circle: friction limit and sticking cells hold, the slip law does not."""
        _, verifier, solution = solved
        zone = verifier.verify(solution, NORMAL, TANGENTIAL).zone
        cosine, sine = np.cos(error), np.sin(error)
        slips = zone == Zone.SLIP
        qx, qy = solution.shear
        shear = np.where(slips, np.stack([cosine * qx - sine * qy, sine * qx + cosine * qy]), solution.shear)
        found = residuals(verifier, replace(solution, shear=shear))
        assert found["slip"] == pytest.approx(error, rel=0.1)
        assert found["stick"] < 1e-9

    @pytest.mark.parametrize("mode", [3, 4, 5])
    def test_tangential_rigid_displacement(self, solved, error, mode):
        _, verifier, solution = solved
        motion, (largest, _) = solution.motion.copy(), verifier.slip_scales(solution, 0.0)
        motion[mode] += error * largest / verifier.normal.arms[mode]
        found = residuals(verifier, replace(solution, motion=motion))
        assert found["stick"] > 0.05 * error
        assert found["gap"] < 1e-9

    @pytest.mark.parametrize("mode", range(3))
    def test_load(self, solved, error, mode):
        _, verifier, solution = solved
        values = list(TANGENTIAL.values)
        values[mode] += error * FRICTION * 400.0
        found = verifier.verify(solution, NORMAL, LoadControl(TANGENTIAL.forced, tuple(values))).certificate
        assert found.load > 0.5 * error
        assert max(found.gap, found.stick, found.slip, found.bound) < 1e-9

    def test_normal_load(self, solved, error):
        _, verifier, solution = solved
        wrong = LoadControl(NORMAL.forced, (400.0 * (1.0 + error), 0.0, 0.0))
        assert verifier.verify(solution, wrong, TANGENTIAL).certificate.load == pytest.approx(error, rel=0.01)


def test_shear_against_the_slip(solved):
    """A slip zone whose shear drives instead of resisting is the worst error of direction."""
    _, verifier, solution = solved
    assert residuals(verifier, replace(solution, shear=-solution.shear))["slip"] > 1.0


def test_displacements_that_do_not_belong_to_the_tractions(solved):
    _, verifier, solution = solved
    assert residuals(verifier, replace(solution, uz=1.001 * solution.uz))["gap"] > 1e-4


def test_negative_pressure_is_no_contact(solved):
    """Tension would hold the surfaces together: the cell counts as open, so that its penetration shows."""
    operator, verifier, solution = solved
    found = residuals(verifier, pressed(operator, solution, {CELL: -1.0 - solution.pressure[CELL]}))
    assert max(found.values()) > 1e-3


def test_no_contact_and_no_load(solved):
    _, verifier, solution = solved
    nothing = np.zeros_like(solution.shear)
    apart = Solution(
        nothing[0], nothing, nothing[0], nothing, np.zeros(6), np.zeros(6), nothing, FrictionLimit(FRICTION), 0.0
    )
    unloaded = LoadControl((True, False, False), (0.0, 0.0, 0.0))
    verified = verifier.verify(apart, unloaded, LoadControl((True, True, False), (0.0, 0.0, 0.0)))
    assert verified.certificate.worst == 0.0
    assert not verified.zone.any()
    loaded = verifier.verify(apart, NORMAL, LoadControl((True, True, False), (0.0, 0.0, 0.0)))
    assert loaded.certificate.load > 1.0


def test_penetration_without_contact_is_refused(solved):
    """It is measured against a part of the rigid displacement so small that only rounding passes."""
    _, verifier, solution = solved
    nothing, rigid = np.zeros_like(solution.shear), np.array([1e-3, 0.0, 0.0, 0.0, 0.0, 0.0])
    through = Solution(nothing[0], nothing, nothing[0], nothing, rigid, rigid, nothing, FrictionLimit(FRICTION), 0.0)
    verified = verifier.verify(through, LoadControl((False, False, False), (1e-3, 0.0, 0.0)), TANGENTIAL)
    assert verified.certificate.gap > 1e3


@pytest.mark.parametrize("field", ["pressure", "shear", "uz", "displacement"])
def test_a_value_that_is_no_number_is_refused(solved, field):
    _, verifier, solution = solved
    spoilt = getattr(solution, field).copy()
    spoilt[..., 12, 12] = np.nan
    with np.errstate(invalid="ignore"):
        worst = verifier.verify(replace(solution, **{field: spoilt}), NORMAL, TANGENTIAL).certificate.worst
    assert not worst <= 1.0


def test_tension_is_refused(solved):
    """Also where the glued surfaces have no gap and friction does not notice."""
    operator, verifier, solution = solved
    frictionless = Verifier(verifier.separation, 0.0, verifier.grid, 1e-9)
    glued = pressed(operator, solution, {(0, 0): -0.01 * solution.pressure.max()})
    glued = replace(glued, shear=0.0 * solution.shear)
    assert frictionless.verify(glued, NORMAL, TANGENTIAL).certificate.gap >= 0.01


def test_imposed_displacements_are_checked(solved):
    _, verifier, solution = solved
    dz, dx = solution.rigid[0], solution.rigid[3]
    right = LoadControl((False, False, False), (dz, 0.0, 0.0)), LoadControl((False, True, True), (dx, 4.0, 1.0))
    assert verifier.verify(solution, *right).certificate.load < 1e-9
    for wrong in (
        (LoadControl((False, False, False), (1.01 * dz, 0.0, 0.0)), right[1]),
        (right[0], LoadControl((False, True, True), (1.1 * dx, 4.0, 1.0))),
    ):
        assert verifier.verify(solution, *wrong).certificate.load > 1e-3


def test_cells_stick_where_nothing_moves(solved):
    """As under a normal load alone, for which the certificate looks at no slip; a mismatch of the surfaces counts."""
    _, verifier, solution = solved
    still = np.zeros_like(solution.shear)
    motion = np.zeros(6)
    solution = replace(solution, shear=still, displacement=still, previous_displacement=still, motion=motion)
    verified = verifier.verify(solution, NORMAL, LoadControl((True, True, True), (0.0, 0.0, 0.0)))
    assert (verified.zone == np.where(solution.pressure > 0.0, Zone.STICK, Zone.OPEN)).all()
    assert verified.certificate.stick == verified.certificate.slip == 0.0 == np.abs(verified.slip).max()
    moved = replace(solution, previous_displacement=np.full_like(still, 1e-3))
    assert verifier.verify(moved, NORMAL, TANGENTIAL).certificate.stick > 0.1
