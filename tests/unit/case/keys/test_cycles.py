"""Cycles of an amplitude: the stages that they stand for, and their mistakes."""

from __future__ import annotations

from pathlib import Path

import pytest

from fretsolve.case.keys.unrolled_path import CyclePass, last_repetitions
from fretsolve.case.loading import load_case
from fretsolve.case.models import Case
from fretsolve.errors import CaseError, KeyPath, dotted

CASE = """bodies: [rigid, {young_modulus: 200 GPa, poisson_ratio: 0.3}]
surface: {sphere: {radius: 10 mm}}
grid: {points: 16}
friction: 0.1
load_path:
  - {P: 400 N}
  - cycle: CYCLE
"""
LINE = """plane: strain
bodies: [rigid, {young_modulus: 200 GPa, poisson_ratio: 0.3}]
surface: {cylinder: {radius: 10 mm}}
grid: {points: 16}
friction: 0.1
load_path:
  - {P: 100 N/mm}
  - cycle: CYCLE
"""


def case_of(tmp_path: Path, cycle: str, text: str = CASE, overrides: tuple[str, ...] = ()) -> Case:
    path = tmp_path / "case.yaml"
    path.write_text(text.replace("CYCLE", cycle))
    return load_case(path, overrides)


def message(tmp_path: Path, cycle: str, *overrides: str) -> str:
    with pytest.raises(CaseError) as error:
        case_of(tmp_path, cycle, overrides=overrides)
    return str(error.value).replace(f"{tmp_path}/", "")


def test_first_end_and_then_both_ends_in_turn(tmp_path: Path) -> None:
    stages = case_of(tmp_path, "{amplitude: {delta_x: 2 um}, times: 2, increments: 20}").stages()
    assert [dict(stage.targets) for stage in stages[1:]] == [
        {"delta_x": pytest.approx(value)} for value in (2e-3, -2e-3, 2e-3, -2e-3, 2e-3)
    ]
    assert [stage.increments for stage in stages[1:]] == [5, 10, 10, 10, 10]
    assert [stage.number for stage in stages] == [1, 2, 3, 4, 5, 6]


@pytest.mark.parametrize(
    ("cycle", "last"),
    [
        ("{amplitude: {Qx: 20 N}, times: 3}", [1, 2, 7, 8]),
        ("{times: 3, stages: [{Qx: 20 N}, {Qx: 0 N}, {Qx: 20 N}]}", [1, 8, 9, 10]),
        ("{times: 2, stages: [{cycle: {times: 2, stages: [{Qx: 20 N}, {Qx: 0 N}]}}, {P: 300 N}]}", [1, 9, 10, 11]),
    ],
)
def test_last_repetitions(tmp_path: Path, cycle: str, last: list[int]) -> None:
    assert sorted(last_repetitions(case_of(tmp_path, cycle).stages()).values()) == last


def test_increments_are_rounded_up_or_automatic(tmp_path: Path) -> None:
    stages = case_of(tmp_path, "{amplitude: {Qx: 20 N}, times: 1, increments: 7}").stages()
    assert [stage.increments for stage in stages[1:]] == [2, 4, 4]
    stages = case_of(tmp_path, "{amplitude: {Qx: 20 N}, times: 1, spacing: graded}").stages()
    assert {(stage.increments, stage.spacing) for stage in stages[1:]} == {(None, "graded")}


def test_mean_and_several_components_in_phase(tmp_path: Path) -> None:
    cycle = "{amplitude: {Qx: 20 N, Mz: -3 N mm, bulk_2: {xx: 70 MPa}}, mean: {Qx: 5 N}, times: 1}"
    stages = case_of(tmp_path, cycle).stages()
    ends = [{"Qx": 25.0, "Mz": -3.0, "bulk_2_xx": 70.0}, {"Qx": -15.0, "Mz": 3.0, "bulk_2_xx": -70.0}]
    assert [dict(stage.targets) for stage in stages[1:]] == [ends[0], ends[1], ends[0]]


