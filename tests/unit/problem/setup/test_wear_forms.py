"""What is said of wear before a case is run."""

from __future__ import annotations

import math

import pytest
from line_cases import line_case
from solving import DISSIMILAR, FRICTION, HERTZ, LOAD, MATERIAL, A, build

from fretsolve.cli.case_summary import wear_lines
from fretsolve.errors import CaseError
from fretsolve.problem.setup.warnings import case_warnings
from fretsolve.problem.setup.wear_forms import worn_cycles, worn_radius
from fretsolve.reference.tangential import cattaneo_mindlin
from fretsolve.reference.worn_contact import volume_scale
from fretsolve.simulation.problem_setup import set_up

WEAR = {"law": "energy", "alpha": 1e-7}
SLIDING = cattaneo_mindlin(HERTZ, FRICTION, FRICTION * LOAD, MATERIAL.tangential).delta_x
V0 = volume_scale(HERTZ)


def worn(name, value, cycles, *, wear=WEAR, pressed=None, jump="auto", jumps=None, **parts):
    path = [pressed or {"P": LOAD}, {name: value}]
    stages = [{name: -value}, {name: value}]
    path.append({"cycle": {"represents": cycles, "jump": jump, **(jumps or {}), "stages": stages}})
    return set_up(build(**{"grid": {"points": 32}, "wear": wear, "load_path": path, **parts}))


def test_partial_slip_under_a_force():
    setup = worn("Qx", 36.0, 1e6)
    (cycle,) = worn_cycles(setup.closed_forms)
    assert (cycle.slides, cycle.stages, cycle.scar) == (False, (3, 4), None)
    assert cycle.energy == pytest.approx(cattaneo_mindlin(HERTZ, FRICTION, 36.0, MATERIAL.tangential).work_per_cycle)
    assert cycle.volume_at_first_rate == pytest.approx(1e-7 * cycle.energy * 1e6)
    assert cycle.depth_per_cycle * math.pi * (A**2 - cycle.slip.stick_radius**2) == pytest.approx(1e-7 * cycle.energy)
    assert cycle.limit is not None
    assert cycle.limit.stick_radius / A == pytest.approx(0.1 ** (1 / 3))
    assert cycle.limit.volume / V0 == pytest.approx(3.538490, rel=1e-5)
    assert cycle.limit.load == pytest.approx(LOAD)


def test_partial_slip_under_a_displacement():
    """The worn limit is known where the approach is kept, not where P is."""
    share = 0.75  # of the displacement of gross slip: c = a0/2
    setup = worn("delta_y", share * SLIDING, 1e4, pressed={"delta_z": HERTZ.delta_z})
    (cycle,) = worn_cycles(setup.closed_forms)
    assert cycle.limit is not None
    assert (cycle.limit.stick_radius / A, cycle.limit.load / LOAD) == pytest.approx((0.5, 0.6875))
    assert cycle.slip.delta_x == pytest.approx(share * SLIDING)
    (cycle,) = worn_cycles(worn("delta_y", share * SLIDING, 1e4).closed_forms)
    assert cycle.limit is None


def test_a_rig_takes_its_part_of_the_motion():
    """Gross slip: the contact moves by mu P/k less. No worn limit or scar is known, as the rig lets the load change."""
    setup = worn("actuator_x", 2.0 * SLIDING + 0.8e-3, 1e4, rig={"stiffness_x": 50e3})
    (cycle,) = worn_cycles(setup.closed_forms)
    assert cycle.slides
    assert cycle.sliding_distance == pytest.approx(2.0 * SLIDING, rel=1e-9)
    assert cycle.scar is not None
    pressed = {"actuator_z": HERTZ.delta_z + 2e-3}
    rig = {"stiffness_x": 50e3, "stiffness_z": 200e3}
    (cycle,) = worn_cycles(worn("actuator_x", 3e-3, 1e4, pressed=pressed, rig=rig).closed_forms)
    assert (cycle.slides, cycle.load_kept, cycle.scar) == (True, False, None)
    (cycle,) = worn_cycles(worn("actuator_x", 1e-3, 1e4, rig=rig).closed_forms)
    assert (cycle.slides, cycle.limit) == (False, None)
    assert cycle.energy == pytest.approx(
        cattaneo_mindlin(HERTZ, FRICTION, cycle.slip.shear_force, MATERIAL.tangential).work_per_cycle
    )
    assert cycle.slip.delta_x + cycle.slip.shear_force / 50e3 == pytest.approx(1e-3, rel=1e-9)


