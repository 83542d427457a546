"""``--set KEY=VALUE``: values in place of the file's, validated like the file's."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from small_cases import case_error, write_case

from fretsolve.case.keys.body_specs import ConeSurface, ElasticBody, SphereSurface
from fretsolve.case.loading import load_case
from fretsolve.errors import CaseError

CASE = """\
bodies: [{young_modulus: 1, poisson_ratio: 0.3}, rigid]
surface: {sphere: {radius: 1}}
grid: {points: 8}
friction: 0.1
load_path: [{P: 1}, {Qx: 2, increments: 3}]
"""


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return write_case(tmp_path, CASE)


def test_values_in_mappings_and_lists(path: Path) -> None:
    case = load_case(path, ["load_path.1.increments=5", "grid.points=[4, 6]", "load_path.0.P=2 kN"])
    assert case.stages()[1].increments == 5
    assert case.grid.points == (4, 6)
    assert case.stages()[0].targets == (("P", 2000.0),)


def test_optional_keys_are_made(path: Path) -> None:
    case = load_case(path, ["solver.tolerance=1e-8", "title=a=b"])
    assert case.solver.tolerance == 1e-8
    assert case.title == "a=b"


def test_whole_mappings_are_replaced(path: Path) -> None:
    case = load_case(path, ["surface={cone: {angle: 0.1}}", "bodies.1={young_modulus: 2, poisson_ratio: 0}"])
    assert case.surface == (ConeSurface(angle=0.1),)
    assert case.bodies[1] == ElasticBody(young_modulus=2, poisson_ratio=0)


def test_shorthand_gives_way_to_its_mapping(path: Path) -> None:
    assert load_case(path, ["friction.coefficient=0.4"]).friction.coefficient == 0.4


def test_a_key_beside_a_value_that_stands_alone(path: Path) -> None:
    case = load_case(path, ["friction=0.4", "friction.shear_limit=100 MPa"])
    assert (case.friction.coefficient, case.friction.shear_limit) == (0.4, 100.0)
    limited = load_case(
        path, ["grid.points=16", "solver.accuracy=1 %", "solver.accuracy.at_most.time=1 min"]
    ).solver.accuracy
    assert limited is not None and (limited.target, limited.at_most.time) == (0.01, 60.0)


def test_last_override_wins(path: Path) -> None:
    assert load_case(path, ["friction=0.2", "friction=0.3"]).friction.coefficient == 0.3


@pytest.mark.parametrize(
    ("overrides", "names"),
    [
        (["load_path.0.P=2", "stage.1.P=3"], "load_path.0.P and stage.1.P"),
        (["surface.0={cone: {angle: 1}}", "surface={sphere: {radius: 1}}"], "surface.0 and surface"),
    ],
)
def test_two_names_of_one_key_are_refused(path: Path, overrides: list[str], names: str) -> None:
    with pytest.raises(CaseError) as caught:
        load_case(path, overrides)
    assert str(caught.value) == f"override {overrides[1]}: {names} are two names of one key; keep one of the two"


def test_a_surface_alone_is_the_first_one(path: Path) -> None:
    assert load_case(path, ["surface.0.sphere.radius=3"]).surface == (SphereSurface(radius=3),)
    with pytest.raises(CaseError) as caught:
        load_case(path, ["surface.0.sphere.radius=0"])
    message = "override surface.0.sphere.radius=0: surface.sphere.radius: 0 is out of range; a length != 0 mm is needed"
    assert str(caught.value) == message
    with pytest.raises(CaseError, match="this is not a list with an entry 1; give the whole list, as in "):
        load_case(path, ["surface.1.sphere.radius=3"])


def test_the_rest_of_the_file_stays(path: Path) -> None:
    plain, changed = load_case(path), load_case(path, ["friction=0.2"])
    assert changed.effective() == plain.effective() | {"friction": {"coefficient": 0.2}}
    assert changed.source.locate(("friction",)) is None
    assert changed.source.locate(("grid",)) == 3


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("grid.points", "KEY=VALUE is needed, such as grid.points=64"),
        ("=3", "KEY=VALUE is needed, such as grid.points=64"),
        ("grid..points=3", "KEY=VALUE is needed, such as grid.points=64"),
        ("grid.points=", "grid.points: no value is given; KEY=VALUE is needed, such as grid.points=64"),
        ("grid.points=~", "grid.points: no value is given; give one or remove the key"),
        ("title='a", "title: not valid YAML: found unexpected end of stream, while scanning a quoted scalar"),
        (
            "grid={points: 1, points: 2}",
            "grid.points: duplicate key 'points', given first on line 1; keep one of the two",
        ),
        ("grid.ponts=3", "grid.ponts: unknown key 'ponts'; did you mean 'points'?"),
        ("grid.size=3 N", "grid.size: '3 N' is a force; a length such as '10 mm' is needed"),
        ("bodies.0={young_modulus: 1}", "bodies.0.poisson_ratio: missing; needed: Poisson's ratio, such as 0.3"),
        ("load_path.2.P=1", "load_path.2.P: the list has no entry 2; its entries are 0 to 1"),
        ("stages.1.Qx=3N", "stages.1.Qx: unknown key 'stages'; did you mean 'stage'?"),
        ("load_path.P=1", "load_path.P: the list has no entry 'P'; its entries are 0 to 1"),
        (
            "grid.points.0=1",
            "grid.points.0: this is not a list with an entry 0; give the whole list, as in grid.points=[64, 64]",
        ),
    ],
)
def test_mistake_names_the_override(path: Path, override: str, message: str) -> None:
    assert str(case_error(path, [override])) == f"override {override}: {message}"


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("bodies.0=rigid", "1: bodies: both bodies are rigid; at least one must be elastic"),
        ("load_path.0.delta_z=1", "5: stage.1: P and delta_z cannot be imposed at once; keep one of the two"),
        ("load_path.0.P.x=1", "5: stage.1.P: {x: 1} is not a force such as '400 N'"),
    ],
)
def test_mistake_around_an_override_names_both(path: Path, override: str, message: str) -> None:
    assert str(case_error(path, [override])) == f"{path}:{message} (with override {override})"


def test_problems_of_file_and_overrides_are_reported_together(path: Path) -> None:
    path.write_text(CASE.replace("radius: 1", "radius: 0"))
    assert str(case_error(path, ["friction=-1", "grid.points"])).split("\n") == [
        "override grid.points: KEY=VALUE is needed, such as grid.points=64",
        "override friction=-1: friction: -1 is out of range; a number >= 0 is needed",
        f"{path}:2: surface.sphere.radius: 0 is out of range; a length != 0 mm is needed",
    ]


def test_override_mends_the_file(path: Path) -> None:
    path.write_text(CASE.replace("radius: 1", "radius: 0"))
    assert load_case(path, ["surface.sphere.radius=-1"]).surface[0].kind == "sphere"


def test_unprintable_override_stays_on_one_line(path: Path) -> None:
    assert "\n" not in str(case_error(path, ["coupling=a\nb: c"]))


CYCLES = """\
  - {P: 1}
  - cycle: {times: 2, stages: [{Qx: 0.05}, {cycle: {times: 3, stages: [{Qy: 0.01}, {Qy: 0}]}}]}
  - {Qx: 0}
