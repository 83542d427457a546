"""Wear in a run: the loop, its accounts, and going on from any increment."""

from pathlib import Path

import numpy as np
import pytest

from fretsolve.case.loading import load_case
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


@pytest.mark.parametrize("step", [3, 6, 7, 11, 12, 14])
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
    assert jumps == [1500.0, 1500.0, 1500.0, 1495.0] or jumps[:3] == [1500.0] * 3
    assert states[-1].summary.cycles == 6000.0


def test_few_cycles_are_all_solved(tmp_path):
    _, states = states_of(tmp_path, 3, "1")
    assert [state.summary.jump for state in states if state.summary.jump] == [1.0, 1.0]
    assert states[-1].summary.cycles == 3.0


def test_archard_agrees_with_energy_at_one_coefficient_of_friction(worn, tmp_path):
    _, states = states_of(tmp_path, wear="{law: archard, k: 1e-8 mm^3/(N*mm)}")
    mine, other = states[-1].summary, worn[1][-1].summary
    assert mine.wear_volume == pytest.approx(other.wear_volume, rel=1e-9)
    assert mine.work_total == pytest.approx(other.work_total, rel=1e-9)


def test_a_saved_run_goes_on_at_a_jump(worn, tmp_path):
    from fretsolve.result import HistoryWriter
    from fretsolve.setup.problem_setup import set_up
    from fretsolve.simulation.run_to_file import run_header

    case, states = worn
    header, out = run_header(set_up(case), 1, []), tmp_path / "worn.h5"
    jump = next(state.summary.step for state in states if state.summary.jump > 1.0)
    with HistoryWriter.open(out, header) as writer:
        for state in states[: jump + 1]:
            writer.append(state)
    with HistoryWriter.open(out, header, resume=True) as writer:
        assert_same_state(writer.last_state, states[jump])