def test_automatic_size_holds_the_worn_contact():
    setup = worn("delta_x", 10e-3, 1e6)
    (cycle,) = worn_cycles(setup.closed_forms)
    assert cycle.scar is not None
    assert 0.5 * setup.grid.size[0] > 1.19 * cycle.scar.scar_radius > 2.0 * A
    assert worn_radius(setup.closed_forms) == pytest.approx((A**4 + 4e1 * cycle.scar.volume / math.pi) ** 0.25)
    limited = worn("Qx", 36.0, 1e9)
    assert 0.5 * limited.grid.size[0] == pytest.approx(1.2 * 1.571002 * A, rel=1e-6)
    assert worn("Qx", 36.0, 2.0).grid.size[0] == pytest.approx(2.4 * A, rel=1e-4)


@pytest.mark.parametrize(
    "parts",
    [
        {"surface": {"ellipsoid": {"radius_x": 10.0, "radius_y": 20.0}}},
        {"friction": {"coefficient": 0.1, "shear_limit": 100.0}},
        {"friction": {"coefficient": [0.1, 0.2]}},
        {"wear": {"law": "archard", "k": 1e-8, "exponent": 2, "reference_pressure": 1e3}},
    ],
    ids=["ellipsoid", "shear limit", "two coefficients", "power of the pressure"],
)
def test_where_no_closed_form_tells(parts):
    setup = worn("Qx", 20.0, 1e4, **parts)
    assert worn_cycles(setup.closed_forms) == ()
    assert "no closed form tells how much wears here" in list(wear_lines(setup))
    assert any("no closed form tells how far wear widens it" in text for text in case_warnings(setup))


def test_lines_of_partial_slip():
    head, stands, first, partial, limit, explicit, left_out = wear_lines(worn("Qx", 36.0, 1e6, jump=1e6))
    assert head == "\n# wear by the dissipated energy: alpha = 1e-07 mm^3/(N mm), 50 % in body 1, 50 % in body 2"
    assert stands == "stages 3 to 4 stand for 1e+06 cycles, in jumps of 1e+06"
    assert first.startswith("at first a cycle dissipates 0.01414 mJ and wears 1.414e-09 mm^3, ")
    assert partial.startswith("partial slip outside of c = 0.1398 mm; all cycles at that rate would wear 0.001414 mm^3")
    assert limit.startswith("the worn limit, near from T = 100 on, has V = 0.002285 mm^3, a scar of 0.473 mm and")
    assert "jumps of 1e+06 are beyond that; the implicit one is for any jump" in explicit
    assert left_out.startswith("left out: debris between the surfaces, oxidation, plastic flow, the motion of worn")


def test_unlike_bodies_have_no_worn_limit():
    """Popov's closed form asks for equal elastic constants; the scar of like bodies is the estimate for the grid."""
    like, unlike = (worn("Qx", 36.0, 1e9, **parts) for parts in ({}, {"bodies": DISSIMILAR}))
    (cycle,) = worn_cycles(unlike.closed_forms)
    assert cycle.coupled and cycle.limit is None
    lines = list(wear_lines(unlike))
    assert not any("worn limit" in line or "Popov" in line for line in lines)
    assert "these are of like bodies: between unlike ones no closed form holds, and the stick zone may change" in lines
    assert any("worn limit" in line for line in wear_lines(like))
    assert unlike.grid.size[0] == pytest.approx(1.571002 * 2.4 * cycle.hertz.contact_radius, rel=1e-6)


def test_lines_of_gross_slip():
    wear = {"law": "archard", "k": 1e-8, "share": [0.2, 0.8]}
    head, stands, _, gross, scar, *_ = wear_lines(worn("delta_x", 10e-3, 1e4, wear=wear))
    assert head.endswith("wear by pressure and slip (Archard): k = 1e-08 mm^3/(N mm), 20 % in body 1, 80 % in body 2")
    assert stands == "stages 3 to 4 stand for 10000 cycles, in jumps by a tolerance of 1 %"
    assert gross.startswith("gross slip over 17.8 um in half a cycle at first; all cycles at that rate wear V = 0.0014")
    assert scar.startswith("with that volume (V/V0 = 2.26) the scar has a = 0.4035 mm")


