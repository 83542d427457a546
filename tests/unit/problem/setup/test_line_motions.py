"""What closed forms know of a line contact that points at a reference depth drive, with a rig and without one."""

from __future__ import annotations

import pytest
from line_cases import DISSIMILAR, line_case

from fretsolve.cli.case_summary import wear_lines
from fretsolve.cli.rig_summary import rig_lines
from fretsolve.problem.setup.warnings import case_warnings
from fretsolve.problem.setup.wear_forms import worn_cycles
from fretsolve.simulation.problem_setup import set_up

STEEL = {"young_modulus": 210e3, "poisson_ratio": 0.3}
PRESSED = {"P": 100.0}
ONSET = 1.7830410e-3


def setup_of(*stages, **keys):
    """The certified pair: 10 mm, mu P = 50 N/mm, points 10 mm deep."""
    parts = {"bodies": [STEEL, STEEL], "friction": 0.5, "reference_depth": 10.0, "grid": {"points": 64}}
    return set_up(line_case(**{**parts, "load_path": [PRESSED, *stages], **keys}))


def test_certified_values():
    exact = {(one.quantity, one.stage): one.value for one in setup_of({"Qx": 10.0}, {"Qx": 45.0}).on_rig.values()}
    assert exact["delta_x", 1] == pytest.approx(0.3319849e-3, rel=1e-6)
    assert exact["delta_x", 2] == pytest.approx(1.5729763e-3, rel=1e-6)
    by_motion = setup_of({"delta_x": 0.8437161e-3}, {"delta_x": -0.8437161e-3})
    assert by_motion.on_rig.gross_slip[0] == pytest.approx(ONSET, rel=1e-7)
    states = by_motion.on_rig.driven[1]
    assert [states[stage].force for stage in (1, 2)] == pytest.approx([25.0, -25.0], rel=1e-6)


def test_forces_take_the_place_of_motions_for_all_that_follows():
    by_force = setup_of({"Qx": 25.0}, {"Qx": -25.0})
    by_motion = setup_of({"delta_x": 0.8437161e-3}, {"delta_x": -0.8437161e-3})
    assert by_motion.closed_forms.smallest_stick.value == pytest.approx(0.5**0.5 * 0.1050456, rel=1e-5)
    exact, found = (
        {(one.quantity, one.stage): one.value for one in one.closed_forms.values()} for one in (by_force, by_motion)
    )
    assert found.keys() == exact.keys() and ("work_total", 2) in exact
    assert list(found.values()) == pytest.approx(list(exact.values()), rel=1e-6)


def test_increments_are_graded_and_counted_as_under_the_force():
    parts = {"solver": {"accuracy": "1 %"}}
    by_force, by_motion = (
        setup_of({"Qx": 25.0, "spacing": "graded", "increments": 12}, **parts),
        setup_of({"delta_x": 0.8437161e-3, "spacing": "graded", "increments": 12}, **parts),
    )
    forces, motions = (list(one.load_path.imposed_in_stages())[1][2] for one in (by_force, by_motion))
    # as the contact gives way more and more, the motion is behind the force
    assert all(motion < force for motion, force in zip(motions[:-1], forces[:-1], strict=True))
    assert not setup_of({"delta_x": 5e-3}).load_path.graded[1]


def test_what_validate_prints():
    assert list(rig_lines(setup_of({"delta_x": 0.8437161e-3}, {"delta_x": 5e-3}))) == [
        "\n# motion of points 10 mm deep in both bodies",
        "just after a reversal Qx changes by 30393.17 N/mm^2 over delta_x",
        "gross slip begins at delta_x = 1.783041 um",
        "stage 2 ends at Qx = 25 N/mm, delta_x = 0.8437161 um",
        "stage 3 ends at Qx = 50 N/mm, delta_x = 5 um, gross slip",
    ]
    # actuator: 1.783041 um + 50/20 um; 1/(1/30393.17 + 1/20000)
    assert list(rig_lines(setup_of({"actuator_x": 8e-3}, rig={"stiffness_x": 20e3}))) == [
        "\n# rig in series with the contact",
        "just after a reversal Qx changes by 12062.42 N/mm^2 over actuator_x, by 30393.17 N/mm^2 over delta_x; the rig"
        " takes 60.3 % of actuator_x",
        "gross slip begins at actuator_x = 4.283041 um, delta_x = 1.783041 um",
        "stage 2 ends at Qx = 50 N/mm, delta_x = 5.5 um, actuator_x = 8 um, gross slip",
    ]


def test_a_rounded_punch():
    parts = {"surface": {"punch": {"half_width": 0.5, "edge_radius": 100.0}}}
    setup = setup_of({"delta_x": 1e-3}, **parts)
    force = setup.on_rig.driven[1][1].force
    (back,) = (one.value for one in setup_of({"Qx": force}, **parts).on_rig.values() if one.quantity == "delta_x")
    assert back == pytest.approx(1e-3, rel=1e-9)
    assert ("Qx", "Ciavarella-Jaeger") in {(one.quantity, one.source) for one in setup.on_rig.values()}


