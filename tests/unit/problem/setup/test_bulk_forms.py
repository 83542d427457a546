"""Which force and bulk stress on a sphere have a closed form, and why others do not."""

from __future__ import annotations

import pytest
from solving import DISSIMILAR, HERTZ, LOAD, MATERIAL, build

from fretsolve.problem.setup.closed_forms import ClosedForms
from fretsolve.reference.hertz import hertz_elliptic
from fretsolve.simulation.problem_setup import set_up

PATH = [{"P": LOAD}, {"Qx": 20.0, "bulk_2": {"xx": 30.0}}]
PRESSED = {"P": LOAD, "Qx": 0.0, "Qy": 0.0}
LOADS = (PRESSED, {"P": LOAD, "Qx": 20.0, "Qy": 0.0, "bulk_2_xx": 30.0})


def found(loads=LOADS, contacts=(HERTZ, HERTZ), **parts):
    setup = set_up(build(**{"grid": {"points": 8}, "load_path": PATH, "coupling": "none", **parts}))
    forms = ClosedForms(setup.case, setup.model, loads)
    vars(forms)["hertz"] = contacts
    return forms.under_bulk


def needed_across() -> float:
    """The mismatch along y over that along x that the closed form needs where directions are coupled."""
    text = found(coupling="tangential")
    assert text.startswith("it needs a mismatch along y of ")
    assert text.endswith(" times that along x, not -0.3")
    return float(text.split()[7])


def test_without_coupling_of_the_directions_any_mismatch_along_y_but_none_is_refused():
    nu = 0.3  # bulk stress yy = nu xx strains body 2 along x alone
    stage, form = found((PRESSED, {**LOADS[1], "bulk_2_yy": nu * 30.0}))
    assert stage == 1
    assert form.shear_force == 20.0
    assert form.mismatch == pytest.approx((1.0 - nu**2) * 30.0 / 200e3)
    assert found() == "it needs a mismatch along y of 0 times that along x, not -0.3"


def test_with_it_the_needed_mismatch_is_named_and_then_taken():
    ratio = needed_across()
    # of xx and yy: e_yy/e_xx = (yy - nu xx)/(xx - nu yy)
    yy = 30.0 * (ratio + 0.3) / (1.0 + 0.3 * ratio)
    _, form = found((PRESSED, {**LOADS[1], "bulk_2_yy": yy}), coupling="tangential")
    assert form.mismatch_across / form.mismatch == pytest.approx(ratio, rel=1e-3)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"Qy": 1.0}, "it needs a force Qx and no other, and no shear stress"),
        ({"bulk_2_xy": 1.0}, "it needs a force Qx and no other, and no shear stress"),
        ({"Qx": 0.0}, "it needs a force Qx and no other, and no shear stress"),
        ({"P": 300.0}, "P changes under shear"),
        ({"bulk_2_xx": 3e3}, "the stick zone reaches the edge of the contact"),
    ],
)
def test_loads_without_one(changes, reason):
    assert found((PRESSED, {**LOADS[1], **changes})) == reason


def test_force_and_stress_one_after_the_other_have_none():
    loads = (PRESSED, {"P": LOAD, "Qx": 20.0, "Qy": 0.0}, LOADS[1])
    path = [{"P": LOAD}, {"Qx": 20.0}, {"bulk_2": {"xx": 30.0}}]
    assert found(loads, (HERTZ,) * 3, load_path=path) == "force and bulk stress are not in proportion"


@pytest.mark.parametrize(
    ("contacts", "parts"),
    [
        ((None, None), {}),
        ((hertz_elliptic(LOAD, 10.0, 20.0, MATERIAL.contact_modulus),) * 2, {}),
        ((HERTZ, HERTZ), {"bodies": DISSIMILAR, "coupling": "full"}),
    ],
)
def test_other_contacts_have_none(contacts, parts):
    assert found(contacts=contacts, **parts) == "it needs a sphere on a body of its own material"
