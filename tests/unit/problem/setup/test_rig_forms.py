"""What closed forms know of a contact on a rig; the certified values are of the base case on 50 kN/mm."""

from __future__ import annotations

import math

import numpy as np
import pytest
from solving import DISSIMILAR, HERTZ, A, build

from fretsolve.cli.rig_summary import rig_lines
from fretsolve.problem.setup.warnings import case_warnings
from fretsolve.simulation.problem_setup import set_up

P = {"P": 400.0}
RIG = {"stiffness_x": 50e3}


def setup_of(*stages, rig=RIG, **parts):
    return set_up(build(rig=rig, load_path=list(stages), **{"coupling": "none", "grid": {"points": 32}, **parts}))


def states_of(*stages, **parts):
    return setup_of(*stages, **parts).on_rig.driven[1]


def warned(*stages, **parts):
    return case_warnings(setup_of(*stages, **parts))


def test_certified_values_of_the_base_case():
    setup = setup_of(P, {"Qx": 36.0}, {"actuator_x": 1.2e-3})
    _, given, sticking = setup.on_rig.reversal
    assert 1.0 / (given + sticking) == pytest.approx(26076.33, abs=0.005)
    assert 1.0 / sticking == pytest.approx(54499.01, abs=0.005)
    assert setup.on_rig.gross_slip[1] == pytest.approx(1.900937e-3, abs=5e-10)
    assert setup.on_rig.driven[1][1].actuator == pytest.approx(1.583748e-3, abs=5e-10)
    loaded = states_of(P, {"actuator_x": 1.2e-3})[1]
    assert loaded.force == pytest.approx(28.68037, abs=5e-6)
    assert loaded.actuator == pytest.approx(loaded.motion + loaded.force / 50e3, rel=1e-12)


def test_reversals_and_gross_slip():
    """The sliding contact follows the actuator less mu P/k, and forgets what was before."""
    path = [{"actuator_x": value} for value in (1.2e-3, -0.3e-3, 3e-3, 0.0, -3e-3, 0.0)]
    found = states_of(P, *path)
    assert [state.slides for state in found.values()] == [False, False, False, True, False, True, False]
    assert found[3].force == pytest.approx(40.0, rel=1e-12)
    assert found[3].motion == pytest.approx(2.2e-3, rel=1e-12)
    assert found[4].force == pytest.approx(-29.084642, abs=1e-6)
    assert found[6].force == pytest.approx(29.084642, abs=1e-6)
    # the first loading goes on where the loop closes
    again = states_of(P, {"actuator_x": 1.5e-3})
    assert states_of(P, *path[:2], {"actuator_x": 1.5e-3})[3].force == pytest.approx(again[1].force, rel=1e-9)


def test_forces_take_the_place_of_the_actuator_for_all_that_follows():
    by_force = setup_of(P, {"Qx": 28.68037456670942}, {"Qx": -28.68037456670942})
    by_rig = setup_of(P, {"actuator_x": 1.2e-3}, {"actuator_x": -1.2e-3})
    assert by_rig.closed_forms.smallest_stick.value == pytest.approx(0.1976871, abs=1e-7)
    exact = {(one.quantity, one.stage): one.value for one in by_force.closed_forms.values()}
    found = {(one.quantity, one.stage): one.value for one in by_rig.closed_forms.values()}
    assert found.keys() == exact.keys()
    assert ("delta_x", 1) in exact and ("work_total", 2) in exact
    assert list(found.values()) == pytest.approx(list(exact.values()), rel=1e-6)


def test_exact_values_of_the_driven_contact():
    found = {(one.quantity, one.stage): one.value for one in setup_of(P, {"actuator_x": 1.2e-3}).on_rig.values()}
    assert found == {
        ("Qx", 1): pytest.approx(28.68037, abs=5e-6),
        ("delta_x", 1): pytest.approx(0.6263925e-3, abs=5e-11),
        ("actuator_x", 1): pytest.approx(1.2e-3, rel=1e-12),
    }
    # slip across the load, which Mindlin neglects
    assert not list(setup_of(P, {"actuator_x": 1.2e-3}, coupling="auto").on_rig.values())


