"""Wear in a run: the loop, its accounts, and going on from any increment."""

import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from fretsolve.case.loading import load_case
from fretsolve.errors import CaseError, ContactLostError
from fretsolve.result.state import State
from fretsolve.simulation.simulation import run
from tests.fake_states import assert_same_state

CASE = """
bodies: [{{young_modulus: 200 GPa, poisson_ratio: 0.3}}, {{young_modulus: 200 GPa, poisson_ratio: 0.3}}]
surface: {{sphere: {{radius: 10 mm}}}}
grid: {{points: 16, size: 0.9 mm}}
friction: {friction}
wear: {wear}
load_path:
  - {{P: 400 N}}
  - {{Qx: 30 N, increments: 2}}
  - cycle:
      represents: {represents}
      jump: {jump}
      stages: [{{Qx: -30 N, increments: 2}}, {{Qx: 30 N, increments: 2}}]
"""
ENERGY = "{law: energy, alpha: 1e-4 mm^3/J, share: [0.25, 0.75]}"


def states_of(folder: Path, represents: float = 20000, jump: str = "auto", wear: str = ENERGY, friction: str = "0.1"):
    path = folder / "wear.yaml"
    path.write_text(CASE.format(represents=represents, jump=jump, wear=wear, friction=friction))
    case = load_case(path)
    return case, list(run(case))


@pytest.fixture(scope="module")
def worn(tmp_path_factory: pytest.TempPathFactory) -> tuple[object, list[State]]:
    return states_of(tmp_path_factory.mktemp("wear"))


def test_the_cycles_add_up_and_the_last_one_is_solved(worn):
    _, states = worn
    rows = [state.summary for state in states]
    assert rows[-1].cycles == 20000.0 and rows[-1].jump == 0.0
    assert 2 < sum(row.jump > 1.0 for row in rows) < 40
    assert all(np.diff([row.cycles for row in rows]) >= 0.0)


def test_the_worn_volume_is_alpha_times_the_dissipated_energy_after_each_increment(worn):
    for state in worn[1]:
        row = state.summary
        assert row.wear_volume == pytest.approx(1e-7 * row.work_total, rel=1e-12)
    depth = worn[1][-1].fields.wear_depth
    np.testing.assert_allclose(depth, 1e-7 * worn[1][-1].fields.work_density, rtol=1e-12)
    assert depth.max() == worn[1][-1].summary.wear_depth_max


def test_the_gap_is_that_of_the_worn_profile(worn):
    _, states = worn
    last = states[-1]
    touching = last.fields.pressure > 0.0
    assert np.abs(last.fields.gap[touching]).max() < 1e-5 * last.summary.delta_z
    lost = last.wear.depth - last.wear.profile  # of the last cycle, which no jump has taken up
    assert 0.0 <= lost.max() < 1e-3 * last.wear.depth.max()


def test_the_surfaces_change_under_held_loads_and_keep_the_locked_shear(worn):
    changes = [(before, state) for before, state in pairwise(worn[1]) if state.summary.jump > 1.0]
    assert changes
    for before, state in changes:
        rows = before.summary, state.summary
        for name in ("P", "Qx"):
            assert getattr(rows[1], name) == pytest.approx(getattr(rows[0], name), rel=1e-6)
        # a new profile, on which little slips, and that slip counts once
        assert state.wear.profile.max() > before.wear.profile.max()
        energy_of_a_cycle = (rows[1].work_total - rows[0].work_total) / rows[1].jump
        assert rows[1].work < 0.05 * energy_of_a_cycle
        stuck = (before.fields.zone == 1) & (state.fields.zone == 1)
        assert stuck.any()
        shear = [np.hypot(*one.fields.shear) for one in (before, state)]
        np.testing.assert_allclose(shear[1][stuck], shear[0][stuck], atol=0.02 * shear[0].max())


@pytest.mark.parametrize("step", [6, 11, 14])
def test_a_run_goes_on_with_the_same_bits(worn, step):
    case, states = worn
    history = [state.summary for state in states[: step + 1]]
    for again, state in zip(run(case, states[step], history), states[step + 1 :], strict=True):
        row, other = vars(again.summary) | {"wall_time": 0.0}, vars(state.summary) | {"wall_time": 0.0}
        assert row == other
        np.testing.assert_array_equal(again.fields.pressure, state.fields.pressure)
        np.testing.assert_array_equal(again.wear.profile, state.wear.profile)


