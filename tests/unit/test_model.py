from __future__ import annotations

import pytest
from solving import DISSIMILAR, SIMILAR, build

from fretsolve.model import Terms, derive_model

PRESS, PULL, TWIST = {"P": 400.0}, {"Qx": 20.0}, {"Mz": 2.0}
NO_POISSON = ({"young_modulus": 200e3, "poisson_ratio": 0.0},) * 2
INCOMPRESSIBLE = ["rigid", {"young_modulus": 1.0, "poisson_ratio": 0.5}]


def model(*stages, **parts):
    return derive_model(build(grid={"points": 8}, load_path=list(stages) or [PRESS], **parts))


@pytest.mark.parametrize(
    ("parts", "stages", "coupling", "terms", "sheared"),
    [
        ({}, [PRESS], "none", Terms(False, False, False), False),
        ({"friction": 0}, [PRESS, {"delta_x": 1e-3}], "none", Terms(False, False, False), False),
        ({}, [PRESS, PULL], "tangential", Terms(True, True, False), True),
        ({}, [PRESS, TWIST], "tangential", Terms(True, True, False), True),
        ({"bodies": DISSIMILAR}, [PRESS], "full", Terms(True, True, True), True),
        ({"bodies": DISSIMILAR}, [PRESS, PULL], "full", Terms(True, True, True), True),
        ({"bodies": DISSIMILAR, "friction": 0}, [PRESS], "full", Terms(True, True, True), False),
        ({"bodies": NO_POISSON}, [PRESS, PULL], "none", Terms(True, False, False), True),
        ({"bodies": INCOMPRESSIBLE}, [PRESS, PULL], "tangential", Terms(True, True, False), True),
        ({"coupling": "none"}, [PRESS, PULL], "none", Terms(True, False, False), True),
        ({"coupling": "full"}, [PRESS, PULL], "full", Terms(True, True, True), True),
        ({"bodies": DISSIMILAR, "coupling": "tangential"}, [PRESS, PULL], "tangential", Terms(True, True, False), True),
    ],
)
def test_the_least_model_that_the_case_requires(parts, stages, coupling, terms, sheared):
    found = model(*stages, **parts)
    assert found.coupling == coupling
    assert found.terms == terms
    assert found.sheared == sheared


def test_friction_free_slip_is_only_computed_where_it_is_stored():
    stored = model(bodies=DISSIMILAR, friction=0, output={"fields": ["pressure", "slip_path"]})
    assert stored.terms.coupled
    assert not model(bodies=DISSIMILAR, friction=0, output={"fields": ["pressure"]}).terms.coupled


def test_loads_of_nothing_need_no_shear():
    assert not model(PRESS, {"Qx": 0.0, "Mz": 0.0}).sheared


def test_rounding_of_equal_bodies_is_no_difference():
    bodies = ({"young_modulus": 200e3, "poisson_ratio": 0.1 + 0.2}, {"young_modulus": 200e3, "poisson_ratio": 0.3})
    assert model(PRESS, PULL, bodies=bodies).coupling == "tangential"


def test_decisions_are_reasoned():
    found = model(PRESS, TWIST, bodies=DISSIMILAR)
    assert len(found.decisions) == 4
    assert all(decision.kept and decision.reason for decision in found.decisions)
    reasons = {decision.part: decision.reason for decision in found.decisions}
    assert "Mz" in reasons["tangential problem"]
    assert "0.1938" in reasons["between pressure and shear"]
    pressed = {decision.part: decision for decision in model(bodies=DISSIMILAR).decisions}
    assert "pressing alone" in pressed["tangential problem"].reason


class TestWarnings:
    def test_none_for_torsion(self):
        """Said with the reason; `auto` keeps the cross influence."""
        (warning,) = model(PRESS, TWIST, coupling="none").warnings
        assert warning.startswith("coupling: none is wrong for torsion")
        assert "ux from qy" in warning
        assert model(PRESS, TWIST).terms.cross

    def test_none_for_a_force(self):
        (warning,) = model(PRESS, PULL, coupling="none").warnings
        assert "off the load's direction" in warning

    def test_less_than_dissimilar_bodies_need(self):
        assert "Dundurs' constant is 0.1938" in model(PRESS, PULL, bodies=DISSIMILAR, coupling="tangential").warnings[0]
        assert len(model(PRESS, TWIST, bodies=DISSIMILAR, coupling="none").warnings) == 2

    @pytest.mark.parametrize(
        "parts",
        [
            {},
            {"coupling": "full"},
            {"coupling": "tangential"},
            {"coupling": "none", "bodies": NO_POISSON},
            {"coupling": "none", "friction": 0},
        ],
    )
    def test_nothing_to_warn_of(self, parts):
        assert model(PRESS, PULL, **({"bodies": SIMILAR} | parts)).warnings == ()