@pytest.mark.parametrize(
    ("surface", "load", "approach"),
    [
        ({"sphere": {"radius": 10.0}}, 400.0, HERTZ.delta_z),
        ({"sphere": {"radius": 10.0, "center": [0.3, 0.1]}}, 400.0, HERTZ.delta_z),
        ({"punch": {"radius": 0.3}}, 400.0, 400.0 / (0.6 * 1e5 / 0.91)),
        # P = (2/pi) E* delta_z^2/tan(angle)
        ({"cone": {"angle": 0.02}}, 400.0, math.sqrt(0.5 * math.pi * 400.0 * math.tan(0.02) / (1e5 / 0.91))),
    ],
)
def test_the_normal_load_at_the_actuator(surface, load, approach):
    setup = setup_of({"actuator_z": approach + load / 2e5}, rig={"stiffness_z": 2e5}, surface=surface)
    assert setup.closed_forms.loads[0]["P"] == pytest.approx(load, rel=1e-9)
    stated = next(line for line in rig_lines(setup) if line.startswith("stage 1"))
    assert stated.startswith("stage 1 ends at P = 400 N, delta_z = ")


def test_an_ellipsoid_and_a_lifted_body():
    slim = {"ellipsoid": {"radius_x": 10.0, "radius_y": 25.0}}
    exact = setup_of(P, surface=slim, rig={"stiffness_z": 2e5}).closed_forms.largest
    setup = setup_of(
        {"actuator_z": exact.delta_z + 2e-3}, {"actuator_z": -1e-3}, surface=slim, rig={"stiffness_z": 2e5}
    )
    assert setup.closed_forms.largest.load == pytest.approx(400.0, rel=1e-9)
    assert setup.closed_forms.loads[1]["delta_z"] == -1e-3
    assert "P" not in setup.closed_forms.loads[1]


def test_increments_are_graded_as_the_contact_moves():
    """By Hertz the radius grows like a^2/R + C P; a soft rig presses like a force, a stiff one like an approach."""
    parts = {"bodies": DISSIMILAR, "coupling": "auto"}
    shares = {}
    for name, stiffness in (("soft", 1e2), ("stiff", 1e9)):
        motion = HERTZ.delta_z + 400.0 / stiffness
        path = setup_of({"actuator_z": motion}, rig={"stiffness_z": stiffness}, **parts).load_path
        shares[name] = next(path.imposed_in_stages())[2]
    for name, stage in (("soft", P), ("stiff", {"delta_z": HERTZ.delta_z})):
        path = setup_of(stage, rig={"stiffness_y": 1e5}, **parts).load_path
        exact = next(path.imposed_in_stages())[2]
        assert np.interp(np.linspace(0, 1, 9), np.linspace(0, 1, len(exact)), exact) == pytest.approx(
            np.interp(np.linspace(0, 1, 9), np.linspace(0, 1, len(shares[name])), shares[name]), abs=0.02
        )


@pytest.mark.parametrize(
    ("stages", "parts"),
    [
        ([P, {"actuator_x": 1e-3}], {"bodies": DISSIMILAR, "coupling": "auto"}),
        ([P, {"actuator_x": 1e-3}], {"surface": {"punch": {"radius": 0.3}}}),
        ([P, {"actuator_x": 1e-3, "Qy": 10.0}], {}),
        ([{**P, "phi_x": 1e-3}, {"actuator_x": 1e-3}], {}),
        ([P, {"actuator_x": 1e-3}], {"friction": {"initial": 0.1, "final": 0.3, "slip": 1.0}}),
        ([{**P, "actuator_x": 1e-3}], {}),
        ([P, {"actuator_x": 1e-3}], {"friction": 0.0}),
        ([P, {"actuator_x": 1e-3}], {"interface": {"shear_compliance": 2e-5}}),
        ([{"actuator_z": 0.01}], {"interface": {"normal_compliance": 2e-5}, "rig": {"stiffness_z": 2e5}}),
        ([{"actuator_z": 0.01}], {"surface": [{"sphere": {"radius": 9.0}}, {"cone": {"angle": 0.01}}]}),
    ],
)
def test_no_closed_form_is_claimed(stages, parts):
    setup = setup_of(*stages, **parts)
    assert setup.on_rig.driven is None
    assert setup.closed_forms.loads == setup.load_path.imposed


