"""Closed-form curves in pictures."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from line_cases import CATTANEO, DISSIMILAR, FRICTION, LOAD, SHEAR_FORCE, A, line_case
from line_cases import HERTZ as LINE_HERTZ

from fretsolve.post.plots.reference import closed_forms, hertz_pressure, shear_form, slip_form, stick_form
from fretsolve.result import Result


@pytest.mark.parametrize("step", [5, 17, 32])
def test_closed_form_of_the_shear_remembers_the_turning_points(results: dict[str, Result], step: int) -> None:
    result = results["mindlin"]
    form = shear_form(result, step, closed_forms(result))
    assert form is not None
    x, y = np.meshgrid(result.x, result.y, indexing="ij")
    exact = form.at(x.ravel(), y.ravel()).reshape(2, *x.shape)
    assert not exact[1].any()
    off = np.abs(exact[0] - result.field("shear_x", step))[np.hypot(x, y) < 0.28]
    assert np.median(off) < 1e-3 * 210.6
    assert np.percentile(off, 90) < 1e-2 * 210.6  # the rest lies in cells at the edges of stick zones


def test_closed_form_of_torsion(results: dict[str, Result]) -> None:
    result = results["torsion"]
    form = shear_form(result, 3, closed_forms(result))
    assert form is not None and form.name == "Lubkin"
    inside = np.abs(result.x) < 0.15
    exact = form.at(result.x[inside], np.zeros(inside.sum()))
    middle = len(result.y) // 2
    found = result.field("shear_y", 3)[inside, middle - 1 : middle + 1].mean(axis=1)
    np.testing.assert_allclose(exact[1], found, atol=0.02 * 210.6)
    assert (
        shear_form(results["fretting"], 4, closed_forms(results["fretting"])) is None
    )  # pressure and shear act on each other


def test_hertz_of_a_turned_tilted_ellipsoid(results: dict[str, Result]) -> None:
    result = results["hertz"]
    form = hertz_pressure(result, 1, closed_forms(result))
    assert form is not None
    x, y = np.meshgrid(result.x, result.y, indexing="ij")
    off = form.at(x.ravel(), y.ravel()).reshape(x.shape) - result.field("pressure")
    inside = result.field("pressure") > 500.0
    assert np.abs(off)[inside].max() < 0.03 * result.history["max_pressure"][1]


X = np.linspace(-1.5 * A, 1.5 * A, 6001)
ACROSS = np.zeros_like(X)
SHEARED = {"P": LOAD, "Qx": SHEAR_FORCE}


def line_result(*loads: dict[str, float], phi_y: float = 0.0, **keys: Any) -> Any:
    """Return what the pictures read of the result of a line contact under `loads`."""
    history = {name: np.array([load.get(name, 0.0) for load in loads]) for name in ("P", "Qx", "Qy", "Mz")}
    history |= {"phi_y": np.full(len(loads), phi_y)}
    return SimpleNamespace(case=line_case(**keys), history=history)


def test_pressure_rolls_aside_with_a_tilted_cylinder() -> None:
    surface = {"cylinder": {"radius": 10.0, "center": 0.01}}
    curve = hertz_pressure(
        line_result({"P": LOAD}, phi_y=2e-3, surface=surface),
        0,
        closed_forms(line_result({"P": LOAD}, phi_y=2e-3, surface=surface)),
    )
    assert curve is not None
    pressure = curve.at(X, ACROSS)
    assert curve.name == "Hertz"
    assert np.trapezoid(pressure, X) == pytest.approx(LOAD, rel=1e-4)
    assert np.trapezoid(X * pressure, X) / LOAD == pytest.approx(0.01 + 10.0 * 2e-3, rel=1e-4)
    assert pressure.max() == pytest.approx(LINE_HERTZ.max_pressure, rel=1e-4)


@pytest.mark.parametrize(("force", "axis"), [("Qx", 0), ("Qy", 1)])
def test_shear_and_slip_are_along_the_force(force: str, axis: int) -> None:
    loads = {"P": LOAD}, {"P": LOAD, force: SHEAR_FORCE}
    result = line_result(*loads, load_path=[{"P": LOAD}, {force: SHEAR_FORCE}])
    assert shear_form(result, 0, closed_forms(result)) is None and slip_form(result, 0, closed_forms(result)) is None
    shear, slip = shear_form(result, 1, closed_forms(result)), slip_form(result, 1, closed_forms(result))
    assert shear is not None and slip is not None
    traction, path = shear.at(X, ACROSS), slip.at(X, ACROSS)
    assert np.trapezoid(traction[axis], X) == pytest.approx(SHEAR_FORCE, rel=1e-3)
    assert not traction[1 - axis].any() and not path[1 - axis].any()
    sticks = np.abs(X) < 0.99 * CATTANEO.stick_half_width
    slips = (np.abs(X) > 1.01 * CATTANEO.stick_half_width) & (np.abs(X) < 0.99 * A)
    np.testing.assert_allclose(path[axis][sticks], 0.0, atol=1e-12)
    assert (np.abs(path[axis][slips]) > 0.0).all()
    np.testing.assert_allclose(traction[axis][slips], FRICTION * LINE_HERTZ.pressure(X[slips]), rtol=1e-9)


def test_stick_zone_over_the_force() -> None:
    result = line_result({"P": LOAD}, {**SHEARED, "Qx": 0.5 * SHEAR_FORCE}, SHEARED)
    found = stick_form(result, "Qx")
    assert found is not None
    np.testing.assert_allclose(found[1][1:], np.sqrt(1.0 - np.array([0.3, 0.6])), rtol=1e-9)
    assert stick_form(result, "Qy") is None and stick_form(result, "P") is None


@pytest.mark.parametrize("layer", ["shear_compliance", "normal_compliance"])
def test_no_curve_that_a_layer_changes(layer: str) -> None:
    result = line_result({"P": LOAD}, SHEARED, interface={layer: 1e-6})
    assert (hertz_pressure(result, 1, closed_forms(result)) is None) == (layer == "normal_compliance")
    assert shear_form(result, 1, closed_forms(result)) is None and slip_form(result, 1, closed_forms(result)) is None
    assert stick_form(result, "Qx") is None


def test_no_stick_zone_by_spence_with_a_layer_that_shears() -> None:
    plain, layered = (
        line_result({"P": 0.5 * LOAD}, {"P": LOAD}, load_path=[{"P": LOAD}], bodies=DISSIMILAR, **more)
        for more in ({}, {"interface": {"shear_compliance": 1e-6}})
    )
    assert stick_form(plain, "P") is not None
    assert stick_form(layered, "P") is None