@pytest.mark.slow
def test_warnings():
    def about_wear(setup):
        return [text for text in case_warnings(setup) if text.startswith(("wear", "grid.size"))]

    assert about_wear(worn("delta_x", 10e-3, 1e4)) == []
    (text,) = about_wear(worn("delta_x", 30e-3, 1e4))
    assert text.startswith("wear: half a cycle slips 0.0578 mm, 19 % of the contact radius, but worn profiles keep")
    (text,) = about_wear(worn("delta_x", 10e-3, 1e6, grid={"points": 32, "size": 1.0}))
    assert text.startswith("grid.size: the worn contact may reach 1.17 mm from the grid's middle")
    # no closed form tells how far the contact of a line reaches
    cycle = {"represents": 1e3, "stages": [{"Qx": -5.0}, {"Qx": 5.0}]}
    path = [{"P": 100.0}, {"Qx": 5.0}, {"cycle": cycle}]
    assert about_wear(set_up(line_case(grid={"points": 48, "size": 0.4}, wear=WEAR, load_path=path))) == []
    ellipsoid = {"ellipsoid": {"radius_x": 10.0, "radius_y": 20.0}}
    grid = {"points": 32, "size": 2.0, "center": [0.6, 0.0]}
    assert about_wear(worn("Qx", 36.0, 1e4, grid=grid, surface=ellipsoid)) == []
    unworn = [{"P": LOAD}, {"Qx": 30.0}]
    (text,) = about_wear(set_up(build(grid={"points": 32}, wear=WEAR, load_path=unworn)))
    assert text.startswith("wear: no cycle represents others, so that worn depth is counted and the surfaces keep")


def test_pressing_alone_wears_only_unlike_bodies():
    path = [{"P": LOAD}, {"cycle": {"represents": 10, "stages": [{"P": 300.0}, {"P": LOAD}]}}]
    with pytest.raises(CaseError, match="the load path shears nothing, so that nothing wears; a stage that moves Qx"):
        set_up(build(grid={"points": 16}, wear=WEAR, load_path=path))
    assert set_up(build(grid={"points": 16}, wear=WEAR, load_path=path, bodies=DISSIMILAR)).model.has_shear


@pytest.mark.parametrize(
    ("jumps", "told"),
    [
        ({"tolerance": 0.001}, None),
        ({"tolerance": 2e-5}, None),
        ({"tolerance": 1e-6}, "tolerance: about 600 cycles would have to be solved; a larger tolerance needs fewer"),
        ({"tolerance": 1e-9}, "tolerance: about 20000 cycles would have to be solved, but there may be 1000, so that"),
        ({"max_depth": 1e-5}, None),  # 0.01 um
        ({"max_depth": 1e-6}, "max_depth: about "),
        (
            {"max_depth": 1e-12},
            "max_depth: about 100000 cycles would have to be solved, but there may be 1000, so that",
        ),
        ({"jump": 500}, None),
    ],
)
def test_jumps_that_need_very_many_solved_cycles_are_told(jumps, told):
    texts = [text for text in case_warnings(worn("Qx", 36.0, 1e5, jumps=jumps)) if "to be solved" in text]
    assert len(texts) == (told is not None)
    if told is not None:
        assert texts[0].startswith(f"load_path.2.cycle.{told}")


def test_a_stick_zone_of_few_cells_is_told_of():
    def told(points, cycles, center=(0.0, 0.0), jumps=None):
        grid = {"points": points, "size": 1.0, "center": center}
        setup = worn("Qx", 36.0, cycles, grid=grid, jumps=jumps)
        return [text for text in case_warnings(setup) if "as a whole" in text]

    assert told(64, 1e4) == []  # little is worn
    (centred,) = told(32, 1e6)
    assert centred.startswith(
        "grid.points: c is 4.5 cells, which stick or slip as a whole: the worn volume may change by"
    )
    assert centred.endswith("with a center of [0.00969 mm, 0.00531 mm], a part of a cell aside")
    (shifted,) = told(32, 1e6, (0.00969, 0.00531))
    assert shifted.endswith("more of them change it less")
    assert told(256, 1e6) == []
    assert told(256, 1e6, jumps={"tolerance": 1e-3}) != []


def test_a_small_tolerance_is_told_of_without_a_closed_form():
    warned = case_warnings(worn("Mz", 20.0, 1e5, jumps={"tolerance": 1e-9}))
    assert any("cycle.tolerance: about 50000 cycles would have to be solved" in text for text in warned)
