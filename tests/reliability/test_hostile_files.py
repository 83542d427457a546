"""Files that would hang a reader, show what lies elsewhere, or pass for what they are not, end in exit code 4."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import zipfile
import zlib
from pathlib import Path

import h5py
import numpy as np
import pytest
from command_line import environment, invoke, refused
from fake_states import fake_header, fake_states, write_fake
from small_cases import CASE, write_case

from fretsolve.errors import FileError
from fretsolve.problem.surface.files import text_map
from fretsolve.result import HistoryWriter, parts
from fretsolve.result.parts import parts_folder
from fretsolve.system import files, hdf5_files


@pytest.fixture()
def out(tmp_path: Path) -> Path:
    return write_fake(tmp_path / "out.h5", shape=(7, 6))


def heaps(data: bytes) -> list[int]:
    """Return where the texts of attributes begin, which HDF5 keeps in global heaps without a checksum."""
    found = [match.start() for match in re.finditer(b"GCOL", data)]
    assert found
    return found


@pytest.mark.slow
def test_attributes_of_a_map_that_hang_hdf5(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hdf5_files, "TRIAL_SECONDS", 1)
    case = heights_case(out.parent, out.name, ", dataset: fields/x")
    data, met = out.read_bytes(), set()
    for at in range(16, 80, 16):
        start = heaps(data)[0] + at
        out.write_bytes(data[:start] + bytes(64) + data[start + 64 :])
        met.add(refused(4, "validate", case).rpartition(f"{out}: ")[2])
    assert "is damaged: the HDF5 library cannot read its attributes\n" in met


def test_no_module_of_the_working_folder_is_run(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(out.parent)
    for module in ("h5py", "resource", "sitecustomize"):
        Path(f"{module}.py").write_text(f"open('run-{module}', 'w')\n")
    hdf5_files.try_attributes(Path(out.name))
    assert not list(out.parent.glob("run-*"))


def test_columns_that_another_version_adds_are_no_damage(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = invoke("show", out, "--all").stdout
    with h5py.File(out, "r+") as file:
        file["history/new"] = file["history/P"][:]
    assert invoke("show", out, "--all").stdout == before
    shown = parts.content_of
    later = lambda *content: {**shown(*content), "columns": {**shown(*content)["columns"], "new": "0" * 16}}  # noqa: E731
    monkeypatch.setattr(parts, "content_of", later)
    assert invoke("show", write_fake(out.with_name("later.h5"), shape=(7, 6)), "--all").stdout == before


@pytest.mark.parametrize("name", ["P", "x", "step"])
def test_numbers_that_another_program_has_changed(out: Path, name: str) -> None:
    with h5py.File(out, "r+") as file:
        file[f"{'fields' if name in ('x', 'step') else 'history'}/{name}"][0] -= 1
    named = "step of fields" if name == "step" else name
    assert f"{named} was changed: it differs from the header" in refused(4, "show", out)


def begin(out: Path, increments: int, shape: tuple[int, int] = (6, 5)) -> Path:
    """Save increments in one part, and return that."""
    with HistoryWriter.open(out, fake_header(shape, increments=8), pause=1e9) as run:
        for state in fake_states(increments, shape=shape):
            run.append(state)
        run.save()
    (part,) = parts_folder(out).glob("*.h5")
    return part


def test_parts_whose_fields_are_of_other_increments(tmp_path: Path) -> None:
    """Another program that writes these numbers anew gives them a right checksum, or none."""
    out = tmp_path / "out.h5"
    part = begin(out, 4)
    for steps in ([0, 1, 66, 3], [0, 2, 1, 3], [0, 1, 3], [0, 1, 2, 67], []):
        with h5py.File(part, "r+") as file:
            del file["fields/step"]
            file["fields/step"] = np.array(steps, "int64")
        message = "fields/step must hold the increments that are stored"
        with pytest.raises(FileError, match=message):
            HistoryWriter.open(out, fake_header(increments=8), resume=True)
        assert invoke("show", out).exit_code == 4
    with h5py.File(part, "r+") as file:
        del file["fields/step"]
        file["fields/step"] = np.arange(4)
    with HistoryWriter.open(out, fake_header(increments=8), resume=True) as run:
        assert (len(run.summaries), run.notes) == (4, [])


def test_a_header_that_was_altered(tmp_path: Path) -> None:
    out = write_fake(tmp_path / "out.h5", "stopped")
    header = parts_folder(out) / "header.json"
    text = header.read_text()
    header.write_text(text.replace("400.0", "300.0"))
    assert "the checksum does not match" in refused(4, "show", out)
    header.write_bytes(text.encode("utf-16"))
    assert "not the header of a run: byte 0 is not UTF-8 text" in refused(4, "show", out)
    header.write_text("[" * 100_000)
    assert "not the header of a run" in refused(4, "show", out)
    kept = {name: value for name, value in json.loads(text).items() if name != "sha256"}
    header.write_text(json.dumps(kept))
    assert "the checksum does not match" in refused(4, "show", out)


def heights_case(folder: Path, name: str, more: str = "") -> Path:
    spec = f"{{file: {name}, unit: um, spacing: 1 um{more}}}"
    return write_case(folder, CASE.replace("{sphere: {radius: 10 mm}}", f"{{heights: {spec}}}"))


@pytest.mark.parametrize("name", ["map.txt", "map.npy", "map.npz", "map.h5"])
def test_only_regular_files_are_maps(tmp_path: Path, name: str) -> None:
    case = heights_case(tmp_path, name, ", dataset: z" if name == "map.h5" else "")
    os.mkfifo(tmp_path / name)
    assert "is not a regular file, but a pipe, a socket or a device; it is not read" in refused(4, "validate", case)
    assert "is not a regular file" in refused(4, "run", case)
    (tmp_path / name).unlink()
    (tmp_path / name).symlink_to("/dev/zero")
    assert "is not a regular file" in refused(4, "validate", case)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["case.yaml", name]


@pytest.mark.parametrize("silent", [False, True])
@pytest.mark.slow
def test_a_pipe_that_gives_no_text(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, silent: bool) -> None:
    monkeypatch.setattr(files, "PIPE_SECONDS", 0.2)
    pipe, out = tmp_path / "pipe.yaml", write_fake(tmp_path / "out.h5")
    os.mkfifo(pipe)
    line = f"{pipe}: is a pipe that nobody has closed within 0.2 s\n"
    writer = os.open(pipe, os.O_RDWR) if silent else None
    for words in (("validate",), ("run",), ("check",), ("fatigue", out, "--criterion", "swt", "--material")):
        assert line in refused(4, *words, pipe)
    if writer is not None:
        os.write(writer, b"title: begun\n")
        assert refused(4, "validate", pipe) == line
        os.close(writer)


@pytest.mark.parametrize("name", ["/dev/zero", "/dev/null", "pipe"])
def test_what_is_no_case(tmp_path: Path, name: str) -> None:
    """A device anywhere; a pipe where its text is read again, or where a file names it."""
    path, case = tmp_path / name, write_case(tmp_path)
    if name == "pipe":
        os.mkfifo(path)
    else:
        assert refused(4, "validate", path) == f"{path}: {NOT_REGULAR}\n"
        assert refused(4, "sweep", "run", path, "-o", tmp_path / "s") == f"{path}: {NOT_REGULAR}\n"
    assert refused(4, "study", path, "--vary", "grid.points=8,16", "-o", tmp_path / "s") == f"{path}: {NOT_REGULAR}\n"
    sweep = tmp_path / "sweep.yaml"
    sweep.write_text(f"case: {path}\naxes:\n  - friction: [0.1, 0.2]\n")
    assert refused(2, "sweep", "run", sweep).endswith(f"case: {path}: {NOT_REGULAR}\n")
    beside = f"output: {{fatigue: {{material: {path}, criteria: [swt]}}}}\n"
    case.write_text(CASE + beside)
    assert refused(2, "validate", case).endswith(f"output.fatigue.material: {path}: {NOT_REGULAR}\n")


NOT_REGULAR = "is not a regular file, but a pipe, a socket or a device; it is not read"


def test_a_case_from_a_pipe(tmp_path: Path) -> None:
    case = write_case(tmp_path)
    line = ["bash", "-c", f"{sys.executable} -m fretsolve validate <(sleep 1; cat {case})"]
    done = subprocess.run(line, env=environment(), capture_output=True, text=True, check=True)
    assert "# load path of 5 increments" in done.stdout


def test_maps_of_no_plausible_size(tmp_path: Path) -> None:
    case = heights_case(tmp_path, "map.h5", ", dataset: z")
    with h5py.File(tmp_path / "map.h5", "w") as file:
        file.create_dataset("z", (26000, 26000), "f8", chunks=(1000, 1000))
    assert "is not in the file" in refused(4, "validate", case)
    case = heights_case(tmp_path, "map.npy")
    with (tmp_path / "map.npy").open("wb") as file:
        np.lib.format.write_array_header_1_0(file, {"descr": "<f8", "fortran_order": False, "shape": (26000, 26000)})
        file.truncate(128 + 8 * 26000**2)
    assert "it has 26000 x 26000 heights, at most" in refused(4, "validate", case)
    case = heights_case(tmp_path, "map.txt")
    with (tmp_path / "map.txt").open("wb") as file:
        file.truncate(10**11)
    assert "has 100000000000 bytes; at most" in refused(4, "validate", case)


def zeros(file: h5py.File, name: str, count: int, dtype: str = "f8") -> None:
    """Store so many compressed zeros, without making them."""
    each = 2**22
    dataset = file.create_dataset(name, (count,), dtype, chunks=(each,), compression="gzip", compression_opts=9)
    block = zlib.compress(np.zeros(each, dtype).tobytes(), 9)
    for start in range(0, count, each):
        dataset.id.write_direct_chunk((start,), block)


@pytest.mark.parametrize(("name", "dtype"), [("history/P", "f8"), ("fields/step", "i8")])
def test_columns_of_compressed_zeros(out: Path, name: str, dtype: str) -> None:
    with h5py.File(out, "r+") as file:
        del file[name]
        zeros(file, name, 2**27, dtype)
    line = refused(4, "show", out)
    assert "bytes, far more than there are in the file" in line or "as many numbers in each column" in line


@pytest.mark.slow
def test_maps_of_compressed_zeros(tmp_path: Path) -> None:
    case = heights_case(tmp_path, "map.h5", ", dataset: z")
    with h5py.File(tmp_path / "map.h5", "w") as file:
        zeros(file, "z", 2**27)
    assert "heights, at most" in refused(4, "validate", case)
    case = heights_case(tmp_path, "map.npz")
    archive = zipfile.ZipFile(tmp_path / "map.npz", "w", zipfile.ZIP_DEFLATED)
    with archive, archive.open("z.npy", "w", force_zip64=True) as member:
        for _ in range(65):
            member.write(bytes(2**24))
    assert "the height map cannot be read" in refused(4, "validate", case)


def test_maps_in_nested_groups(tmp_path: Path) -> None:
    case = heights_case(tmp_path, "map.h5", ", dataset: z")
    with h5py.File(tmp_path / "map.h5", "w") as file:
        group = file.create_group("a")
        for _ in range(500):
            group = group.create_group("a")
        file["z"] = np.zeros((2, 2))
    assert "64 groups within one another" in refused(4, "validate", case)


@pytest.mark.parametrize(("command", "height"), [("validate", "1e308"), ("run", "-1e308"), ("validate", "1e50")])
def test_maps_of_impossible_heights(tmp_path: Path, command: str, height: str) -> None:
    (tmp_path / "map.txt").write_text(f"0 0 0 0\n0 {height} 0 0\n0 0 0 0\n")
    line = refused(2, command, heights_case(tmp_path, "map.txt"))
    assert f"holds a height of {abs(float(height)) / 1e3:.2g} mm, at most 1e+40 mm is possible; write nan for" in line


def test_steep_maps_are_named(tmp_path: Path) -> None:
    x = np.arange(-5.0, 6.0)
    heights = (x[:, None] ** 2 + x**2) / 100.0
    case = heights_case(tmp_path, "map.txt")
    case.write_text(case.read_text().replace("points: 16", "points: 16, size: 10 um"))
    for lowest, warned in ((0.0, False), (-9.4, True), (np.nan, False)):
        heights[:2, :2] = lowest
        np.savetxt(tmp_path / "map.txt", heights)
        result = invoke("validate", case)
        assert result.exit_code == 0
        assert ("hold for slopes small against 1; are unit and spacing right" in result.stderr) is warned
    heights[0, 0] = -32768.0  # how programs write lost points
    np.savetxt(tmp_path / "map.txt", heights)
    assert "range over 32.7685 mm on a map of 10 um; give their unit" in refused(2, "validate", case)


SECRET = np.arange(100.0, 142.0)


def lead_away(path: Path, name: str, how: str) -> None:
    """Replace a dataset by one whose values lie in another file."""
    elsewhere = path.with_name("secret")
    elsewhere.write_bytes(SECRET.tobytes())
    with h5py.File(path.with_name("secret.h5"), "w") as file:
        file["z"] = SECRET.reshape(7, 6)
    with h5py.File(path, "a") as file:
        if name in file:
            del file[name]
        if how == "external storage":
            file.create_dataset(name, (7, 6), "float64", external=[(elsewhere.name, 0, SECRET.nbytes)])
        elif how == "virtual":
            layout = h5py.VirtualLayout((7, 6), "float64")
            layout[:] = h5py.VirtualSource("secret.h5", "z", (7, 6))
            file.create_virtual_dataset(name, layout)
        elif how == "external link":
            file[name] = h5py.ExternalLink("secret.h5", "/z")
        else:
            file["away"] = h5py.ExternalLink("secret.h5", "/")
            file[name] = h5py.SoftLink("/away/z")


@pytest.mark.parametrize(
    ("name", "how"),
    [
        ("history/P", "external storage"),
        ("fields/pressure", "virtual"),
        ("fields/x", "soft link"),
        ("header/json", "external link"),
    ],
)
def test_values_in_other_files_are_not_read(out: Path, name: str, how: str) -> None:
    lead_away(out, name, how)
    line = refused(4, "export", out, "--to", "npz")
    assert "lie in other files, which are not read" in line or "is a link to another place" in line
    shutil.copytree(out.parent, out.parent / "again")
    map_file = out.parent / "again" / "map.h5"
    lead_away(map_file, "z", how)
    case = heights_case(map_file.parent, "map.h5", ", dataset: z")
    code = 2 if how.endswith("link") else 4
    line = refused(code, "validate", case)
    assert "there is no dataset 'z'" in line or "lie in other files, which are not read" in line


@pytest.mark.parametrize("group", ["header", "history", "fields", "restart"])
def test_groups_that_are_links_to_a_pipe(tmp_path: Path, group: str) -> None:
    out = write_fake(tmp_path / "out.h5", "failed", increments=6)
    os.mkfifo(tmp_path / "pipe")
    with h5py.File(out, "r+") as file:
        del file[group]
        file[group] = h5py.ExternalLink("pipe", "/")
    if group != "restart":
        assert "is a link to another place, which is not followed" in refused(4, "show", out)
    with pytest.raises(FileError, match="is a link to another place"):
        HistoryWriter.open(out, fake_header(increments=6), resume=True)


def test_a_result_that_is_no_regular_file(tmp_path: Path) -> None:
    out = tmp_path / "out.h5"
    os.mkfifo(out)
    assert "is not a regular file" in refused(4, "show", out)
    case = write_case(tmp_path)
    for option in ("--resume", "--overwrite"):
        assert "is not a regular file" in refused(4, "run", case, "-o", out, option)


def heights_text(folder: Path, content: str) -> Path:
    (folder / "map.txt").write_text(content)
    return heights_case(folder, "map.txt")


def test_text_maps_of_too_many_heights(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(text_map, "MOST_HEIGHTS", 12)
    assert invoke("validate", heights_text(tmp_path, "# a comment\n" + "1 2 3 4\n" * 3)).exit_code == 0
    assert "it has more than 12 heights; give a part of it" in refused(
        4, "validate", heights_text(tmp_path, "1 2 3 4\n" * 4)
    )
    monkeypatch.setattr(text_map, "LONGEST_LINE", 100)
    line = refused(4, "validate", heights_text(tmp_path, "1 2\n" + "1 " * 60))
    assert "a line of it has more than 100 characters" in line


def test_a_header_of_no_plausible_size(out: Path, tmp_path: Path) -> None:
    with h5py.File(out, "r+") as file:
        del file["header/json"]
        zeros(file, "header/json", 2**27, "u1")
    assert "header/json must hold at most 33554432 bytes" in refused(4, "show", out)
    stopped = write_fake(tmp_path / "stopped.h5", "stopped")
    with (parts_folder(stopped) / "header.json").open("r+b") as file:
        file.truncate(2**26)
    assert "has 67108864 bytes; at most 33554432 are read" in refused(4, "show", stopped)