def test_a_change_of_the_load_ends_what_is_known():
    setup = setup_of(P, {"actuator_x": 1e-3}, {"P": 500.0, "actuator_x": 1.2e-3})
    assert sorted(setup.on_rig.driven[1]) == [0, 1]
    assert "actuator_x" in setup.closed_forms.loads[2]


def test_what_validate_prints():
    setup = setup_of(P, {"actuator_x": 1.2e-3}, {"cycle": {"amplitude": {"actuator_x": 3e-3}, "times": 2}})
    assert list(rig_lines(setup)) == [
        "\n# rig in series with the contact",
        "just after a reversal Qx changes by 26076.33 N/mm over actuator_x, by 54499.01 N/mm over delta_x; the rig"
        " takes 52.2 % of actuator_x",
        "gross slip begins at actuator_x = 1.900937 um, delta_x = 1.100937 um",
        "stage 2 ends at Qx = 28.68037 N, delta_x = 0.6263925 um, actuator_x = 1.2 um",
        "stage 3 ends at Qx = 40 N, delta_x = 2.2 um, actuator_x = 3 um, gross slip",
        "stage 4 ends at Qx = -40 N, delta_x = -2.2 um, actuator_x = -3 um, gross slip",
    ]
    assert list(rig_lines(setup_of({**P, "phi_x": 1e-4}, {"Qx": 1.0}, {"Qy": 1.0})))[1:] == [
        "no closed form tells how contact and rig share the actuator's motion"
    ]


def test_unlike_bodies_stick_about_as_stiffly():
    """A solve on 64 x 64 points gives 56 327 N/mm over delta_x."""
    setup = setup_of(P, {"actuator_x": 1e-3}, bodies=DISSIMILAR, coupling="auto")
    assert list(rig_lines(setup))[1:] == [
        "just after a reversal Qx changes by about 26400 N/mm over actuator_x, by about 56000 N/mm over delta_x;"
        " the rig takes 52.8 % of actuator_x"
    ]


def test_a_force_off_the_origin_turns_a_rig():
    off = {"sphere": {"radius": 10.0, "center": [0.0, 0.1]}}
    for rig, known in ((RIG, True), ({**RIG, "stiffness_phi_z": 5e6}, False)):
        setup = setup_of(P, {"actuator_x": 1e-3}, surface=off, rig=rig)
        assert (setup.on_rig.driven is not None) == known


def test_torsion_on_a_rig():
    setup = setup_of(P, {"actuator_phi_z": 2e-3}, rig={"stiffness_phi_z": 5e3}, coupling="auto")
    names, _given, sticking = setup.on_rig.reversal
    assert names == ("Mz", "phi_z", "actuator_phi_z")
    # a circle that turns without slip: Mz = 16/3 G a^3 phi_z on each body
    assert 1.0 / sticking == pytest.approx(16.0 / 3.0 * (200e3 / 2.6) * A**3 / 2.0, rel=1e-9)
    state = setup.on_rig.driven[1][1]
    assert state.motion + state.force / 5e3 == pytest.approx(2e-3, rel=1e-9)