def test_repetitions_are_known_by_their_stages(tmp_path: Path) -> None:
    stages = case_of(tmp_path, "{amplitude: {Qx: 20 N}, times: 2}").stages()
    key = ("load_path", 1, "cycle")
    turns = [None, None, *[CyclePass(1, turn, None, key) for turn in (1, 1, 2, 2)]]
    assert [stage.cycle for stage in stages] == turns
    nested = "{times: 2, stages: [{cycle: {amplitude: {Qx: 20 N}, times: 1}}, {Qx: 0 N}]}"
    stages = case_of(tmp_path, nested).stages()
    runs = [stage.cycle.cycle if stage.cycle else None for stage in stages]
    assert runs == [None, None, 1, 1, None, None, 2, 2, None]  # each innermost repetition alone is a cycle


def test_until_periodic_has_defaults_and_counts_as_the_most_cycles(tmp_path: Path) -> None:
    case = case_of(tmp_path, "{amplitude: {Qx: 20 N}, until: periodic}")
    assert case.effective()["load_path"][1]["cycle"] == {
        "until": "periodic",
        "at_most": 20,
        "tolerance": 0.01,
        "amplitude": {"Qx": 20.0},
        "increments": "auto",
    }
    assert len(case.stages()) == 2 + 2 * 20
    assert case.stages()[-1].cycle == CyclePass(1, 20, 0.01, ("load_path", 1, "cycle"))
    stages = "{stages: [{Qx: 9 N}, {Qx: -9 N}], until: periodic, at_most: 3, tolerance: 2 %}"
    assert len(case_of(tmp_path, stages).stages()) == 7


def test_effective_case_is_read_again(tmp_path: Path) -> None:
    case = case_of(tmp_path, "{amplitude: {Qx: 20 N}, mean: {Qx: 1 N}, until: periodic}")
    again = Case.model_validate(case.effective())
    assert [stage.targets for stage in again.stages()] == [stage.targets for stage in case.stages()]
    line = case_of(tmp_path, "{amplitude: {Qx: 5 N/mm}, times: 2}", LINE)
    assert [dict(stage.targets)["Qx"] for stage in line.stages()[1:]] == [5.0, -5.0, 5.0, -5.0, 5.0]


def test_increments_of_a_stage_in_it_are_those_of_the_cycle(tmp_path: Path) -> None:
    cycle = "{amplitude: {Qx: 20 N}, times: 2}"
    case = case_of(tmp_path, cycle, overrides=("stage.3.increments=40",))
    assert [stage.increments for stage in case.stages()[1:]] == [10, 20, 20, 20, 20]
    said = message(tmp_path, cycle, "stage.3.Qx=9")
    assert said.endswith("load_path.1.cycle.amplitude.Qx sets what moves")


@pytest.mark.parametrize(
    ("cycle", "says"),
    [
        ("{times: 3}", "cycle.stages: missing; needed: the stages of one cycle, a list; or an amplitude"),
        ("{amplitude: {Qx: 2 N}}", "cycle.times: missing; needed: number of repetitions, such as 3"),
        ("{amplitude: {Qx: 2 N}, times: 3, until: periodic}", "cycle.times: times and until exclude each other; "),
        ("{amplitude: {Qx: 2 N}, times: 3, at_most: 4}", "cycle.at_most: only until: periodic takes it; "),
        ("{amplitude: {Qx: 2 N}, until: steady}", "cycle.until: 'steady' is not allowed; one of periodic is needed"),
        ("{amplitude: {Qx: 0 N}, times: 1}", "cycle.amplitude.Qx: the amplitude is 0; "),
        ("{amplitude: {Qx: 2 N}, mean: {Qy: 1 N}, times: 1}", "cycle.mean.Qy: it has no amplitude; "),
        ("{amplitude: {P: 2 N}, mean: {P: 1 N}, times: 1}", "cycle.amplitude.P: 2 is more than the mean of P (1), "),
        ("{amplitude: {Qx: 2 N, delta_x: 1 um}, times: 1}", "cycle.amplitude: Qx and delta_x cannot be imposed"),
        ("{amplitude: {}, times: 1}", "cycle.amplitude: no component is given; at least one of P, "),
        ("{amplitude: {Qx: 2 N, increments: 3}, times: 1}", "cycle.amplitude.increments: unknown key"),
        ("{amplitude: {Qx: 2 mm}, times: 1}", "cycle.amplitude.Qx: '2 mm' is a length; a force such as '400 N'"),
        ("{stages: [{cycle: {amplitude: {Qx: 2 N}, times: 1}}], until: periodic}", "cycle.until: its stages hold"),
    ],
)
def test_mistakes_are_named_at_their_keys(tmp_path: Path, cycle: str, says: str) -> None:
    assert f"case.yaml:7: load_path.1.{says}" in message(tmp_path, cycle)


