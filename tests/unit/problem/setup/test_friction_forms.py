"""Which closed forms hold where friction varies."""

from __future__ import annotations

import math
import re

import pytest
from command_line import invoke
from line_cases import line_case
from small_cases import CASE, write_case
from solving import HERTZ, NO_POISSON, SIMILAR, build

from fretsolve.problem.setup.warnings import case_warnings
from fretsolve.simulation.problem_setup import set_up

LINE_CAP = {"coefficient": 0.3, "shear_limit": 50.0}
PULLED = [{"P": 400.0}, {"Qx": 15.0, "increments": 1}]


def forms_of(friction, path=PULLED, **parts):
    return set_up(build(friction=friction, grid={"points": 16}, load_path=path, **parts)).closed_forms


def test_gross_slip_of_a_strip():
    forms = forms_of({"expression": "0.1 + 0.2*(abs(y) < 0.1)"})
    t = 0.1 / HERTZ.contact_radius
    force, torque, delta_x = forms.gross_slip(400.0, forms.hertz[0])
    assert force == pytest.approx(40.0 + 80.0 * 1.5 * (t - t**3 / 3.0), rel=1e-2)
    assert (torque, delta_x) == (float("inf"), None)
    assert forms.tangential(1) is None


def test_gross_slip_on_an_ellipse_with_a_shear_limit():
    """(3t - t^3)/2 of mu P with t the limit over mu p0, whatever the ratio of the axes."""
    surface = {"ellipsoid": {"radius_x": 10.0, "radius_y": 30.0, "angle": 0.4}}
    forms = forms_of({"coefficient": 0.1, "shear_limit": 60.0}, surface=surface)
    hertz = forms.hertz[0]
    t = 60.0 / (0.1 * hertz.max_pressure)
    assert forms.gross_slip(400.0, hertz)[0] == pytest.approx(40.0 * (3.0 * t - t**3) / 2.0, rel=1e-5)


@pytest.mark.parametrize(
    ("friction", "path"),
    [
        ({"expression": "0.1 + 0.2*((x - 0.1)**2 + y**2 < 0.01)"}, PULLED),
        ({"expression": "0.1 - 0.08*(r < 0.1)"}, PULLED),
        ({"coefficient": [0.2, 0.1]}, PULLED),
        ({"initial": 0.1, "final": 0.3, "slip": 1.0}, PULLED),
        ({"cycles": [[1, 0.1], [5, 0.2]]}, PULLED),
        (0.1, [*PULLED, {"friction": 0.2}]),
    ],
    ids=["beside the middle", "from the middle", "axes", "running in", "cycles", "stage"],
)
def test_partial_slip_is_refused(friction, path):
    forms = forms_of(friction, path)
    assert forms.tangential(1) is None
    assert forms.smallest_stick is None
    assert {form.source for form in forms.values()} == {"Hertz"}


def test_a_round_formula_about_the_contact_has_one():
    surface = {"sphere": {"radius": 10.0, "center": [0.1, 0.0]}}
    parts = {"surface": surface, "coupling": "none"}
    there = forms_of({"expression": "0.1 + 0.2*((x - 0.1)**2 + y**2 < 0.01)"}, **parts).tangential(1)
    here = forms_of({"expression": "0.1 + 0.2*(r < 0.1)"}, coupling="none").tangential(1)
    assert there is not None
    assert here is not None
    assert there.stick_radius == pytest.approx(here.stick_radius, rel=1e-6)
    assert forms_of({"expression": "0.1 + 0.2*(r < 0.1)"}, **parts).tangential(1) is None


@pytest.mark.parametrize(
    ("friction", "lines"),
    [
        (
            "{coefficient: 0.1, shear_limit: 100 MPa}",
            ["gross slip begins at Q = sum of the friction limit = 26.3437 N or at Mz = 5.0958", "(slip from the rim)"],
        ),
        ("{expression: '0.1 + y**2'}", ["no closed form holds for partial slip under this friction"]),
        ("{coefficient: [0.2, 0.1]}", ["gross slip begins at Q = 80 N along the first axis, 40 N along the second"]),
    ],
)
def test_validate_prints_them(tmp_path, friction, lines):
    path = write_case(tmp_path, CASE.replace("friction: 0.1", f"friction: {friction}"))
    told = invoke("validate", path).output
    assert all(line in told for line in lines), told


def test_a_stage_that_lowers_friction_too_far_is_warned_of():
    path = [{"P": 400.0}, {"Qx": 36.0}, {"friction": 0.08}]
    setup = set_up(build(friction=0.2, grid={"points": 64}, load_path=path))
    (warning,) = (text for text in case_warnings(setup) if "gross slip" in text)
    assert warning.startswith("stage.3: 36 N is not below the 32 N (sum of the friction limit) that friction carries")
    held = set_up(build(friction=0.2, grid={"points": 64}, load_path=[*path[:2], {"friction": 0.1}]))
    assert not [text for text in case_warnings(held) if "gross slip" in text]


