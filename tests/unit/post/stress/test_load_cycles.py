"""Which cycles a history holds, which of them are chosen, and blocks of them in a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest
from small_cases import SPHERE, write_case

from fretsolve.case.loading import load_case
from fretsolve.errors import CaseError, FileError
from fretsolve.post.stress.cycles import (
    LoadCycle,
    chosen,
    cycles_as_text,
    cycles_from_text,
    load_cycles,
    read_blocks,
    require_states,
    states_of,
    whole_path_note,
    within,
)


def cycles_in_path(folder: Path, path: str, left_out: tuple[int, ...] = (), *, more: str = "") -> list[LoadCycle]:
    """Return the cycles of a load path with two increments in each stage; left_out: stages that were not solved."""
    stages = load_case(write_case(folder, f"{SPHERE}{more}load_path: [{path}]\n")).stages()
    solved = [stage.number for stage in stages if stage.number not in left_out]
    return load_cycles(stages, np.repeat(solved, 2))


def test_each_repetition_is_a_cycle_that_begins_with_the_state_before(tmp_path: Path) -> None:
    cycles = cycles_in_path(tmp_path, "{P: 4 N}, {cycle: {times: 2, stages: [{Qx: 1 N}, {Qx: 0 N}]}}")
    assert cycles == [LoadCycle(1, (1, 2, 3, 4, 5), (1, 3, 5)), LoadCycle(2, (5, 6, 7, 8, 9), (5, 7, 9))]
    assert whole_path_note(cycles) is None


def test_innermost_cycles_count(tmp_path: Path) -> None:
    inner = "{cycle: {times: 2, stages: [{Qx: 1 N}, {Qx: 0 N}]}}"
    cycles = cycles_in_path(tmp_path, f"{{P: 4 N}}, {{cycle: {{times: 2, stages: [{inner}, {{P: 3 N}}]}}}}")
    assert [(cycle.number, cycle.states[0], cycle.states[-1]) for cycle in cycles] == [
        (1, 1, 5),
        (2, 5, 9),
        (3, 11, 15),  # not the stage between, which belongs to the outer cycle
        (4, 15, 19),
    ]


def test_a_cycle_that_ends_by_itself_leaves_stages_out(tmp_path: Path) -> None:
    cycle = "{cycle: {until: periodic, at_most: 4, stages: [{Qx: 1 N}, {Qx: 0 N}]}}"
    cycles = cycles_in_path(tmp_path, f"{{P: 4 N}}, {cycle}, {{P: 3 N}}", left_out=(6, 7, 8, 9))
    assert [cycle.states for cycle in cycles] == [(1, 2, 3, 4, 5), (5, 6, 7, 8, 9)]


def test_a_cycle_after_a_change_by_wear_begins_with_its_own_end(tmp_path: Path) -> None:
    cycle = "{cycle: {represents: 200, jump: 100, stages: [{Qx: 1 N}, {Qx: 0 N}]}}"
    wear = "wear: {law: energy, alpha: 1e-9 mm^3/J, share: [0.5, 0.5]}\n"
    first, second, *_ = cycles_in_path(tmp_path, f"{{P: 4 N}}, {cycle}", more=wear)
    assert first.states == (1, 2, 3, 4, 5)
    begin, *inside = second.states
    assert begin == inside[-1]
    assert begin not in first.states


def test_a_path_without_cycles_counts_as_one(tmp_path: Path) -> None:
    cycles = cycles_in_path(tmp_path, "{P: 4 N}, {Qx: 1 N}")
    assert cycles == [LoadCycle(0, (0, 1, 2, 3), (1, 3), from_rest=True)]
    assert whole_path_note(cycles) == "the load path has no `cycle`: the whole path counts as one"
    assert chosen(cycles, 1) == tuple(cycles)


def test_a_path_that_has_not_ended_is_told(tmp_path: Path) -> None:
    stages = load_case(write_case(tmp_path, f"{SPHERE}load_path: [{{P: 4 N}}, {{Qx: 1 N}}]\n")).stages()
    cycles = load_cycles(stages, np.array([1, 1, 2]), ended=False)
    note = "the load path has no `cycle`: the part of it that is there counts as one, not the whole path"
    assert whole_path_note(cycles_from_text(cycles_as_text(cycles))) == note


def test_a_cycle_at_the_start_of_the_path_begins_unloaded(tmp_path: Path) -> None:
    cycles = cycles_in_path(tmp_path, "{cycle: {times: 2, stages: [{P: 4 N}, {P: 2 N}]}}")
    assert cycles == [LoadCycle(1, (0, 1, 2, 3), (1, 3), from_rest=True), LoadCycle(2, (3, 4, 5, 6, 7), (3, 5, 7))]
    values = np.array([[3.0, 4.0], [5.0, 6.0]])
    assert cycles[0].with_rest(values).tolist() == [[0, 0], [3, 4], [5, 6]]
    assert cycles[0].with_rest(values, axis=1).tolist() == [[0, 3, 4], [0, 5, 6]]
    assert cycles[1].with_rest(values) is values


THREE = [LoadCycle(n, tuple(range(4 * n - 4, 4 * n + 1)), (4 * n - 4, 4 * n)) for n in (1, 2, 3)]


@pytest.mark.parametrize(
    ("choice", "numbers", "times"),
    [("last", [3], [1.0]), ("all", [1, 2, 3], [1.0] * 3), (2, [2], [1.0]), ({3: 10.0, 1: 0.5}, [3, 1], [10.0, 0.5])],
)
def test_choices(choice: Mapping[int, float], numbers: list[int], times: list[float]) -> None:
    found = chosen(THREE, choice)
    assert ([cycle.number for cycle in found], [cycle.times for cycle in found]) == (numbers, times)


def test_a_cycle_that_is_not_there_is_refused() -> None:
    with pytest.raises(CaseError, match="there is no cycle 4; there are 1 to 3"):
        chosen(THREE, {1: 1.0, 4: 2.0})
    with pytest.raises(CaseError, match="no cycle is there whole"):
        chosen([], "last")


def test_a_file_of_some_increments_holds_the_cycles_whose_ends_it_has() -> None:
    assert within(THREE, [4, 6, 8, 12]) == [LoadCycle(2, (0, 1, 2), (0, 2)), LoadCycle(3, (2, 3), (2, 3))]
    whole = LoadCycle(0, (0, 1, 2, 3), (1, 3), from_rest=True, ended=False)
    assert within([whole], [0, 2]) == [LoadCycle(0, (0, 1), (), from_rest=True, ended=False)]
    assert cycles_from_text(cycles_as_text([*THREE, whole])) == [*THREE, whole]
    assert states_of(THREE[:2], [0, 3, 4, 5, 20]) == (0, 3, 4, 5)


@pytest.mark.parametrize(
    ("steps", "stored", "from_rest"),
    [
        ([0, 1, 2, 3, 4, 5], None, True),
        ([0, 1, 2], range(6), True),
        ([2, 3, 4, 5], range(6), False),
        ([1, 3, 5], [1, 3, 5], True),  # output.every
        ([2, 4, 5], range(6), True),  # the ends of all stages
        ([4, 5], range(6), False),
    ],
)
def test_a_part_of_a_path_begins_unloaded_if_it_begins_the_path(
    steps: list[int], stored: Sequence[int] | None, from_rest: bool
) -> None:
    (found,) = within([LoadCycle(0, (0, 1, 2, 3, 4, 5), (2, 4, 5), from_rest=True)], steps, stored)
    assert found.from_rest is from_rest
    if {2, 4, 5} <= set(steps):  # a cycle of the path is whole with all of its ends
        (cycle,) = within([LoadCycle(1, (0, 1, 2, 3, 4, 5), (2, 4, 5), from_rest=True)], steps, stored)
        assert cycle.from_rest
    (loaded,) = within([LoadCycle(0, (0, 1, 2, 3, 4, 5), (2, 4, 5))], steps, stored)
    assert not loaded.from_rest


def test_few_states_and_turns_without_fields_are_refused() -> None:
    require_states(THREE[0], [0, 2, 4])
    with pytest.raises(
        CaseError, match=r"2 stored states; 3 or more are needed: output\.every leaves out the others, 1 stores all"
    ):
        require_states(THREE[0], [0, 4])
    whole = LoadCycle(0, (0, 1, 2, 3), (1, 3), from_rest=True)
    with pytest.raises(CaseError, match="the whole load path has 1 stored state; 3 or more are needed"):
        require_states(whole, [3])
    with pytest.raises(CaseError, match="leaves out increment 1, where a stage ends; 1 is needed"):
        require_states(whole, [0, 2, 3])
    with pytest.raises(CaseError, match=r"leaves out increments 0, 4, where a stage of the cycle begins or ends"):
        require_states(THREE[0], [1, 2, 3])


def test_blocks_are_read_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "blocks.csv"
    path.write_text("cycle, times\n1, 1e3\n\n3,0.5\n")
    assert read_blocks(path) == {1: 1000.0, 3: 0.5}


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("", 1, "the heading cycle,times is needed, then a line such as 1,1000 for each cycle"),
        ("1,1000\n", 1, "the heading cycle,times is needed"),
        ("cycle,times\n", None, "no cycle is named; a line such as 1,1000 is needed"),
        ("cycle,times\n1\n", 2, "'1' is not a cycle and how often it occurs; a line such as 1,1000 is needed"),
        ("cycle,times\n1,2\nx,3\n", 3, "'x,3' is not a cycle and how often it occurs"),
        ("cycle,times\n0,3\n", 2, "'0,3' is out of range; a cycle from 1 on and a number above 0 are needed"),
        ("cycle,times\n1,inf\n", 2, "'1,inf' is out of range"),
        ("cycle,times\n1,nan\n", 2, "'1,nan' is out of range"),
        ("cycle,times\n1,2\n\n1,3\n", 4, "cycle 1 stands in the block twice; once is enough"),
    ],
)
def test_mistakes_in_blocks(tmp_path: Path, text: str, line: int | None, message: str) -> None:
    path = tmp_path / "blocks.csv"
    path.write_text(text)
    with pytest.raises(CaseError) as caught:
        read_blocks(path)
    assert (caught.value.file, caught.value.line) == (path, line)
    assert caught.value.message.startswith(message)


def test_a_missing_file_of_blocks(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="cannot be read"):
        read_blocks(tmp_path / "none.csv")
