"""Files of stresses and fatigue parameters: damage is named, and what another result gave is not taken for its own."""

from __future__ import annotations

import errno
import os
import re
import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
from command_line import finish, invoke, refused, result_of
from small_cases import write_case

from fretsolve import open_result
from fretsolve.cli.commands import run
from fretsolve.cli.commands.computed_files import require_no_result
from fretsolve.errors import FileError
from fretsolve.post.crack.crack_file import read_crack
from fretsolve.post.fatigue.fatigue_file import read_worst
from fretsolve.post.stress.computed_file import is_made_from
from fretsolve.post.stress.stress_file import read_peaks
from fretsolve.result.header import HEADER
from fretsolve.system.files import FilledFile

CASE = """\
bodies: [{young_modulus: 70 GPa, poisson_ratio: 0.5}, {young_modulus: 70 GPa, poisson_ratio: 0.5}]
surface: {sphere: {radius: 10 mm}}
friction: 0.3
grid: {points: 16}
load_path:
  - {P: 100 N}
  - {cycle: {amplitude: {Qx: 15 N}, times: 1, increments: 8}}
output:
  stress: {every: 1, depths: [0, 40 um]}
  fatigue:
    criteria: [crossland, swt]
    depths: [0, 40 um]
    material: {tension_limit: 300 MPa, torsion_limit: 190 MPa}
"""
ENDINGS = ("h5", "stress.h5", "fatigue.h5")
WORDS = ("--material", "tension_limit=300MPa,torsion_limit=190MPa", "--criterion", "crossland", "-q", "--overwrite")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the case ``c.yaml`` and its three files."""
    return result_of(write_case(tmp_path_factory.mktemp("made"), CASE, "c.yaml")).parent


@pytest.fixture()
def folder(made: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(made, tmp_path / "c"))


def readers(folder: Path) -> tuple[tuple[object, ...], ...]:
    """Return the commands that read the files beside a result."""
    stress, parameters = folder / "c.stress.h5", folder / "c.fatigue.h5"
    return (
        ("fatigue", stress, *WORDS, "-o", folder / "f.h5"),
        ("export", stress, "--to", "vtk", "-o", folder / "s.pvd", "--overwrite"),
        ("export", parameters, "--to", "vtk", "-o", folder / "p.pvd", "--overwrite"),
        ("plot", folder / "c.h5", "fatigue-map", "-o", folder / "p.png"),
        ("run", folder / "c.yaml", "--resume", "-q"),
    )


@pytest.mark.slow
@pytest.mark.parametrize("ending", ENDINGS[1:])
def test_texts_of_attributes_are_not_read(folder: Path, ending: str) -> None:
    """They have no checksum, and zeros in them make HDF5 loop without end."""
    path = folder / f"c.{ending}"
    data = path.read_bytes()
    for match in re.finditer(b"GCOL", data):
        data = data[: match.start() + 16] + bytes(64) + data[match.start() + 80 :]
    path.write_bytes(data)
    for words in readers(folder):
        assert finish(*words)[0] == 0, words


def test_a_changed_case_in_the_header_is_found(folder: Path) -> None:
    path = folder / "c.stress.h5"
    with h5py.File(path, "r+") as file:
        text = file[HEADER][()].tobytes().replace(b"70000", b"60000", 1)
        del file[HEADER]
        file[HEADER] = np.frombuffer(text, np.uint8)
    for words in readers(folder)[:2]:
        assert "the checksum does not match" in refused(4, *words)


@pytest.mark.parametrize(
    ("name", "change"), [("crossland", None), ("crossland_utilisation", np.inf), ("swt_normal", np.nan)]
)
def test_parameters_that_are_missing_or_no_numbers(folder: Path, name: str, change: float | None) -> None:
    with h5py.File(folder / "c.fatigue.h5", "r+") as file:
        dataset = file[f"fatigue/body_2/{name}"]
        if change is None:
            del file[dataset.name]
        else:
            dataset[0, 0, 0] = change
    assert name in refused(4, *readers(folder)[2])


@pytest.mark.parametrize("ending", ENDINGS[1:])
def test_files_without_a_header_are_to_be_made_again(folder: Path, ending: str) -> None:
    with h5py.File(folder / f"c.{ending}", "r+") as file:
        del file["header"]
    line = refused(4, "export", folder / f"c.{ending}", "--to", "vtk", "-o", folder / "s.pvd")
    assert "makes it again" in line
    assert invoke("run", folder / "c.yaml", "-q", "--overwrite").exit_code == 0


def test_damage_is_not_taken_for_a_file_of_another_result(made: Path, tmp_path: Path) -> None:
    """Each kind of file is cut off; a file that was changed in its header is damaged, too."""
    shutil.copy(made / "c.h5", tmp_path)
    assert invoke("crack", tmp_path / "c.h5", "-q").exit_code == 0
    readers = {"stress": read_peaks, "fatigue": read_worst, "crack": read_crack}
    with open_result(tmp_path / "c.h5") as result:
        for kind, read in readers.items():
            path = tmp_path / f"c.{kind}.h5"
            if kind != "crack":
                shutil.copy(made / path.name, path)
            assert is_made_from(result, path)
            path.write_bytes(path.read_bytes()[:-100])
            assert not is_made_from(result, path)
            for of in (result, None):
                with pytest.raises(FileError, match="the file is truncated: it was not copied or written to its end"):
                    read(path, of)
            path.unlink()
            assert not is_made_from(result, path)
    (tmp_path / "c.crack.h5").write_text("mine")
    assert "not an HDF5 file" in refused(4, "plot", tmp_path / "c.h5", "crack", "-o", tmp_path / "x.png")


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["stress", "fatigue"])
def test_a_sweep_names_damaged_files_beside_results(made: Path, tmp_path: Path, kind: str) -> None:
    (tmp_path / "s.yaml").write_text("case: c.yaml\naxes: [friction: [0.3, 0.5]]\nquantities: [max_mises, swt_max]\n")
    (tmp_path / "c.yaml").write_text((made / "c.yaml").read_text().replace("points: 16", "points: 8"))
    assert invoke("sweep", "run", tmp_path / "s.yaml", "-q").exit_code == 0
    path = sorted((tmp_path / "s.sweep" / "results").glob(f"*.{kind}.h5"))[0]
    path.write_bytes(path.read_bytes()[:-100])
    again = invoke("sweep", "run", tmp_path / "s.yaml")
    assert again.exit_code == 4
    assert f"{path}: the file is truncated" in again.stderr and "; remove it to run the case again" in again.stderr
    assert "1 complete, 1 error" in again.stdout
    assert "1 complete, 1 error" in invoke("sweep", "collect", tmp_path / "s.sweep").stdout
    path.unlink()
    assert invoke("sweep", "run", tmp_path / "s.yaml", "-q").exit_code == 0


@pytest.mark.slow
def test_a_file_of_another_result_is_neither_read_nor_replaced(folder: Path) -> None:
    other = write_case(folder, CASE.replace("friction: 0.3", "friction: 0.5"))
    assert invoke("run", other, "-q").exit_code == 0
    for ending in ENDINGS[1:]:
        path = folder / f"c.{ending}"
        own = path.read_bytes()
        shutil.copy(folder / f"case.{ending}", path)
        before = path.read_bytes()
        assert "the run would replace it" in refused(2, "run", folder / "c.yaml", "--resume", "-q")
        assert path.read_bytes() == before
        path.write_bytes(own)


def test_a_link_that_leads_nowhere_is_not_replaced(folder: Path) -> None:
    (folder / "c.stress.h5").unlink()
    (folder / "c.stress.h5").symlink_to("nowhere.h5")
    assert "is a link to a file that does not exist" in refused(4, "run", folder / "c.yaml", "--resume", "-q")
    assert (folder / "c.stress.h5").readlink() == Path("nowhere.h5")


@pytest.mark.parametrize("ending", ENDINGS[1:])
@pytest.mark.slow
def test_a_file_made_during_a_resumed_run_is_not_replaced(
    folder: Path, ending: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for made in ENDINGS:
        (folder / f"c.{made}").unlink()
    path, solve = folder / f"c.{ending}", run.solve_missing

    def solve_and_write(*words: object, **options: object) -> bool:
        path.write_text("mine")
        return bool(solve(*words, **options))

    monkeypatch.setattr(run, "solve_missing", solve_and_write)
    done = invoke("run", folder / "c.yaml", "--resume", "-q")
    assert (done.exit_code, "another file has taken this name" in done.stderr) == (4, True)
    assert path.read_text() == "mine"
    assert (folder / "c.h5").exists()


@pytest.mark.slow
def test_exchanged_files_of_a_sweep_are_refused(folder: Path) -> None:
    (folder / "s.yaml").write_text("case: c.yaml\naxes:\n  - friction: [0.3, 0.5]\nquantities: [max_mises, swt_max]\n")
    assert invoke("sweep", "run", folder / "s.yaml").exit_code == 0
    results = folder / "s.sweep" / "results"
    one, other = sorted(results.glob("*.stress.h5"))
    one.rename(folder / "aside")
    other.rename(one)
    (folder / "aside").rename(other)
    assert "2 error" in invoke("sweep", "collect", folder / "s.sweep").output
    assert (folder / "s.sweep" / "table.csv").read_text().count("was not computed from") == 2


@pytest.mark.parametrize("kind", ["stress", "fatigue"])
@pytest.mark.parametrize("missing", ["", "/body_2"])
def test_a_missing_group_is_damage(folder: Path, kind: str, missing: str) -> None:
    path = folder / f"c.{kind}.h5"
    with h5py.File(path, "a") as file:
        del file[f"{kind}{missing}"]
    words = {"stress": "the stresses", "fatigue": "the parameters"}[kind]
    for line in (("export", path, "--to", "vtk"), ("run", folder / "c.yaml", "--resume", "-q")):
        assert refused(4, *line) == f"{path}: cannot read {words}: {(missing or kind).strip('/')} is missing\n"


def test_what_the_disk_does_not_tell_is_not_replaced(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It may be a result, which takes long to make again."""

    def fail(*_: object) -> int:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    require_no_result(folder / "c.stress.h5")
    monkeypatch.setattr(FilledFile, "readinto", fail)
    with pytest.raises(FileError, match=r"c\.stress\.h5: cannot read header: Input/output error"):
        require_no_result(folder / "c.stress.h5")
