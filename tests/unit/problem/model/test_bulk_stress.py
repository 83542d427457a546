"""The mismatch of the surfaces under bulk stress, and what a load path with bulk stress imposes and requires."""

from __future__ import annotations

import pytest
from solving import LOAD, build

from fretsolve.case.keys.body_specs import ElasticBody
from fretsolve.problem.model.materials import BulkResponse, surface_strain
from fretsolve.problem.model.required_terms import derive_model
from fretsolve.simulation.error_bars.coarse_runs import slipping_stages
from fretsolve.simulation.problem_setup import set_up

STEEL = ElasticBody(young_modulus=200e3, poisson_ratio=0.3)


def load_path(*stages, **parts):
    setup = set_up(build(grid={"points": 32}, load_path=[{"P": LOAD}, *stages], **parts))
    return setup.load_path, setup


class TestStrain:
    def test_plane_stress(self):
        xx, yy, xy = surface_strain(STEEL, [100.0, 40.0, 10.0])
        assert (xx, yy, xy) == pytest.approx((88.0 / 200e3, 10.0 / 200e3, 13.0 / 200e3), rel=1e-14)

    def test_plane_strain(self):
        """The stress along y, nu times that along x, keeps the strain there at 0."""
        strain = surface_strain(STEEL, [100.0, 0.0, 0.0], plane_strain=True)
        assert strain == pytest.approx(surface_strain(STEEL, [100.0, 30.0, 0.0]), abs=1e-18)
        assert strain == pytest.approx([0.91 * 100.0 / 200e3, 0.0, 0.0], rel=1e-14)

    def test_mismatch_is_that_of_body_2_less_body_1(self):
        response = BulkResponse((STEEL, STEEL))
        tension = response.mismatch({"bulk_2_xx": 80.0})
        assert tension == pytest.approx([4e-4, -1.2e-4, 0.0], rel=1e-14)
        assert response.mismatch({"bulk_1_xx": 80.0}) == pytest.approx(-tension, rel=1e-14)
        assert not response.mismatch({"bulk_1_xx": 80.0, "bulk_2_xx": 80.0}).any()
        assert BulkResponse(("rigid", STEEL)).mismatch({"bulk_2_xx": 80.0}) == pytest.approx(tension, rel=1e-14)


class TestModel:
    def test_a_case_without_bulk_stress_has_none(self):
        assert derive_model(build(grid={"points": 8})).bulk is None

    @pytest.mark.parametrize(
        "bulk", [{"bulk_2": {"xx": 0.0}}, {"bulk_1": {"xx": 80.0, "xy": 5.0}, "bulk_2": {"xx": 80.0, "xy": 5.0}}]
    )
    def test_nor_has_one_whose_surfaces_move_together(self, bulk):
        model = derive_model(build(grid={"points": 8}, load_path=[{"P": LOAD}, bulk]))
        assert (model.bulk, model.moved, model.has_shear) == (None, (), False)

    def test_bulk_stress_alone_requires_the_tangential_problem(self):
        model = derive_model(build(grid={"points": 8}, load_path=[{"P": LOAD}, {"bulk_2": {"xx": 80.0}}]))
        assert model.has_shear and model.may_slip and not model.coupled
        assert model.moved == ("bulk_2_xx",)
        frictionless = derive_model(
            build(grid={"points": 8}, friction=0.0, load_path=[{"P": LOAD}, {"bulk_2": {"xx": 80.0}}])
        )
        assert frictionless.may_slip and not frictionless.has_shear

    def test_closed_forms_without_bulk_stress_do_not_hold(self):
        forms = load_path({"Qx": 20.0, "bulk_2": {"xx": 80.0}}, coupling="none")[1].closed_forms
        assert forms.tangential(1) is None
        assert forms.smallest_stick is None
        found = {form.quantity for form in forms.values()}
        assert found == {"delta_z", "max_pressure", "contact_radius", "contact_area"}


class TestLoadPath:
    def test_kept_until_changed_and_ramped(self):
        path, _ = load_path(
            {"Qx": 20.0, "bulk_2": {"xx": 80.0, "yy": 8.0}, "increments": 2},
            {"Qx": 0.0, "increments": 2},
            {"bulk_1": {"xy": 10.0}, "bulk_2": {"xx": 0.0}, "increments": 2},
        )
        summaries = [None] * 7  # nothing changes between load and displacement control
        rows = [path.increment(step, summaries[:step]) for step in range(7)]
        names = ("bulk_1_xy", "bulk_2_xx", "bulk_2_yy")
        found = [tuple(row.bulk.get(name, 0.0) for name in names) for row in rows]
        assert found == [(0, 0, 0), (0, 40, 4), (0, 80, 8), (0, 80, 8), (0, 80, 8), (5, 40, 8), (10, 0, 8)]
        assert [row.strain_mismatch is None for row in rows] == [True, False, False, True, True, False, False]
        assert sum(row.strain_mismatch for row in rows if row.strain_mismatch is not None) == pytest.approx(
            BulkResponse((STEEL, STEEL)).mismatch({"bulk_1_xy": 10.0, "bulk_2_yy": 8.0}), abs=1e-18
        )

    def test_in_graded_increments_it_keeps_step_with_the_force(self):
        path, _ = load_path({"Qx": 20.0, "bulk_2": {"xx": 80.0}, "increments": 5, "spacing": "graded"})
        for step in range(1, 6):
            increment = path.increment(step, [None] * step)
            assert increment.bulk["bulk_2_xx"] == pytest.approx(4.0 * increment.tangential.values[0], rel=1e-14)

    def test_cycles_carry_it(self):
        cycle = {"cycle": {"times": 2, "stages": [{"bulk_2": {"xx": 80.0}}, {"bulk_2": {"xx": -80.0}}]}}
        path, _ = load_path({"Qx": 20.0}, cycle)
        assert [end.get("bulk_2_xx", 0.0) for end in path.imposed] == [0.0, 0.0, 80.0, -80.0, 80.0, -80.0]

    def test_the_path_matters_where_it_moves_with_a_force(self):
        alone, setup = load_path({"bulk_2": {"xx": 80.0}})
        assert not alone.path_dependent
        assert alone.counts == (1, 10)
        assert slipping_stages(setup) == (False, True)
        out_of_phase, _ = load_path({"Qx": 20.0}, {"bulk_2": {"xx": 80.0}})
        assert out_of_phase.path_dependent
        assert out_of_phase.counts[2] == 20
        pressed, _ = load_path({"bulk_2": {"xx": 80.0}}, {"P": 2.0 * LOAD})
        assert pressed.path_dependent
