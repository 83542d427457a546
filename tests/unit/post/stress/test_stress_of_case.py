"""Stresses that a case asks for, at the end of its run, in sweeps and studies."""

from __future__ import annotations

import json
from pathlib import Path

import h5py
import pytest
from command_line import invoke, refused
from small_cases import CYCLES_UNDER_BULK

from fretsolve import open_result


def test_a_case_asks_for_stresses(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """They are written at the end of the run, again if they are missing, and refused before it if too large."""
    case = tmp_path / "c.yaml"
    case.write_text(
        CYCLES_UNDER_BULK.replace("points: 24", "points: 12") + "output: {stress: {depths: [0 mm, 50 um], every: 2}}\n"
    )
    done = invoke("run", case)
    assert done.exit_code == 0, done.stderr
    assert "body 2, 2 depths, 5 increments" in done.stdout
    with h5py.File(tmp_path / "c.stress.h5") as file:
        assert file["stress/body_2/step"][:].tolist() == [1, 3, 5, 7, 8]
    (tmp_path / "c.stress.h5").unlink()
    assert invoke("run", case, "--resume", "-q").exit_code == 0
    assert (tmp_path / "c.stress.h5").exists()
    with open_result(tmp_path / "c.h5") as result:
        assert json.loads(result.attributes["effective_case"])["output"]["stress"]["every"] == 2
    monkeypatch.setattr("fretsolve.cli.commands.side_outputs.free_bytes", lambda path: 1000)
    message = refused(2, "run", case, "--overwrite")
    assert "the file of stresses takes up to" in message
    assert "output.stress" in message
    assert "a larger every" in message
    assert "--plane" not in message
    assert (tmp_path / "c.h5").exists()


@pytest.mark.parametrize("kind", ["stress", "fatigue"])
def test_a_disk_that_is_full_at_the_end_of_a_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str) -> None:
    """The result is kept, and --resume writes the rest once there is room."""
    case, material = tmp_path / "c.yaml", "{tension_limit: 300 MPa, torsion_limit: 190 MPa}"
    asked = {
        "stress": "depths: [0 mm, 50 um]",
        "fatigue": f"material: {material}, criteria: [crossland], depths: [0 mm]",
    }
    case.write_text(CYCLES_UNDER_BULK.replace("points: 24", "points: 12") + f"output: {{{kind}: {{{asked[kind]}}}}}\n")
    with monkeypatch.context() as full:
        full.setattr("fretsolve.cli.commands.stress.free_bytes", lambda path: 1000)
        done = invoke("run", case, "-q")
        message = done.stderr.splitlines()[-1]
        assert done.exit_code == 4
        assert "1 kB are free on its disk; the result is whole: with more room --resume writes" in message
        assert message.endswith(f"what output.{kind} asks for")
        assert sorted(path.name for path in tmp_path.iterdir()) == ["c.h5", "c.yaml"]
        given = () if kind == "stress" else ("--material", "tension_limit=300MPa,torsion_limit=190MPa", "--criterion")
        message = refused(4, kind, tmp_path / "c.h5", *given, *(["crossland"] if given else []))
        assert ("--plane" if kind == "stress" else "fewer depths or bodies") in message
    assert invoke("run", case, "--resume", "-q").exit_code == 0
    assert (tmp_path / f"c.{kind}.h5").exists()


@pytest.mark.parametrize(
    ("stress", "message"),
    [
        ("{bodies: [3]}", "output.stress.bodies.0"),
        ("{depths: [-1 um]}", "a length >= 0 mm is needed"),
        ("{depths: [1 um, 1 um]}", "is named twice"),
        ("{every: 0}", "output.stress.every"),
        ("{window: none}", "output.stress.window"),
        ("{components: [zx]}", "output.stress.components.0"),
    ],
)
def test_mistakes_in_the_keys(tmp_path: Path, stress: str, message: str) -> None:
    (tmp_path / "c.yaml").write_text(CYCLES_UNDER_BULK + f"output: {{stress: {stress}}}\n")
    assert message in refused(2, "run", tmp_path / "c.yaml")


def test_keys_that_do_not_fit(tmp_path: Path) -> None:
    (tmp_path / "c.yaml").write_text(CYCLES_UNDER_BULK + "output: {stress: {bodies: [1]}}\n")
    rigid = "bodies=[rigid, {young_modulus: 70 GPa, poisson_ratio: 0.5}]"
    assert "body 1 is rigid" in refused(2, "run", tmp_path / "c.yaml", "--set", rigid)
    without = ("--set", "output.fields=[pressure]")
    assert "output.fields needs shear" in refused(2, "run", tmp_path / "c.yaml", *without)