@pytest.mark.parametrize(
    ("formula", "told"), [("0.1 mm/r", True), ("min(0.1 mm/r, 1)", False), ("0.1*sin(r)/r", False)]
)
def test_a_formula_without_a_bound_is_warned_of(formula, told):
    setup = set_up(build(friction={"expression": formula}, grid={"points": 64}, load_path=[{"P": 400.0}, {"Qx": 3.0}]))
    texts = [text for text in case_warnings(setup) if text.startswith("friction.expression: the coefficient is inf")]
    assert len(texts) == told


@pytest.mark.parametrize(
    ("friction", "loads", "most"),
    [
        # along 45 deg (0.178885, 0.044721) P of both axes: the force has another direction than the slip
        ({"coefficient": [0.2, 0.1]}, {"Qx": 72.0, "Qy": 18.0}, 400.0 * math.hypot(0.178885, 0.044721)),
        ({"coefficient": [0.1, 0.2], "angle": "90 deg"}, {"Qx": 81.0}, 80.0),
        ({"initial": 0.1, "final": 0.3, "slip": 1.0}, {"Qx": 121.0}, 120.0),
    ],
)
def test_a_force_beyond_is_warned_of_without_a_closed_form(friction, loads, most):
    def warnings(factor):
        stage = {name: factor * value for name, value in loads.items()}
        case = build(friction=friction, grid={"points": 64}, load_path=[{"P": 400.0}, stage])
        return [text for text in case_warnings(set_up(case)) if "gross slip" in text]

    (warning,) = warnings(1.0)
    found = re.search(r"not below the (\S+) N \(sum of the friction limit\)", warning)
    assert found is not None
    assert float(found[1]) == pytest.approx(most, rel=1e-4)
    assert warnings(0.98) == []


def test_validate_names_the_friction_of_stages(tmp_path):
    path = write_case(tmp_path, CASE.replace("{Qx: 20 N, increments: 4}", "{friction: 0.05}"))
    assert "stage 2: friction -> 0.05 in 1 increment (auto)\n" in invoke("validate", path).output


class TestUnderBulkStress:
    """Hills and Nowell's, and the shifted Cattaneo-Mindlin, hold for one coefficient alone."""

    def test_line(self):
        path = [{"P": 100.0}, {"Qx": 5.0, "bulk_2": {"xx": 20.0}}]
        of_one, of_cap = (
            set_up(line_case(friction=mu, bodies=SIMILAR, grid={"points": 32}, load_path=path)).closed_forms
            for mu in (0.3, LINE_CAP)
        )
        assert of_one.shaken_down is not None
        assert (of_cap.shaken_down, of_cap.smallest_stick) == (None, None)

    def test_sphere(self):
        path = [{"P": 400.0}, {"Qx": 24.0, "bulk_2": {"xx": 20.0, "yy": 0.0}}]
        parts = {"coupling": "none", "bodies": NO_POISSON}
        assert forms_of(0.1, path, **parts).smallest_stick is not None
        forms = forms_of({"coefficient": 0.1, "shear_limit": 150.0}, path, **parts)
        assert forms.smallest_stick is None
        assert {form.source for form in forms.values()} == {"Hertz"}


class TestLineContact:
    def test_gross_slip_under_a_shear_limit(self):
        """With t the limit over mu p0, int min(mu p, limit) dx = mu P (2/pi) (asin t + t sqrt(1 - t^2))."""
        forms = set_up(
            line_case(friction=LINE_CAP, bodies=SIMILAR, grid={"points": 32}, load_path=[{"P": 100.0}])
        ).closed_forms
        t = 50.0 / (0.3 * forms.widest.max_pressure)
        expected = 30.0 * 2.0 / math.pi * (math.asin(t) + t * math.sqrt(1.0 - t**2))
        assert forms.gross_slip(100.0) == (pytest.approx(expected, rel=1e-6), math.inf, None)

    def test_it_is_warned_of(self):
        path = [{"P": 100.0}, {"Qx": 15.0, "increments": 2}]
        friction = {"expression": "0.1"}
        setup = set_up(line_case(friction=friction, bodies=SIMILAR, grid={"points": 64}, load_path=path))
        (warning,) = (text for text in case_warnings(setup) if "gross slip" in text)
        assert warning.startswith(
            "stage.2.Qx: 15 N/mm is not below the 10 N/mm (sum of the friction limit) that friction carries"
        )
