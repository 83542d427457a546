"""Sweeps and studies write, replace and remove nothing but their own."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from command_line import invoke, refused
from small_cases import SWEPT, write_case
from sweeping import manifest_of, rows_of, write_sweep

from fretsolve.sweep.beginnings import FOLDER_NAME, remove_beginnings

TEXT = "the user's own\n"


@pytest.fixture(scope="module")
def sweep(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return manifest_of(tmp_path_factory.mktemp("sweep")).folder


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("id", "../../x"),
        ("id", "/etc/passwd"),
        ("id", "0123456789abcdef\n"),
        ("index", 7),
        ("settings", None),
        ("seconds", "long"),
    ],
)
@pytest.mark.parametrize("words", [("status",), ("work", "--cases", "0")])
def test_a_manifest_cannot_lead_elsewhere(
    sweep: Path, tmp_path: Path, key: str, value: object, words: tuple[str, ...]
) -> None:
    folder = tmp_path / "deep" / "er"
    shutil.copytree(sweep, folder)
    manifest = json.loads((folder / "manifest.json").read_text())
    manifest["cases"][0][key] = value
    (folder / "manifest.json").write_text(json.dumps(manifest))
    before = sorted(tmp_path.rglob("*"))
    line = refused(4, "sweep", words[0], folder, *words[1:])
    assert line.startswith(f"{folder / 'manifest.json'}: not the manifest of a sweep: ")
    assert sorted(tmp_path.rglob("*")) == before


def test_a_sweep_leaves_what_it_has_not_written(tmp_path: Path) -> None:
    path, folder = write_sweep(tmp_path), tmp_path / "web"
    folder.mkdir()
    (folder / ".hidden").touch()
    for name, content in {"manifest.json": '{"name": "web"}', "results/mine.txt": "mine", "mine.txt": "mine"}.items():
        own = folder / name
        own.parent.mkdir(exist_ok=True)
        own.write_text(content)
        line = refused(4, "sweep", "run", path, "-o", folder)
        assert line.startswith(f"{own if name == 'manifest.json' else own.parent}: ")
        assert name == "manifest.json" or "holds mine.txt, which no sweep has written" in line
        assert not (folder / "manifest.json").exists() or name == "manifest.json"
        assert "give another folder with -o" in line
        assert own.read_text() == content
        own.unlink()
    (folder / "results").rmdir()
    (folder / "results").symlink_to(tmp_path)
    assert "is a link, which a sweep does not follow" in refused(4, "sweep", "run", path, "-o", folder)
    assert sorted(folder.iterdir()) == [folder / ".hidden", folder / "results"]


@pytest.mark.parametrize("name", ["results", FOLDER_NAME])
def test_no_task_of_a_sweep_writes_through_a_link(tmp_path: Path, name: str) -> None:
    manifest, target = manifest_of(tmp_path), tmp_path / "mine"
    target.mkdir()
    (target / "notes.txt").write_text(TEXT)
    if (manifest.folder / name).exists():
        (manifest.folder / name).rmdir()
    (manifest.folder / name).symlink_to(target)
    for words in (("work", manifest.folder, "--cases", "0"), ("run", tmp_path / "sweep.yaml")):
        line = refused(4, "sweep", *words)
        assert line.startswith(f"{manifest.folder / name}: is a link, which a sweep does not follow")
    assert list(target.iterdir()) == [target / "notes.txt"]


def test_a_study_leaves_what_it_has_not_written(tmp_path: Path) -> None:
    case, folder = write_case(tmp_path, SWEPT), tmp_path / "mine"
    words = ("study", case, "--vary", "grid.points=8,10", "--quantity", "delta_x", "-q", "-o", folder)
    folder.mkdir()
    (folder / "notes.txt").write_text(TEXT)
    line = refused(4, *words)
    assert line.startswith(f"{folder}: holds notes.txt, which no study has written; give another folder with -o, one")
    assert list(folder.iterdir()) == [folder / "notes.txt"]
    (folder / "notes.txt").unlink()
    assert invoke(*words).exit_code == 0
    (folder / "notes.txt").write_text(TEXT)  # beside a study's own table
    assert invoke(*words).exit_code == 0
    before = {path: path.read_bytes() for path in folder.iterdir()}
    for name in ("study.csv", "study.h5", "study.png"):
        (folder / name).write_text(TEXT)
        assert f"{folder / name}: is not " in refused(4, *words)
        assert (folder / name).read_text() == TEXT
        (folder / name).write_bytes(before[folder / name])
    assert {path: path.read_bytes() for path in folder.iterdir()} == before
    first, second = sorted(path for path in folder.glob("*.h5") if path.name != "study.h5")
    shutil.copy(second, first)
    assert refused(4, *words) == f"{first}: is the result of another case; remove it to run the case again\n"


@pytest.mark.parametrize("name", ["table.csv", "table.h5"])
def test_collecting_leaves_other_tables(sweep: Path, tmp_path: Path, name: str) -> None:
    folder = tmp_path / "copy"
    shutil.copytree(sweep, folder)
    assert invoke("sweep", "collect", folder).exit_code == 0
    assert invoke("sweep", "collect", folder).exit_code == 0  # its own are replaced
    (folder / name).write_text("my,own,table\n")
    line = refused(4, "sweep", "collect", folder)
    assert line.startswith(f"{folder / name}: is not the table of a sweep")
    assert (folder / name).read_text() == "my,own,table\n"


def test_only_beginnings_are_removed(tmp_path: Path) -> None:
    folder = tmp_path / FOLDER_NAME
    folder.mkdir()
    for name in ("0123456789abcdef.h5", "fedcba9876543210.h5", "notes.h5"):
        (folder / name).touch()
    remove_beginnings(tmp_path)
    assert [path.name for path in folder.iterdir()] == ["notes.h5"]
    folder.rename(tmp_path / "mine")
    (tmp_path / "mine" / "0123456789abcdef.h5").touch()
    folder.symlink_to(tmp_path / "mine")
    remove_beginnings(tmp_path)
    assert len(list((tmp_path / "mine").iterdir())) == 2
    folder.unlink()
    folder.mkdir()
    (folder / "0123456789abcdef.h5").touch()
    remove_beginnings(tmp_path)
    assert not folder.exists()


@pytest.mark.slow
def test_results_of_other_cases_of_a_sweep(tmp_path: Path) -> None:
    path = write_sweep(tmp_path, "case: case.yaml\naxes: [friction: [0.1, 0.12]]\n")
    assert invoke("sweep", "run", path, "-q").exit_code == 0
    folder = path.with_suffix(".sweep")
    first, second = (folder / row["result"] for row in rows_of(folder))
    shutil.copy(second, first)
    assert invoke("sweep", "status", folder).stdout.count(f"{first}: is the result of another case") == 1
    result = invoke("sweep", "collect", folder)
    assert (result.exit_code, "1 complete, 1 error" in result.stdout) == (0, True)
    line = refused(4, "sweep", "run", path, "-q")
    assert line.endswith(f"{first}: is the result of another case; remove it to run the case again\n")
    first.unlink()
    assert invoke("sweep", "run", path, "-q").exit_code == 0
