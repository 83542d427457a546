from __future__ import annotations

import pytest
from solving import DISSIMILAR, NO_POISSON, SIMILAR, build

from fretsolve.problem.model.required_terms import Terms, derive_model

PRESS, PULL, TWIST = {"P": 400.0}, {"Qx": 20.0}, {"Mz": 2.0}
INCOMPRESSIBLE = ["rigid", {"young_modulus": 1.0, "poisson_ratio": 0.5}]


def model(*stages, **parts):
    return derive_model(build(grid={"points": 8}, load_path=list(stages) or [PRESS], **parts))


@pytest.mark.parametrize(
    ("parts", "stages", "coupling", "terms", "has_shear"),
    [
        ({}, [PRESS], "none", Terms(False, False, False), False),
        ({"friction": 0}, [PRESS, {"delta_x": 1e-3}], "none", Terms(False, False, False), False),
        ({}, [PRESS, PULL], "tangential", Terms(True, True, False), True),
        ({}, [PRESS, TWIST], "tangential", Terms(True, True, False), True),
        ({"bodies": DISSIMILAR}, [PRESS], "full", Terms(True, True, True), True),
        ({"bodies": DISSIMILAR}, [PRESS, PULL], "full", Terms(True, True, True), True),
        ({"bodies": DISSIMILAR, "friction": 0}, [PRESS], "full", Terms(False, False, True), False),
        ({"bodies": NO_POISSON}, [PRESS, PULL], "none", Terms(True, False, False), True),
        ({"bodies": INCOMPRESSIBLE}, [PRESS, PULL], "tangential", Terms(True, True, False), True),
        ({"coupling": "none"}, [PRESS, PULL], "none", Terms(True, False, False), True),
        ({"coupling": "full"}, [PRESS, PULL], "full", Terms(True, True, True), True),
        ({"bodies": DISSIMILAR, "coupling": "tangential"}, [PRESS, PULL], "tangential", Terms(True, True, False), True),
    ],
)
def test_the_least_model_that_the_case_requires(parts, stages, coupling, terms, has_shear):
    found = model(*stages, **parts)
    assert found.coupling == coupling
    assert found.terms == terms
    assert found.has_shear == has_shear


def test_friction_free_slip_is_only_computed_where_it_is_stored():
    stored = model(bodies=DISSIMILAR, friction=0, output={"fields": ["pressure", "slip_path"]})
    assert stored.terms.normal_tangential_coupling
    assert not model(bodies=DISSIMILAR, friction=0, output={"fields": ["pressure"]}).terms.normal_tangential_coupling


def test_rounding_does_not_make_bodies_dissimilar():
    bodies = ({"young_modulus": 200e3, "poisson_ratio": 0.1 + 0.2}, {"young_modulus": 200e3, "poisson_ratio": 0.3})
    assert model(PRESS, PULL, bodies=bodies).coupling == "tangential"


def test_decisions_give_their_reason():
    found = model(PRESS, TWIST, bodies=DISSIMILAR)
    assert len(found.decisions) == 5
    assert all(decision.kept and decision.reason for decision in found.decisions)
    reasons = {decision.part: decision.reason for decision in found.decisions}
    assert "Mz" in reasons["tangential problem"]
    assert "0.1938" in reasons["between pressure and shear"]
    pressed = {decision.part: decision for decision in model(bodies=DISSIMILAR).decisions}
    assert "pressing alone" in pressed["tangential problem"].reason


@pytest.mark.parametrize(
    ("parts", "stages", "may_slip"),
    [
        ({}, [PRESS], False),
        ({"friction": 0}, [PRESS, {"Qx": 0.0}], False),
        ({"friction": 0}, [PRESS, {"delta_x": 1e-3}], True),
        ({"friction": 0, "bodies": DISSIMILAR}, [PRESS], True),
        ({"friction": 0, "bodies": DISSIMILAR, "output": {"fields": []}}, [PRESS], False),
        ({"bodies": DISSIMILAR}, [PRESS], True),
        ({}, [PRESS, PULL], True),
    ],
)
def test_slip_is_kept_where_something_may_slip(parts, stages, may_slip):
    found = model(*stages, **parts)
    assert found.may_slip == may_slip
    kept = {decision.part: decision.kept for decision in found.decisions}
    assert kept["slip and dissipated energy"] == may_slip


class TestNegligibleCoupling:
    STEELS = ({"young_modulus": 206e3, "poisson_ratio": 0.3}, {"young_modulus": 210e3, "poisson_ratio": 0.3})
    """Dundurs' constant is 0.0027."""

    @pytest.mark.parametrize(
        ("tolerance", "friction", "kept"),
        [(1e-6, 0.3, True), (5e-2, 0.3, False), (5e-2, 0.2, True), (5e-2, 1.0, False), (5e-2, 5.0, True)],
    )
    def test_left_out_where_it_stays_below_the_tolerance(self, tolerance, friction, kept):
        found = model(PRESS, PULL, bodies=self.STEELS, friction=friction, solver={"tolerance": tolerance})
        assert found.terms.normal_tangential_coupling == kept
        reason = next(one.reason for one in found.decisions if one.part == "between pressure and shear")
        assert ("below solver.tolerance" in reason) != kept
        assert "0.002747" in reason


class TestWarnings:
    @pytest.mark.parametrize("stage", [TWIST, {"phi_z": 1e-3}])
    def test_none_for_torsion(self, stage):
        (warning,) = model(PRESS, stage, coupling="none").warnings
        assert warning == (
            "coupling: none leaves out ux from qy and uy from qx: under torsion the ratio phi_z/Mz is 7.5 % too small;"
            " coupling: auto keeps them"
        )
        assert model(PRESS, stage).terms.in_plane_coupling
        assert model(PRESS, stage).warnings == ()

    def test_none_for_a_force(self):
        (warning,) = model(PRESS, PULL, coupling="none").warnings
        assert warning == "coupling: none leaves out ux from qy and uy from qx; coupling: auto keeps them"

    @pytest.mark.parametrize("stages", [[PRESS], [PRESS, PULL]])
    def test_less_than_dissimilar_bodies_need(self, stages):
        (warning,) = model(*stages, bodies=DISSIMILAR, coupling="tangential").warnings
        assert warning == (
            "coupling: tangential leaves out what pressure and shear do to each other: with Dundurs' constant 0.1938"
            " and friction 0.1 a sphere under P alone sticks on 51 % of the contact radius (Spence), here on all of it;"
            " coupling: auto keeps it"
        )
        assert len(model(PRESS, TWIST, bodies=DISSIMILAR, coupling="none").warnings) == 2

    @pytest.mark.parametrize(
        "parts",
        [
            {},
            {"coupling": "full"},
            {"coupling": "tangential"},
            {"coupling": "none", "bodies": NO_POISSON},
            {"coupling": "none", "friction": 0},
            {"coupling": "tangential", "bodies": TestNegligibleCoupling.STEELS, "solver": {"tolerance": 0.2}},
        ],
    )
    def test_nothing_to_warn_of(self, parts):
        assert model(PRESS, PULL, **({"bodies": SIMILAR} | parts)).warnings == ()