class TestWarnings:
    @pytest.mark.parametrize(
        "keys",
        [
            {"surface": {"ellipsoid": {"radius_x": 10.0, "radius_y": 20.0}}},
            {"surface": [{"sphere": {"radius": 10.0}}, {"sphere": {"radius": 30.0}}]},
            {"interface": {"normal_compliance": 1e-6}},
        ],
        ids=["ellipse", "two surfaces", "layer"],
    )
    def test_a_soft_rig_without_a_closed_form(self, keys):
        texts = [one for one in warned(P, {"actuator_x": 0.01}, rig={"stiffness_x": 1e3}, **keys) if "rig" in one]
        assert [text.partition(" while")[0] for text in texts] == [
            "rig.stiffness_x: with 1000 N/mm the rig takes about 98 % of actuator_x"
        ]

    def test_an_approach_through_a_soft_rig(self):
        (text,) = (one for one in warned({"actuator_z": 1.0}, rig={"stiffness_z": 300.0}) if "rig" in one)
        assert text.startswith("rig.stiffness_z: with 300 N/mm the rig takes nearly all of actuator_z")

    def test_a_layer_and_a_rig_in_series(self):
        """Full stick and onset of gross slip by the layered contact, to which 1/k adds."""
        bodies = [{"young_modulus": 200e3, "poisson_ratio": 0.0}] * 2
        a = (0.75 * 400.0 * 10.0 / 100e3) ** (1.0 / 3.0)
        layer = {"shear_compliance": a / 100e3}  # L E'/a = 1
        setup = setup_of(P, {"actuator_x": 1e-3}, bodies=bodies, interface=layer, rig={"stiffness_x": 5e4})
        motion, actuator = setup.on_rig.gross_slip
        unit = 0.1 * 600.0 / (np.pi * a**2) * a / 100e3
        assert motion == pytest.approx((0.5 * np.pi + 1.0) * unit, rel=1e-9)
        assert actuator == pytest.approx(motion + 40.0 / 5e4)
        _, given, sticking = setup.on_rig.reversal
        bare = setup_of(P, {"actuator_x": 1e-3}, bodies=bodies, rig={"stiffness_x": 5e4}).on_rig.reversal[2]
        assert given == 2e-5
        # no stiffer than bodies and a uniform layer in series, no softer than under a uniform traction
        assert bare + layer["shear_compliance"] / (np.pi * a**2) < sticking
        assert sticking < bare * 32.0 / (3.0 * np.pi**2) + layer["shear_compliance"] / (np.pi * a**2)

    def test_a_soft_rig(self):
        """k = 1 kN/mm: 1e-3/(1e-3 + 1.834896e-5)."""
        (text,) = (one for one in warned(P, {"actuator_x": 0.01}, rig={"stiffness_x": 1e3}) if "rig" in one)
        assert text == (
            "rig.stiffness_x: with 1000 N/mm the rig takes 98.2 % of actuator_x while the contact sticks, so that the"
            " loop at the actuator tells little about the contact; check the unit, look at the loop over delta_x, or"
            " take a stiffer rig"
        )
        for k, soft in ((6.1e3, False), (6.0e3, True)):  # at 54499/9 N/mm
            texts = warned(P, {"actuator_x": 0.01}, rig={"stiffness_x": k})
            assert any(one.startswith("rig.stiffness_x") for one in texts) == soft

    def test_gross_slip_under_a_force_is_followed_by_the_actuator(self):
        (text,) = (one for one in warned(P, {"Qx": 45.0}) if "gross slip" in one)
        assert text.endswith("impose actuator_x to follow it")
        (text,) = (one for one in warned(P, {"Qx": 45.0}, rig={"stiffness_z": 1e5}) if "gross slip" in one)
        assert text.endswith("impose delta_x to follow it")
        assert not [one for one in warned(P, {"actuator_x": 0.01}) if "gross slip" in one]

    def test_large_motions(self):
        (text,) = (one for one in warned(P, {"actuator_x": 0.05}) if "contact radii" in one)
        assert text.startswith("load_path: actuator_x may move the surfaces by 0.16 contact radii")  # less mu P/k
        assert not [one for one in warned(P, {"actuator_x": 0.05}, rig={"stiffness_x": 8e2}) if "contact radii" in one]

    def test_friction_that_falls_faster_than_the_rig_unloads(self):
        """0.2 of P over 0.06 mm against 1 kN/mm."""
        parts = {"friction": {"initial": 0.3, "final": 0.1, "slip": 0.06}}
        (text,) = (one for one in warned(P, {"actuator_x": 0.14}, rig={"stiffness_x": 1e3}, **parts) if "falls" in one)
        assert text == (
            "rig.stiffness_x: once the contact slides as a whole, friction falls 1.33 times as fast with slip as the"
            " rig unloads, which ends the run; a stiffer rig, or delta_x imposed on the contact itself, follows it"
        )
        for motion, stiffness in ((0.11, 1e3), (0.14, 1.4e3)):  # before gross slip; a stiffer rig
            texts = warned(P, {"actuator_x": motion}, rig={"stiffness_x": stiffness}, **parts)
            assert not [one for one in texts if "falls" in one]
