"""Closed-form curves in pictures."""

from __future__ import annotations

import numpy as np
import pytest

from fretsolve.plots.reference import hertz_pressure, shear_form
from fretsolve.result import Result


@pytest.mark.parametrize("step", [5, 11, 17, 23, 29, 32])
def test_closed_form_of_the_shear_remembers_the_turning_points(results: dict[str, Result], step: int) -> None:
    result = results["mindlin"]
    form = shear_form(result, step)
    assert form is not None
    x, y = np.meshgrid(result.x, result.y, indexing="ij")
    exact = form.at(x.ravel(), y.ravel()).reshape(2, *x.shape)
    assert not exact[1].any()
    off = np.abs(exact[0] - result.field("shear_x", step))[np.hypot(x, y) < 0.28]
    assert np.median(off) < 1e-3 * 210.6
    assert np.percentile(off, 90) < 1e-2 * 210.6  # the rest lies in cells at the edges of stick zones


def test_closed_form_of_torsion(results: dict[str, Result]) -> None:
    result = results["torsion"]
    form = shear_form(result, 3)
    assert form is not None and form.name == "Lubkin"
    inside = np.abs(result.x) < 0.15
    exact = form.at(result.x[inside], np.zeros(inside.sum()))
    middle = len(result.y) // 2
    found = result.field("shear_y", 3)[inside, middle - 1 : middle + 1].mean(axis=1)
    np.testing.assert_allclose(exact[1], found, atol=0.02 * 210.6)
    assert shear_form(results["fretting"], 4) is None  # pressure and shear act on each other


def test_hertz_of_a_turned_tilted_ellipsoid(results: dict[str, Result]) -> None:
    result = results["hertz"]
    form = hertz_pressure(result, 1)
    assert form is not None
    x, y = np.meshgrid(result.x, result.y, indexing="ij")
    off = form.at(x.ravel(), y.ravel()).reshape(x.shape) - result.field("pressure")
    inside = result.field("pressure") > 500.0
    assert np.abs(off)[inside].max() < 0.03 * result.history["max_pressure"][1]
