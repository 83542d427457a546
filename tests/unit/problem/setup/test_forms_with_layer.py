"""Closed forms and warnings of cases with a layer between the bodies: what it changes, and what is not given."""

from __future__ import annotations

import math
from typing import Any

import pytest
from line_cases import line_case
from solving import DISSIMILAR, FRICTION, HERTZ, MATERIAL, SIMILAR, build

from fretsolve.case.keys.body_specs import ElasticBody
from fretsolve.problem.model.materials import compliances
from fretsolve.problem.setup.closed_forms import ClosedForms
from fretsolve.problem.setup.warnings import case_warnings
from fretsolve.problem.setup.wear_forms import worn_cycles
from fretsolve.reference.layered import layered_stick_compliance
from fretsolve.simulation.problem_setup import set_up

L = 2e-6
SHEARS, YIELDS = {"shear_compliance": L}, {"normal_compliance": L}
PATH = [{"P": 400.0}, {"Qx": 36.0}, {"Qx": -36.0}]


def forms_of(interface: dict[str, Any], *stages: dict[str, Any], **parts: Any) -> ClosedForms:
    case = build(load_path=list(stages or PATH), grid={"points": 12, "size": 1.0}, interface=interface, **parts)
    return set_up(case).closed_forms


def test_a_layer_that_shears_leaves_hertz_and_takes_mindlin() -> None:
    forms = forms_of(SHEARS)
    assert forms.largest == HERTZ
    assert forms.tangential(1) is None
    assert forms.smallest_stick is None
    assert {form.source for form in forms.values()} == {"Hertz"}
    assert forms.why_not_mindlin == "a layer between the bodies shears, which Cattaneo and Mindlin do not have"


def test_a_layer_that_is_compressed_leaves_no_closed_form_of_pressing() -> None:
    for surface in ({"sphere": {"radius": 10.0}}, {"punch": {"radius": 0.3}}, {"cone": {"angle": 0.01}}):
        forms = forms_of(YIELDS, surface=surface)
        assert forms.largest is None and forms.punch is None and forms.cylinder(1.0) is None
        assert forms.contact_width(1.0) is None or "punch" in surface
        assert not list(forms.values())


def test_neither_spence_nor_a_shifted_stick_zone_with_a_layer_that_shears() -> None:
    assert forms_of(SHEARS, {"P": 400.0}, bodies=DISSIMILAR).smallest_stick is None
    bulk = forms_of(SHEARS, {"P": 400.0}, {"Qx": 20.0, "bulk_2": {"xx": 10.0}})
    assert bulk.under_bulk == "it needs bodies without a layer between them"
    assert bulk.smallest_stick is None
    moved = forms_of(SHEARS, {"P": 400.0}, {"delta_x": 1e-4})
    assert moved.smallest_stick is None


def test_gross_slip_begins_when_the_middle_slips() -> None:
    _, torque, moved = forms_of(SHEARS).gross_slip(400.0, HERTZ)
    bodies = 3.0 * MATERIAL.tangential * FRICTION * 400.0 / (16.0 * HERTZ.contact_radius)
    assert moved == pytest.approx(bodies + L * FRICTION * HERTZ.max_pressure)
    assert torque == pytest.approx(7.0947, rel=1e-4)


def test_the_stiffness_just_after_a_reversal() -> None:
    stick = forms_of(SHEARS).full_stick(HERTZ)
    assert stick == layered_stick_compliance(HERTZ.contact_radius, MATERIAL.tangential, L)
    assert stick > MATERIAL.tangential / (8.0 * HERTZ.contact_radius)
    assert forms_of(SHEARS, bodies=DISSIMILAR).full_stick(HERTZ) is None


def line_forms(interface: dict[str, float]) -> ClosedForms:
    return set_up(line_case(interface=interface)).closed_forms


def test_line_contacts() -> None:
    sheared, pressed = line_forms(SHEARS), line_forms(YIELDS)
    assert sheared.widest is not None and {form.source for form in sheared.values()} == {"Hertz"}
    assert sheared.smallest_stick is None and sheared.why_not_mindlin
    assert pressed.widest is None and not list(pressed.values())


def test_an_automatic_size_holds_the_contact_on_a_compliant_layer() -> None:
    """A bed of springs has the radius sqrt(2 R d), pi R d^2 = P L."""
    setup = set_up(build(interface={"normal_compliance": 1.0}, grid={"points": 48}))
    radius = math.sqrt(20.0 * math.sqrt(400.0 / (math.pi * 10.0)))
    assert setup.grid.size[0] == pytest.approx(2.4 * radius, rel=0.1)


def test_what_a_cycle_wears_in_gross_slip_counts_from_the_layers_onset() -> None:
    cycle = {"represents": 1e4, "stages": [{"delta_x": -0.015}, {"delta_x": 0.015}]}
    path = [{"P": 400.0}, {"delta_x": 0.015}, {"cycle": cycle}]
    common = {"load_path": path, "wear": {"law": "energy", "alpha": 1e-6}, "grid": {"points": 16}}
    found = [worn_cycles(set_up(build(**common, **more)).closed_forms)[0] for more in ({}, {"interface": SHEARS})]
    plain, layered = (one.sliding_distance for one in found)
    assert plain - layered == pytest.approx(2.0 * L * FRICTION * HERTZ.max_pressure)
    assert found[1].limit is None


def test_friction_that_falls_on_a_layer_is_warned_of_by_as_much_as_the_run_finds() -> None:
    """The layer's own part is the largest fall times L, more than which both together do not have."""
    falling = {"initial": 0.3, "final": 0.1, "slip": 1e-3}
    parts = {"friction": falling, "load_path": [{"P": 400.0}, {"delta_x": 1e-3}], "grid": {"points": 16}}
    said = []
    for interface in (None, {"shear_compliance": 1e-3}):
        texts = case_warnings(set_up(build(**parts, **({} if interface is None else {"interface": interface}))))
        said.append(next(text for text in texts if text.startswith("friction.slip")))
    plain, layered = (float(text.split(" times")[0].rsplit(" ", 1)[1]) for text in said)
    assert layered - plain == pytest.approx(0.2 * HERTZ.max_pressure / 1e-3 * 1e-3, rel=0.01)


def test_moduli_of_a_layer_stand_for_its_compliances() -> None:
    layer = {"thickness": "5 um", "shear_modulus": "2 GPa", "normal_modulus": "6 GPa"}
    found = set_up(build(interface=layer, grid={"points": 12, "size": 1.0})).model.compliances
    assert (found.layer_shear, found.layer_normal) == (pytest.approx(2.5e-6), pytest.approx(5e-3 / 6e3))
    bodies = compliances(*(ElasticBody.model_validate(body) for body in SIMILAR))
    assert (found.A, found.B, found.C) == (bodies.A, bodies.B, bodies.C)
