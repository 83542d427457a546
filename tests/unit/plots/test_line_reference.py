"""Closed-form curves of line contacts in pictures."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from line_cases import CATTANEO, DISSIMILAR, FRICTION, HERTZ, LOAD, SHEAR_FORCE, A, line_case

from fretsolve.plots.line_reference import line_pressure, line_shear, line_slip, line_stick
from fretsolve.reference.line import pressed_stick_ratio
from fretsolve.setup.closed_forms.area_forms import ClosedForms
from fretsolve.setup.problem_setup import set_up

X = np.linspace(-1.5 * A, 1.5 * A, 6001)
ACROSS = np.zeros_like(X)


def forms_of(**keys: Any) -> ClosedForms:
    return set_up(line_case(**keys)).closed_forms


def test_pressure_rolls_aside_with_a_tilted_cylinder() -> None:
    surface = {"cylinder": {"radius": 10.0, "center": 0.01}}
    curve = line_pressure(forms_of(surface=surface), 0, 2e-3)
    assert curve is not None
    pressure = curve.at(X, ACROSS)
    assert curve.name == "Hertz"
    assert np.trapezoid(pressure, X) == pytest.approx(LOAD, rel=1e-4)
    assert np.trapezoid(X * pressure, X) / LOAD == pytest.approx(0.01 + 10.0 * 2e-3, rel=1e-4)
    assert pressure.max() == pytest.approx(HERTZ.max_pressure, rel=1e-4)


def test_a_tilted_punch_has_no_curve() -> None:
    forms = forms_of(surface={"punch": {"half_width": 0.5, "edge_radius": 200.0}})
    assert line_pressure(forms, 0, 0.0) is not None
    assert line_pressure(forms, 0, 1e-4) is None


@pytest.mark.parametrize(("force", "axis"), [("Qx", 0), ("Qy", 1)])
def test_shear_and_slip_are_along_the_force(force: str, axis: int) -> None:
    forms = forms_of(load_path=[{"P": LOAD}, {force: SHEAR_FORCE}])
    shear, slip = line_shear(forms, 1, 0.0), line_slip(forms, 1, 0.0)
    assert shear is not None and slip is not None
    traction, path = shear.at(X, ACROSS), slip.at(X, ACROSS)
    assert np.trapezoid(traction[axis], X) == pytest.approx(SHEAR_FORCE, rel=1e-3)
    assert not traction[1 - axis].any()
    assert not path[1 - axis].any()
    sticks = np.abs(X) < 0.99 * CATTANEO.stick_half_width
    slips = (np.abs(X) > 1.01 * CATTANEO.stick_half_width) & (np.abs(X) < 0.99 * A)
    np.testing.assert_allclose(path[axis][sticks], 0.0, atol=1e-12)
    assert (np.abs(path[axis][slips]) > 0.0).all()
    np.testing.assert_allclose(traction[axis][slips], FRICTION * HERTZ.pressure(X[slips]), rtol=1e-9)


def test_nothing_is_drawn_before_shear() -> None:
    forms = forms_of()
    assert line_shear(forms, 0, 0.0) is None
    assert line_slip(forms, 0, 0.0) is None


def test_stick_zone_over_the_force() -> None:
    path = [{"P": LOAD}, {"Qx": 0.5 * SHEAR_FORCE}, {"Qx": SHEAR_FORCE}]
    found = line_stick(forms_of(load_path=path), 3, "Qx")
    assert found is not None
    np.testing.assert_allclose(found[1][1:], np.sqrt(1.0 - np.array([0.3, 0.6])), rtol=1e-9)
    assert line_stick(forms_of(load_path=path), 3, "Qy") is None
    assert line_stick(forms_of(load_path=path), 3, "P") is None


def test_stick_zone_of_pressing_alone() -> None:
    forms = forms_of(bodies=DISSIMILAR, load_path=[{"P": LOAD}])
    found = line_stick(forms, 4, "P")
    assert found is not None
    name, ratios = found
    assert name == "Spence, one-way"
    assert ratios.tolist() == [pressed_stick_ratio(FRICTION, forms.model.compliances.dundurs_constant)] * 4
    assert 0.0 < ratios[0] < 1.0