def test_a_given_jump_is_taken(tmp_path):
    _, states = states_of(tmp_path, 6000, "1500")
    jumps = [state.summary.jump for state in states if state.summary.jump > 1.0]
    # those that stand for themselves: the first one, the one after the first jump, and the last one
    assert jumps == [1500.0, 1500.0, 1500.0, 1497.0]
    assert states[-1].summary.cycles == 6000.0


def test_a_saved_run_goes_on_at_a_jump(worn, tmp_path):
    from fretsolve.result import HistoryWriter
    from fretsolve.simulation.problem_setup import set_up
    from fretsolve.simulation.run_to_file import run_header

    case, states = worn
    header, out = run_header(set_up(case), 1, []), tmp_path / "worn.h5"
    jump = next(state.summary.step for state in states if state.summary.jump > 1.0)
    with HistoryWriter.open(out, header) as writer:
        for state in states[: jump + 1]:
            writer.append(state)
    with HistoryWriter.open(out, header, resume=True) as writer:
        assert_same_state(writer.last_state, states[jump])


def test_a_case_without_wear_loads_nothing_of_it(tmp_path):
    path = tmp_path / "plain.yaml"
    text = CASE.format(represents=1, jump="auto", wear=ENERGY, friction="0.1").replace(f"wear: {ENERGY}\n", "")
    path.write_text(text.replace("represents: 1\n      jump: auto", "times: 1"))
    code = f"""
import sys
from fretsolve import load_case, run
assert len(list(run(load_case({str(path)!r})))) > 3
print([name for name in sys.modules if name.startswith("fretsolve.wear")])
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("more", "problem"),
    [
        ("solver: {error_bars: true}", "solver.error_bars: coarse runs cannot follow wear"),
        ("solver: {precision: single}", "solver.precision: single precision cannot resolve"),
    ],
)
def test_what_wear_cannot_have_is_refused(tmp_path, more, problem):
    path = tmp_path / "refused.yaml"
    path.write_text(CASE.format(represents=10, jump="auto", wear=ENERGY, friction="0.1") + more + "\n")
    with pytest.raises(CaseError, match=problem):
        load_case(path)


def test_worn_depths_without_wear_are_refused(tmp_path):
    path = tmp_path / "refused.yaml"
    text = CASE.format(represents=1, jump="auto", wear=ENERGY, friction="0.1").replace(f"wear: {ENERGY}\n", "")
    text = text.replace("represents: 1\n      jump: auto", "times: 1") + "output: {fields: [pressure, wear_depth]}\n"
    path.write_text(text)
    with pytest.raises(CaseError, match=r"output\.fields\.1: wear_depth belongs to wear"):
        load_case(path)


def test_a_table_of_friction_goes_by_the_cycles_that_solved_ones_stand_for(tmp_path):
    _, states = states_of(tmp_path, 2000, "500", friction="{cycles: [[1, 0.1], [2000, 0.2]]}")
    for before, state in pairwise(states):
        if before.summary.cycles:
            expected = 0.1 + 0.1 * before.summary.cycles / 1999.0
            slipping = state.fields.zone == 2
            shear = np.hypot(*state.fields.shear)
            ratio = shear[slipping] / state.fields.pressure[slipping]
            np.testing.assert_allclose(ratio, expected, rtol=1e-6)


PRESSED = "  - {P: 400 N}\n  - {Qx: 30 N, increments: 2}\n"
SHEARED = "stages: [{Qx: -30 N, increments: 2}, {Qx: 30 N, increments: 2}]"


@pytest.mark.parametrize(
    ("pressed", "sheared", "jump", "problem"),
    [
        (
            "  - {delta_z: 9 um}\n  - {delta_x: 15 um, increments: 1}\n",
            "stages: [{delta_x: -15 um, increments: 1}, {delta_x: 15 um, increments: 1}]",
            "100000",
            r"the contact is worn away: with the approach held P has fallen from 400\.2 N to .* after 200002 cycles",
        ),
        (
            "  - {delta_z: -1 um}\n",
            "stages: [{delta_z: 8 um}, {Qx: 20 N, increments: 1}, {Qx: 0 N, increments: 1}, {delta_z: -1 um}]",
            "auto",
            "the surfaces do not touch at the end of the cycle",
        ),
    ],
)
def test_lost_contact_is_said(tmp_path, pressed, sheared, jump, problem):
    text = CASE.format(represents=1e6, jump=jump, wear=ENERGY, friction="0.1")
    path = tmp_path / "lost.yaml"
    text = text.replace(PRESSED, pressed).replace(SHEARED, sheared)
    path.write_text(text.replace("size: 0.9 mm", "size: 1.6 mm"))
    with pytest.raises(ContactLostError, match=problem):
        list(run(load_case(path)))
