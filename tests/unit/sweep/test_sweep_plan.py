"""The points of a sweep file, and what is wrong with one."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from command_line import invoke, refused
from small_cases import SPHERE, write_case
from sweeping import manifest_of, write_sweep

from fretsolve.case.loading import read_case, validated
from fretsolve.sweep import slurm
from fretsolve.sweep.plan import make_sweep_plan
from fretsolve.sweep.sweep_file import SlurmSpec, SweepSpec, points_of

# Points


def settings_of(folder: Path, axes: str) -> list[dict[str, str]]:
    """The points of `axes`, a YAML list."""
    text = read_case(write_sweep(folder, f"case: case.yaml\naxes:\n{axes}"))
    points = points_of(validated(SweepSpec, text.data, text.source), text.source)
    return [{value.name: value.text for value in point} for point in points]


@pytest.mark.parametrize(
    ("axis", "values"),
    [
        ("friction: [0.1, 1e-6, .5]", ["0.1", "1e-06", "0.5"]),
        ("load_path.0.P: [400 N, 1 kN]", ["400 N", "1 kN"]),
        ("title: ['1', 'a: b', x]", ['"1"', '"a: b"', "x"]),
        ("grid.points: [[8, 16], 32]", ["[8, 16]", "32"]),
        ("surface: [{sphere: {radius: 1 mm}}]", ['{"sphere": {"radius": "1 mm"}}']),
        ("friction: {from: 0.1, to: 0.3, count: 3}", ["0.1", "0.2", "0.3"]),
        ("load_path.0.P: {from: 1 kN, to: 4 kN, count: 4}", ["1 kN", "2 kN", "3 kN", "4 kN"]),
        ("load_path.0.P: {from: 1 N, to: 100 N, count: 3, spacing: log}", ["1 N", "10 N", "100 N"]),
        ("friction: {from: 0.3, to: 0.1, count: 2}", ["0.3", "0.1"]),
    ],
)
def test_values_of_a_key(axis: str, values: list[str], tmp_path: Path) -> None:
    points = settings_of(tmp_path, f"  - {axis}")
    assert points == [{axis.partition(":")[0]: value} for value in values]


def test_entries_are_crossed_and_keys_of_one_go_together(tmp_path: Path) -> None:
    points = settings_of(tmp_path, "  - {friction: [0.1, 0.2], title: [a, b]}\n  - grid.points: [8, 16]")
    found = [" ".join(point.values()) for point in points]
    assert found == ["0.1 a 8", "0.1 a 16", "0.2 b 8", "0.2 b 16"]


def test_points_of_a_csv_file(tmp_path: Path) -> None:
    (tmp_path / "points.csv").write_text('friction, load_path.0.P\n0.1,400 N\n\n,"500 N"\n')
    assert settings_of(tmp_path, "  - csv: points.csv") == [
        {"friction": "0.1", "load_path.0.P": "400 N"},
        {"load_path.0.P": "500 N"},
    ]


def test_latin_hypercube_has_one_point_in_each_slice(tmp_path: Path) -> None:
    axes = """\
  - latin_hypercube:
      samples: 20
      seed: 3
      over:
        friction: {from: 0.1, to: 0.5}
        load_path.0.P: {from: 1 N, to: 1000 N, spacing: log}