def test_repetitions_of_outermost_cycles_have_a_friction_each(tmp_path: Path) -> None:
    """The way to the first end belongs to the first repetition, and what follows a cycle to its last one."""
    text = CASE.replace("friction: 0.1", "friction: {cycles: [[1, 0.1], [2, 0.2]]}") + "  - {Qx: 0 N}\n"
    path = tmp_path / "case.yaml"
    path.write_text(text.replace("CYCLE", "{amplitude: {Qx: 20 N}, times: 2}"))
    stages = load_case(path).stages()
    assert [stage.outer for stage in stages] == [0, 1, 1, 1, 2, 2, 0]
    assert [dict(stage.targets)["friction"] for stage in stages] == [0.1, 0.1, 0.1, 0.1, 0.2, 0.2, 0.2]
    path.write_text(
        text.replace("CYCLE", "{times: 2, stages: [{cycle: {amplitude: {Qx: 20 N}, times: 2}}, {Qx: 1 N}]}")
    )
    stages = load_case(path).stages()
    assert [stage.outer for stage in stages] == [0, *[1] * 6, *[2] * 6, 0]


NESTED = """{times: 3, stages: [{Qx: 1 N}, {cycle: {until: periodic, at_most: 4, stages: [{Qx: 2 N}, {Qx: 3 N}]}},
      {cycle: {amplitude: {Qx: 4 N}, times: 2}}, {Qx: 5 N}]}
  - {Qx: 0 N}"""
WORN = """{represents: 1000, jump: 100, stages: [{Qx: 4 N}, {Qx: 0 N}]}
  - {Qx: 1 N}
wear: {law: energy, alpha: 1e-4 mm^3/J}"""


@pytest.mark.parametrize("cycle", [NESTED, WORN, "{amplitude: {Qx: 4 N}, times: 2}\n  - {Qx: 0 N}"])
def test_the_key_of_a_stage_is_its_number_and_leads_back_to_it(tmp_path: Path, cycle: str) -> None:
    text = CASE.replace("{P: 400 N}", "{P: 400 N}\n  - {Qx: 0 N}")
    case, typed = case_of(tmp_path, cycle, text), set[KeyPath]()
    for stage in case.stages():
        key = case.source.typed((*stage.key, "spacing"))
        if stage.wears or key in typed:
            continue
        typed.add(key)
        assert key == ("stage", stage.number, "spacing")
        again = case_of(tmp_path, cycle, text, (f"{dotted(key)}=graded",))
        assert again.source.overrides[-1].key == (*stage.key, "spacing")
        assert again.stages()[stage.number - 1].spacing == "graded"
    assert len(typed) == len({stage.key for stage in case.stages() if not stage.wears})
    assert case.source.typed(("load_path", 2, "cycle", "times")) == ("load_path", 2, "cycle", "times")


@pytest.mark.parametrize(
    ("cycle", "overrides", "says"),
    [
        (NESTED, (), "case.yaml:7: stage.3.Qx: '2 m' is a length; a force such as '400 N' is needed"),
        (NESTED.replace("5 N", "2 m"), (), "case.yaml:8: stage.16.Qx: '2 m' is a length; a force"),
        ("{times: -4, stages: [{Qx: 2 N}]}\n  - {Qx: 2 N}", (), "case.yaml:8: stage.3.Qx: '2 m' is a length; a force"),
        ("{amplitude: {Qx: 1 N}, times: 3, increments: 0}", (), "case.yaml:7: stage.2.increments: 0 is too small; a"),
        ("{times: 2, stages: [{Qx: 1 N}]}", ("load_path.1.cycle.stages.0.Qx=2 m",), "Qx=2 m: stage.2.Qx: '2 m' is a"),
        ("{times: 2, stages: [{Qx: 1 N}]}", ("stage.3.Qx=2 m",), "--set stage.3.Qx=2 m: stage.2.Qx: '2 m' is a length"),
    ],
)
def test_mistakes_name_stages_as_they_are_counted(
    tmp_path: Path, cycle: str, overrides: tuple[str, ...], says: str
) -> None:
    assert says in message(tmp_path, cycle.replace("2 N", "2 m"), *overrides).replace("override", "--set")