"""


@pytest.mark.parametrize(
    ("stage", "key"),
    [
        (1, ("load_path", 0)),
        (2, ("load_path", 1, "cycle", "stages", 0)),
        (3, ("load_path", 1, "cycle", "stages", 1, "cycle", "stages", 0)),
        (8, ("load_path", 1, "cycle", "stages", 1, "cycle", "stages", 1)),
        (9, ("load_path", 1, "cycle", "stages", 0)),
        (16, ("load_path", 2)),
    ],
)
def test_stages_are_counted_as_in_results(path: Path, stage: int, key: tuple[str | int, ...]) -> None:
    path.write_text(CASE.replace("load_path: [{P: 1}, {Qx: 2, increments: 3}]", f"load_path:\n{CYCLES}"))
    stages = load_case(path, [f"stage.{stage}.increments=7"]).stages()
    assert len(stages) == 16
    assert stages[stage - 1].key == key
    assert [found.increments == 7 for found in stages] == [found.key == key for found in stages]


@pytest.mark.parametrize("number", ["0", "3", "-1", "last"])
def test_a_stage_that_is_not_there(path: Path, number: str) -> None:
    with pytest.raises(CaseError, match=r"^override stage.*: the load path has no stage .*; its stages are 1 to 2$"):
        load_case(path, [f"stage.{number}.increments=7"])


@pytest.mark.parametrize(("stage", "cycle"), [(2, "load_path.1.cycle"), (3, "load_path.1.cycle.stages.1.cycle")])
def test_a_stage_within_a_cycle_names_the_cycle(path: Path, stage: int, cycle: str) -> None:
    path.write_text(CASE.replace("load_path: [{P: 1}, {Qx: 2, increments: 3}]", f"load_path:\n{CYCLES}"))
    within = f"stage {stage} is within a cycle; {cycle}.times is of the cycle"
    with pytest.raises(CaseError, match=re.escape(within)):
        load_case(path, [f"stage.{stage}.cycle.times=2"])


@pytest.mark.parametrize("every", ["stage.*", "load_path.*"])
def test_a_star_stands_for_every_stage(path: Path, every: str) -> None:
    assert [stage.increments for stage in load_case(path, [f"{every}.increments=7"]).stages()] == [7, 7]
    with pytest.raises(CaseError, match=r"\* stands for every stage, as in stage\.\*\.increments=20"):
        load_case(path, [f"{every}=7"])