"""
    points = settings_of(tmp_path, axes)
    friction = np.array([float(point["friction"]) for point in points])
    load = np.array([float(point["load_path.0.P"].removesuffix(" N")) for point in points])
    slices = np.arange(20)
    np.testing.assert_array_equal(np.sort((friction - 0.1) / 0.4 * 20 // 1), slices)
    np.testing.assert_array_equal(np.sort(np.log10(load) / 3 * 20 // 1), slices)
    assert settings_of(tmp_path, axes) == points
    assert settings_of(tmp_path, axes.replace("seed: 3", "seed: 4")) != points


BASE = "case: case.yaml\n"


AXIS = f"{BASE}axes:\n  - "


@pytest.mark.parametrize(
    ("sweep", "message"),
    [
        ("", "sweep.yaml:1: the file is empty; one with the keys case, axes is needed"),
        (BASE, "sweep.yaml:1: axes: missing"),
        ("case: none.yaml\naxes: [friction: [1]]", "sweep.yaml:1: case: .*none.yaml: cannot be read"),
        (BASE + "axis: [friction: [1]]", "sweep.yaml:2: axis: unknown key 'axis'; did you mean 'axes'"),
        (BASE + "axes: []", r"sweep.yaml:2: axes: \[\] has the wrong number of entries"),
        (AXIS + "friction: 0.1", "sweep.yaml:3: axes.0.friction: 0.1 is not allowed; a list"),
        (AXIS + "friction: []", r"^\S+sweep.yaml:3: axes.0.friction: \[\] has the wrong number of entries; at .*\n$"),
        (AXIS + "fricton: [1]", ":3: axes.0.fricton.0: unknown key 'fricton'; did you"),
        (AXIS + "friction:\n    - 0.1\n    - -1", ":5: axes.0.friction.1: -1 is out of"),
        (AXIS + "load_path.7.P: [1]", ":3: axes.0.load_path.7.P.0: the list has no entry"),
        (AXIS + "bodies.*.young_modulus: [1]", r":3: axes.0.bodies.\*.young_modulus.0: \* stands"),
        (AXIS + "a=b: [1]", "sweep.yaml:3: axes.0.a=b.0: 'a=b' is not a key of a case"),
        (AXIS + "{friction: [1, 2], title: [a]}", ":3: axes.0: keys of one entry .* title has 1"),
        (AXIS + "friction: [1]\n  - friction: [2]", ":4: axes.1.friction.0: the key is varied twice"),
        (
            AXIS + "load_path.0.P: [1, 2]\n  - {title: [a, b], stage.1.P: [2, 3]}",
            r":4: axes.1.stage.1.P.0: load_path.0.P and stage.1.P are the same key; keep one of the two\n$",
        ),
        (AXIS + "stage.1.P: [1 m]", ":3: axes.0.stage.1.P.0: '1 m' is a length; a force"),
        (AXIS + "load_path.0.P: [1 m]", ":3: axes.0.load_path.0.P.0: '1 m' is a length; a force"),
        (AXIS + "stage.*.P: [1 m]", r":3: axes.0.stage.\*.P.0: '1 m' is a length; a force"),
        (AXIS + "load_path: [[{P: 1 m}]]", ":3: axes.0.load_path.0.stage.1.P: '1 m' is a length; a force"),
        (AXIS + "friction: {from: 1, to: 2}", "sweep.yaml:3: axes.0.friction.count: missing; needed: how many"),
        (AXIS + "load_path.0.P: {from: 1 N, to: 2 kN, count: 3}", ":3: axes.0.load_path.0.P: from is in N, to in kN"),
        (AXIS + "friction: {from: 0, to: 1, count: 3, spacing: log}", "axes.0.friction: log spacing needs two ends"),
        (AXIS + "friction: {from: a, to: 1, count: 3}", ":3: axes.0.friction: 'a' is not a number with a unit or"),
        (AXIS + "friction: {from: 1, to: 1, count: 3}", ": from and to are both 1"),
        (AXIS + "csv: none.csv", "none.csv: cannot be read: No such file"),
        (AXIS + "grid.points: [8, 1000000]", ":3: axes.0.grid.points.1: 1000000 x 1000000 cells take about .* of"),
        (BASE + "set: {friction: -1}\naxes:\n  - title: [a]", "sweep.yaml:2: set.friction: -1 is out of"),
        (BASE + "quantities: [delta]\naxes:\n  - title: [a]", ":2: quantities.0: 'delta' is not a quantity"),
        (BASE + "quantities: [P@9]\naxes:\n  - title: [a]", ":2: quantities.0: there is no stage '9'"),
        (BASE + "slurm: {options: [main]}\naxes:\n  - title: [a]", ":2: slurm.options.0: 'main' is not"),
    ],
)
def test_mistakes_are_told_with_their_place(sweep: str, message: str, tmp_path: Path) -> None:
    path = write_sweep(tmp_path, sweep)
    outcome = invoke("sweep", "run", path)
    assert outcome.exit_code == (4 if "none.csv" in sweep else 2), outcome.stderr
    assert re.search(message, outcome.stderr), outcome.stderr
    assert not (tmp_path / "sweep.sweep").exists()


def test_case_and_sweep_are_told_apart(tmp_path: Path) -> None:
    path = write_sweep(tmp_path)
    told = f"{path}:1: this is a sweep file; `fretsolve sweep run` takes it\n"
    for words in (("run",), ("validate",), ("check",), ("study", "--vary", "grid.points=8")):
        assert refused(2, *words, path) == told
    case = tmp_path / "case.yaml"
    told = f"{case}:1: this is a case file; `fretsolve run` takes it, a sweep file names it as `case`\n"
    assert refused(2, "sweep", "run", case) == told


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("friction\n", ":3: axes.0.csv: points.csv has no points"),
        ("friction,friction\n1,2\n", "points.csv:1: 'friction' is not a key of a case, or stands twice"),
        ("friction,title\n0.1\n", "points.csv:2: the line has 1 cells, the heading 2"),
        ("friction,title\n0.1,a\n-3,b\n", "points.csv:3: friction: -3 is out of range"),
    ],
)
def test_mistakes_in_a_csv_file(text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "points.csv").write_text(text)
    path = write_sweep(tmp_path, "case: case.yaml\naxes:\n  - csv: points.csv\n")
    assert message in refused(2, "sweep", "run", path)


def test_each_mistake_is_told_once_and_not_too_many(tmp_path: Path) -> None:
    bad = ", ".join(str(-index) for index in range(1, 30))
    path = write_sweep(tmp_path, f"case: case.yaml\naxes:\n  - friction: [{bad}]\n  - title: [a, b]\n")
    lines = invoke("sweep", "run", path).stderr.splitlines()
    assert len(lines) == 11
    assert lines[-1].endswith("and 19 more problems")


def test_what_is_no_sweep(tmp_path: Path) -> None:
    for command in ("status", "collect"):
        assert "manifest.json: cannot be read: No such file" in refused(4, "sweep", command, tmp_path)
    (tmp_path / "manifest.json").write_text("{}")
    assert "not the manifest of a sweep" in invoke("sweep", "status", tmp_path).stderr


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("run", "x.yaml", "--on", "cloud"), "'cloud' is not an engine; local, slurm or dask:ADDRESS is needed"),
        (("work", ".", "--cases", "3-"), "'3-' is not a list of cases"),
        (("work", ".", "--cases", "9-3"), "'9-3' is not a range of cases"),
        (("work", ".", "--cases", "0-999999999"), "'0-999999999' is not a range of cases"),
        (("run", "none.yaml"), "none.yaml: cannot be read"),
    ],
)
def test_mistakes_on_the_command_line(words: tuple[str, ...], message: str) -> None:
    assert message in refused(4 if "none.yaml" in words else 2, "sweep", *words)


@pytest.mark.parametrize(("task", "cases"), [(0, "0-3"), (1, "4-5")])
def test_tasks_of_slurm_name_cases_that_exist(task: int, cases: str, tmp_path: Path) -> None:
    script = slurm.script_text(manifest_of(tmp_path), SlurmSpec(cases_per_task=4)).replace("exec ", "echo ")
    environment = {"SLURM_ARRAY_TASK_ID": str(task)}
    told = subprocess.run(["bash", "-c", script], env=environment, capture_output=True, text=True, check=True).stdout
    assert told.endswith(f" --cases {cases} --requeue\n")


@pytest.mark.parametrize(("text", "message"), [("", "the file is empty"), ("- 1\n", "does not hold a mapping")])
def test_a_case_file_that_holds_no_case(tmp_path: Path, text: str, message: str) -> None:
    path = write_sweep(tmp_path, "case: case.yaml\nset: {grid.points: 8}\naxes: [friction: [0.1]]\n", text)
    assert message in refused(2, "sweep", "run", path)


def test_results_beyond_the_disk_are_warned_of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, folder = write_sweep(tmp_path), tmp_path / "sweep.sweep"
    assert make_sweep_plan(path, folder).warnings == ()
    monkeypatch.setattr("fretsolve.sweep.plan.free_bytes", lambda out: 500_000)
    (warning,) = make_sweep_plan(path, folder).warnings
    assert re.match(r"results of about 6\d\d kB are missing, 500 kB are free on the disk of ", warning)


def test_cases_keep_their_names_from_version_to_version(tmp_path: Path) -> None:
    """With other names every case of a folder would be solved again. A new version of the program changes them."""
    write_case(tmp_path, SPHERE + "load_path:\n  - {P: 400 N}\n")
    sweep = write_case(tmp_path, "case: case.yaml\naxes:\n  - friction: [0.1, 0.2]\n", "sweep.yaml")
    plan = make_sweep_plan(sweep, tmp_path / "sweep")
    assert [row.id for row in plan.manifest.rows] == ["ec42314f64c09485", "1c4491481b67220a"]
