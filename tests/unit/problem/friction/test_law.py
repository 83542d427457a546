"""The friction law of a case: its coefficient from place to place, with slip, and from stage to stage."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command_line import invoke
from line_cases import line_case
from pydantic import ValidationError
from small_cases import CASE, write_case
from solving import build, solve

from fretsolve import load_case, run
from fretsolve.errors import CaseError, FileError
from fretsolve.problem.friction.law import FrictionField, friction_law
from fretsolve.problem.friction.limit import FrictionOnGrid
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.surface.height_map import HeightMap
from fretsolve.result.state import Fields, broadcast_zeros
from fretsolve.simulation.problem_setup import set_up

GRID = Grid.from_size((20, 16), (1.0, 0.8))


def fields(path: float = 0.0, energy: float = 0.0) -> Fields:
    scalar, vector = broadcast_zeros(GRID.shape), broadcast_zeros((2, *GRID.shape))
    start = Fields(scalar, vector, vector, scalar, scalar, np.zeros(GRID.shape, np.uint8), scalar)
    return replace(start, slip_path=np.full(GRID.shape, path), work_density=np.full(GRID.shape, energy))


def law_of(**friction: object) -> FrictionOnGrid:
    law = friction_law(build(friction=friction, grid={"points": 16}))
    assert law is not None
    return law.on(GRID)


def test_formula_gives_means_over_cells():
    values = law_of(expression="0.1 + 0.2*(x < 0.01) + y**2").values
    assert values is not None
    # 0.2 where x < 0.01 mm, which is a fifth of the cell from 0 to 0.05 mm: seen by 2 of 8 points
    steps = values[:, 8] - values[0, 8]
    assert steps[:10] == pytest.approx(np.zeros(10))
    assert steps[10] == pytest.approx(0.2 * (2 / 8 - 1))
    assert values[0] == pytest.approx(0.3 + GRID.y**2 + GRID.dy**2 / 12.0, rel=1e-4)


@pytest.mark.parametrize("wrong", ["x", "1/(r > 2)", "sqrt(x)", "0.1 - 3*(r < 0.1)", "0.1 - 0.2*(abs(x) < 0.01)"])
def test_formula_must_be_a_coefficient_on_all_of_the_grid(wrong):
    with pytest.raises(CaseError, match=r"the coefficient is \S+ at x = .* a finite number >= 0 is needed") as caught:
        law_of(expression=wrong)
    assert caught.value.key == ("friction", "expression")


def test_friction_in_places_too_small_to_be_tried_counts():
    """Or the model would have no shear."""
    formula = {"expression": "0.3*(abs(x - 0.15) < 0.002)"}
    law = friction_law(build(friction=formula, grid={"points": 32}))
    assert law is not None
    assert law.largest > 0.0
    state = solve(friction=formula, grid={"points": 32}, load_path=[{"P": 400.0}, {"Qx": 0.5, "increments": 1}])[-1]
    assert state.summary.Qx == pytest.approx(0.5)
    nowhere = friction_law(build(friction={"expression": "0"}, grid={"points": 32}))
    assert nowhere is not None
    assert nowhere.largest == 0.0


def test_a_formula_of_a_line_contact_has_no_y():
    with pytest.raises(ValidationError, match="a line contact has no y; a formula of x or r"):
        line_case(friction={"expression": "0.1 + 0*y"}, grid={"points": 32})


def test_running_in_by_slip_and_by_energy():
    by_slip = law_of(initial=0.2, final=0.7, slip="5 mm")
    assert by_slip.limit(fields()).coefficient == pytest.approx(0.2)
    assert by_slip.limit(fields(path=5.0, energy=9.0)).coefficient == pytest.approx(0.7 - 0.5 * np.exp(-1.0))
    by_energy = law_of(initial=0.2, final=0.7, energy="1 mJ/mm^2")
    assert by_energy.limit(fields(path=5.0, energy=2.0)).coefficient == pytest.approx(0.7 - 0.5 * np.exp(-2.0))


def test_coefficient_of_cycles_is_constant_in_a_cycle_and_linear_between():
    stages = [{"Qx": 10.0}, {"Qx": -10.0}]
    path = [{"P": 400.0}, {"cycle": {"times": 3, "stages": stages}}, {"cycle": {"times": 2, "stages": stages[:1]}}]
    case = build(friction={"cycles": [[1, 0.2], [3, 0.4], [4, 0.1]]}, grid={"points": 16}, load_path=path)
    found = [dict(stage.targets)["friction"] for stage in case.stages()]
    assert found == pytest.approx([0.2, 0.2, 0.2, 0.3, 0.3, 0.4, 0.4, 0.1, 0.1])
    increments = set_up(case).load_path
    assert [increments.increment(step, ()).friction for step in increments.last_steps[:1]] == [0.2]


def test_a_map_about_its_middle_with_a_hole():
    values = np.array([[0.1, 0.2, 0.3], [0.2, 0.3, np.inf], [0.3, 0.4, 0.5]])
    field = FrictionField(None, HeightMap(values, (1.0, 1.0)), center=(5.0, -2.0))
    assert field.largest() == 0.5
    assert field.at(np.array([4.0, 5.0]), np.array([-3.0, -2.0])).tolist() == [[0.1, 0.2], [0.2, 0.3]]
    assert np.isinf(field.at(np.array([5.0, 9.0]), np.array([-1.0]))).all()


class TestMap:
    def case(self, folder: Path, values: np.ndarray, more: str = "") -> Path:
        np.save(folder / "mu.npy", values)
        return write_case(folder, CASE.replace("friction: 0.1", f"friction: {{map: mu.npy, spacing: 0.1 mm{more}}}"))

    def test_is_interpolated(self, tmp_path):
        x = np.linspace(-0.5, 0.5, 11)
        setup = set_up(load_case(self.case(tmp_path, np.tile(0.2 + 0.1 * x[:, None], (1, 11)))))
        assert setup.friction is not None
        assert setup.model.friction == pytest.approx(0.25)
        found = setup.friction.on(setup.grid).values
        assert found == pytest.approx(np.tile(0.2 + 0.1 * setup.grid.x[:, None], (1, setup.grid.ny)))

    def test_hole_in_the_contact_is_found_before_the_run(self, tmp_path):
        values = np.full((11, 11), 0.2)
        values[5, 6] = np.nan
        path = self.case(tmp_path, values)
        result = invoke("validate", path)
        assert result.exit_code == 2
        assert "the contact reaches places of which the map gives no coefficient" in result.output
        with pytest.raises(CaseError, match=r"as at x = \S+ mm, y = \S+ mm; take a map that covers the contact"):
            next(run(load_case(path)))

    def test_end_of_a_map_in_a_line_contact(self, tmp_path):
        np.savetxt(tmp_path / "mu.txt", np.full(30, 0.3))
        for spacing, covers in ((20e-3, True), (2e-3, False)):  # of a contact of 0.21 mm
            friction = {"map": str(tmp_path / "mu.txt"), "spacing": spacing}
            setup = set_up(line_case(friction=friction, grid={"points": 64}))
            if covers:
                assert setup.friction_on_grid() is not None
            else:
                with pytest.raises(CaseError, match="take a map that covers the contact"):
                    setup.friction_on_grid()

    def test_must_be_there(self, tmp_path):
        path = write_case(tmp_path, CASE.replace("friction: 0.1", "friction: {map: none.npy, spacing: 1 um}"))
        with pytest.raises(FileError, match=r"friction\.map: .*none.npy: the friction map .* No such file") as caught:
            set_up(load_case(path))
        assert str(caught.value).startswith(f"{path}:")


def test_fields_of_the_result():
    parts = {"grid": {"points": 24}, "output": {"fields": ["friction", "shear_bound"]}}
    case = build(friction={"expression": "0.1 + x**2", "shear_limit": 100.0}, **parts)
    (state,) = run(case)
    assert state.fields.friction is not None
    assert state.fields.shear_bound is not None
    assert state.fields.friction[0] == pytest.approx(0.1 + set_up(case).grid.x[0] ** 2, rel=1e-3)
    limit = np.minimum(state.fields.friction * state.fields.pressure, 100.0)
    assert state.fields.shear_bound == pytest.approx(limit)
    (constant,) = solve(friction=0.2, **parts)
    assert (constant.fields.friction == 0.2).all()
    assert constant.fields.shear_bound == pytest.approx(0.2 * constant.fields.pressure)
    (without,) = solve(friction=0.2, grid={"points": 24})
    assert (without.fields.friction, without.fields.shear_bound) == (None, None)