@pytest.mark.parametrize(
    ("stage", "keys"),
    [
        ({"delta_x": 1e-3}, {"bodies": DISSIMILAR}),
        ({"delta_x": 1e-3, "bulk_2": {"xx": 10.0}}, {}),
        ({"delta_x": 1e-3, "Qy": 1.0}, {}),
        ({"delta_x": 1e-3, "phi_y": 1e-4}, {}),
        ({"delta_x": 1e-3}, {"interface": {"shear_compliance": 2e-5}}),
        ({"delta_x": 1e-3}, {"friction": {"initial": 0.1, "final": 0.3, "slip": 0.01}}),
        ({"delta_x": 1e-3}, {"surface": {"punch": {"half_width": 0.5}}}),
        ({"Qx": 1.0}, {"reference_depth": None}),
    ],
)
def test_nothing_is_claimed_without_a_closed_form(stage, keys):
    setup = setup_of(stage, **keys)
    assert setup.on_rig is None or (setup.on_rig.driven is None and not list(setup.on_rig.values()))
    assert setup.closed_forms.loads == setup.load_path.imposed
    assert not list(rig_lines(setup))


def test_warnings():
    def about(word, *stages, **keys):
        return [text for text in case_warnings(setup_of(*stages, **keys)) if word in text]

    (text,) = about("gross slip", {"Qx": 55.0})
    assert text.endswith("gross slip ends the run; impose delta_x to follow it")
    (text,) = about("gross slip", {"Qx": 55.0}, reference_depth=None)
    assert text.endswith("gross slip ends the run; impose delta_x to follow it, with a reference_depth")
    (text,) = about("gross slip", {"Qx": 55.0}, rig={"stiffness_x": 20e3})
    assert text.endswith("gross slip ends the run; impose actuator_x to follow it")
    (text,) = about("gross slip", {"Qy": 55.0})
    assert text.endswith("gross slip ends the run; lower it")
    (text,) = about("contact radii", {"delta_x": 0.02})
    assert text.startswith("load_path: delta_x moves the surfaces by 0.19 contact radii")
    (text,) = about("rig.stiffness_x", {"actuator_x": 0.02}, rig={"stiffness_x": 2e3})
    assert text.startswith(
        "rig.stiffness_x: with 2000 N/mm^2 the rig takes 93.8 % of actuator_x while the contact sticks"
    )


class TestWear:
    def setup_of(self, name="delta_x", amplitude=5e-3, **keys):
        cycle = {"represents": 1e5, "stages": [{name: -amplitude}, {name: amplitude}]}
        return setup_of({name: amplitude}, {"cycle": cycle}, **{"wear": {"law": "energy", "alpha": 1e-7}, **keys})

    def test_gross_slip(self):
        (cycle,) = worn_cycles(self.setup_of().closed_forms)
        assert cycle.sliding_distance == pytest.approx(2.0 * (5e-3 - ONSET), rel=1e-6)
        # 2 mu P times that, and A (mu P)^2/pi between both onsets of gross slip
        assert cycle.energy == pytest.approx(100.0 * 2.0 * (5e-3 - ONSET) + 0.01379343, rel=1e-6)
        volume = 1e-7 * 1e5 * cycle.energy
        a = cycle.scar.scar_radius
        assert a**3 - 0.75 * 0.1050456**2 * a == pytest.approx(15.0 * volume, rel=1e-6)
        assert cycle.scar.mean_pressure == pytest.approx(50.0 / a, rel=1e-12)
        assert self.setup_of().grid.size[0] > 2.0 * 1.1 * a

    def test_archard_and_a_rig(self):
        """The contact moves by D - C mu P, here 7.5 - 50/20 um."""
        parts = {"rig": {"stiffness_x": 20e3}, "wear": {"law": "archard", "k": 5e-8}}
        (on_rig,) = worn_cycles(self.setup_of("actuator_x", 7.5e-3, **parts).closed_forms)
        (plain,) = worn_cycles(self.setup_of().closed_forms)
        assert on_rig.volume_per_cycle == pytest.approx(plain.volume_per_cycle, rel=1e-9)

    def test_nothing_is_said_of_partial_slip(self):
        assert worn_cycles(self.setup_of(amplitude=1.7e-3).closed_forms) == ()

    def test_lines(self):
        lines = list(wear_lines(self.setup_of()))
        assert lines[2].startswith(
            "at first a cycle dissipates 0.6572 mJ/mm and wears 6.572e-08 mm^3/mm, 0.313 nm deep"
        )
        assert lines[3].startswith(
            "gross slip over 6.434 um in half a cycle at first; all cycles at that rate wear V = "
        )
        assert lines[4].startswith("with that volume (V/V0 = 85) the scar has a = 0.4679 mm and is 10.6 um deep")
        assert lines[5].startswith("an explicit change of the profile would be stable up to ")
