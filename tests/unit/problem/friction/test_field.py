"""A coefficient of friction over the contact: formulas and maps, by themselves; and warnings of friction."""

from __future__ import annotations

import math

import numpy as np
import pytest
from solving import HERTZ
from solving import build as built

from fretsolve.case.expression import Expression
from fretsolve.case.keys.friction_spec import FrictionSpec
from fretsolve.case.models import Case
from fretsolve.errors import FileError
from fretsolve.problem.friction.law import LARGEST_ESTIMATE, FrictionField, friction_field
from fretsolve.problem.friction.limit import friction_warnings, largest_share
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.model.height_map import HeightMap

GRID = Grid(4, 3, 0.1, 0.2, 0.05, -0.3)


def build(**parts: object) -> Case:
    return built(grid={"points": 4}, **parts)


def spec_of(**friction: object) -> FrictionSpec:
    return build(friction=friction).friction


def test_a_linear_formula_is_its_value_at_the_middle_of_a_cell():
    field = FrictionField(Expression("0.3 + 0.2*x - 0.1*y"))
    expected = 0.3 + 0.2 * GRID.x[:, None] - 0.1 * GRID.y
    np.testing.assert_allclose(field.on(GRID), expected, rtol=1e-12)
    np.testing.assert_allclose(field.at(GRID.x, GRID.y), expected, rtol=1e-12)


def test_a_quadratic_formula_is_averaged():
    """The mean of x^2 over n points in a cell is that of its middle plus (1 - 1/n^2) dx^2/12."""
    found = FrictionField(Expression("x**2")).on(GRID)
    np.testing.assert_allclose(found, (GRID.x**2 + (1.0 - 1.0 / 64.0) * 0.01 / 12.0)[:, None] * np.ones(3))


def test_a_negative_value_anywhere_in_a_cell_shows():
    found = FrictionField(Expression("x")).on(Grid(2, 1, 0.2, 0.2, 0.05))
    assert found[0, 0] < 0.0
    assert found[1, 0] == pytest.approx(0.15)


def test_the_largest_value():
    assert FrictionField(Expression("0.3 + 0.2*exp(-r**2)")).largest() == pytest.approx(0.5)
    assert FrictionField(Expression("1/r")).largest() == LARGEST_ESTIMATE
    assert FrictionField(Expression("0")).largest() == 0.0


def test_a_map_about_its_middle_with_a_hole():
    values = np.array([[0.1, 0.2, 0.3], [0.2, 0.3, np.inf], [0.3, 0.4, 0.5]])
    field = FrictionField(None, HeightMap(values, (1.0, 1.0)), center=(5.0, -2.0))
    assert field.largest() == 0.5
    assert field.at(np.array([4.0, 5.0]), np.array([-3.0, -2.0])).tolist() == [[0.1, 0.2], [0.2, 0.3]]
    assert np.isinf(field.at(np.array([5.0, 9.0]), np.array([-1.0]))).all()


def test_a_map_that_is_not_there_is_named_as_one_of_friction(tmp_path):
    with pytest.raises(FileError, match=r"friction map") as caught:
        friction_field(build(friction={"map": str(tmp_path / "none.npy"), "spacing": 0.1}))
    assert str(caught.value.file).endswith("none.npy")


def test_only_formulas_and_maps_vary_over_the_contact():
    assert friction_field(build(friction=0.3)) is None
    field = friction_field(build(friction={"expression": "0.3 + 0.1*x"}))
    assert field is not None
    assert field.at(np.ones(1), np.zeros(1))[0, 0] == pytest.approx(0.4)


def test_what_two_coefficients_carry_along_a_direction():
    """The ellipse (q1/mu1)^2 + (q2/mu2)^2 = p^2."""
    spec = spec_of(coefficient=[0.2, 0.5], angle="30 deg")
    for angle in np.radians([0.0, 30.0, 75.0, 120.0]):
        first, second = math.cos(angle - math.radians(30.0)), math.sin(angle - math.radians(30.0))
        most = 1.0 / math.hypot(first / 0.2, second / 0.5)
        assert largest_share(spec, 9.0 * math.cos(angle), 9.0 * math.sin(angle)) == pytest.approx(most)
    assert largest_share(spec, 0.0, 0.0) == math.inf
    assert largest_share(spec_of(coefficient=0.3), 1.0, 0.0) == math.inf


def test_a_cycle_that_is_periodic_before_friction_has_run_in():
    running_in = {"initial": 0.2, "final": 0.6, "slip": "1 mm"}
    cycle = {"until": "periodic", "stages": [{"Qx": -20.0}, {"Qx": 20.0}]}
    case = build(friction=running_in, load_path=[{"P": 400.0}, {"Qx": 20.0}, {"cycle": cycle}])
    (found,) = friction_warnings(case.friction, case.stages(), HERTZ, 1e-5)
    assert found.startswith(
        "load_path.2.cycle.until: friction changes from cycle to cycle, and one that changes by less"
    )
    assert list(friction_warnings(spec_of(coefficient=0.3), case.stages(), HERTZ, 1e-5)) == []
