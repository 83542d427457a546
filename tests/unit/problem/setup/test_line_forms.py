"""Closed forms of line contacts: when they hold, and what they give along a load path."""

from __future__ import annotations

import math

import numpy as np
import pytest
from line_cases import CATTANEO, DISSIMILAR, FRICTION, HERTZ, LOAD, SHEAR_FORCE, A, line_case

from fretsolve.problem.setup.line_forms import LineClosedForms
from fretsolve.simulation.problem_setup import set_up

UNIT = 4.0 * FRICTION * HERTZ.max_pressure
"""Bulk stress of b = 1 (MPa)."""


def forms_of(**keys):
    forms = set_up(line_case(**keys)).closed_forms
    assert isinstance(forms, LineClosedForms)
    return forms


def values_of(stage, **keys):
    return {form.quantity: form.value for form in forms_of(**keys).values() if form.stage == stage}


def test_values_of_a_cycle():
    path = [{"P": LOAD}, {"Qx": SHEAR_FORCE}, {"Qx": -SHEAR_FORCE}, {"Qx": SHEAR_FORCE}]
    found = values_of(3, load_path=path)
    assert found["contact_radius"] == pytest.approx(A)
    assert found["max_pressure"] == pytest.approx(HERTZ.max_pressure)
    assert found["stick_radius"] == pytest.approx(CATTANEO.stick_half_width)
    assert found["work_total"] == pytest.approx(1.25 * CATTANEO.work_per_cycle)


@pytest.mark.parametrize(
    "keys",
    [
        {"load_path": [{"P": LOAD, "phi_y": 1e-3}]},
        {"load_path": [{"delta_z": 1e-3}], "reference_depth": 10.0},
        {"surface": [{"cylinder": {"radius": 20.0}}, {"cylinder": {"radius": 20.0}}]},
        {"surface": {"punch": {"half_width": 0.2}}},
        {"surface": {"cylinder": {"radius": 10.0, "center": 0.01}}, "load_path": [{"P": LOAD, "My": 0.0}]},
    ],
)
def test_there_is_no_contact_for_others(keys):
    assert forms_of(**keys, grid={"points": 64, "size": 0.5}).widest is None


@pytest.mark.parametrize(
    "path",
    [
        [{"P": LOAD}, {"Qx": 5.0}, {"Qy": 5.0}],
        [{"P": LOAD}, {"Qx": 5.0}, {"P": 2.0 * LOAD}],
        [{"P": LOAD}, {"Qx": 40.0}],
        [{"P": LOAD}, {"bulk_2": {"xx": 50.0}}, {"Qx": 10.0}],
        [{"P": LOAD}, {"Qy": 5.0, "bulk_2": {"xx": 50.0}}],
    ],
)
def test_there_is_no_partial_slip_for_others(path):
    assert forms_of(load_path=path).partial_slip(len(path) - 1) is None


def test_dissimilar_bodies_have_no_exact_values():
    assert list(forms_of(bodies=DISSIMILAR).values()) == []


class TestBulkStress:
    def test_in_proportion(self):
        stage = {"Qx": SHEAR_FORCE, "bulk_2": {"xx": 0.2 * UNIT}}
        found = values_of(1, load_path=[{"P": LOAD}, stage])
        assert found["stick_center_x"] == pytest.approx(0.2 * A)
        assert found["stick_radius"] == pytest.approx(A * math.sqrt(0.4))
        assert found["work_total"] == pytest.approx(1.05826e-3 / 4.0, rel=1e-5)

    def test_reversed_it_is_the_mirror_image(self):
        stages = [{"Qx": sign * SHEAR_FORCE, "bulk_2": {"xx": sign * 0.2 * UNIT}} for sign in (1.0, -1.0)]
        found = values_of(2, load_path=[{"P": LOAD}, *stages])
        assert found["stick_center_x"] == pytest.approx(0.2 * A)
        assert found["work_total"] == pytest.approx(0.75 * 1.05826e-3, rel=1e-5)

    def test_where_slip_reverses_part_of_a_reversal_is_unknown(self):
        stages = [{"Qx": part * 9.0, "bulk_2": {"xx": part * 0.2 * UNIT}} for part in (1.0, -0.5, -1.0)]
        first, half, whole = (forms_of(load_path=[{"P": LOAD}, *stages]).partial_slip(stage) for stage in (1, 2, 3))
        assert half is None
        assert first is not None and whole is not None
        assert whole.stick_center == pytest.approx(first.stick_center)
        assert first.shear(np.zeros(1)) is None


@pytest.mark.parametrize(("b", "known"), [(0.2, True), (0.29, True), (0.31, False), (0.5, False)])
def test_none_where_a_slip_zone_shrinks_on_the_way(b, known):
    """At Q = 0.6 mu P the edge away from the stick zone slips backwards from b = 0.3 on, and sticks again later."""
    shear = forms_of(load_path=[{"P": LOAD}, {"Qx": SHEAR_FORCE, "bulk_2": {"xx": b * UNIT}}]).partial_slip(1)
    assert (shear is not None) is known


def smallest_of_all_stages(forms):
    """Return value and stage of the smallest stick zone, from the partial slip of every stage."""
    found = [(forms.partial_slip(stage), stage) for stage in range(len(forms.loads))]
    known = [(abs(one.path[-1]), -stage) for one, stage in found if one is not None and one.path[-1]]
    if found[-1][0] is None or not known:
        return None
    force, stage = max(known)  # the first stage of equal ones
    largest = forms.partial_slip(-stage).on_loading(force)
    return (largest.stick_half_width, -stage) if largest.is_known else None


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("bulk", [0.0, 0.05, 0.4])
def test_the_smallest_stick_zone_of_a_path_is_the_smallest_of_its_stages(seed, bulk):
    forces = np.random.default_rng(seed).uniform(-0.9, 0.9, 12).round(1) * FRICTION * LOAD
    forces = forces if seed % 2 else np.repeat(forces[:3], 4) * (-1.0) ** np.arange(12)
    stages = [{"Qx": force} | ({"bulk_2": {"xx": bulk * UNIT * force / LOAD}} if bulk else {}) for force in forces]
    forms = forms_of(load_path=[{"P": LOAD}, *stages])
    found = forms.smallest_stick
    assert (found and (found.value, found.stage)) == smallest_of_all_stages(forms)
    assert bulk == 0.4 or found is not None


def test_few_partial_slips_are_looked_at_however_many_stages_there_are(monkeypatch):
    solve, solved = LineClosedForms.partial_slip, []
    monkeypatch.setattr(
        LineClosedForms, "partial_slip", lambda self, stage: (solved.append(stage), solve(self, stage))[1]
    )

    def looked_at(times):
        cycle = {"stages": [{"Qx": 0.5 * SHEAR_FORCE}, {"Qx": -SHEAR_FORCE}, {"Qx": SHEAR_FORCE}], "times": times}
        forms = forms_of(load_path=[{"P": LOAD}, {"cycle": cycle}])
        solved.clear()
        assert (forms.smallest_stick.stage, forms.smallest_stick.value) == (2, CATTANEO.stick_half_width)
        assert len({id(contact) for contact in forms.contacts}) == 1
        return len(solved)

    assert looked_at(3) == looked_at(60) == 2
