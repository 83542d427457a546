"""Nothing that fretsolve has not made is written over, removed or led to, and what it has saved stays."""

from __future__ import annotations

import errno
import os
import shutil
from pathlib import Path
from typing import Any

import pytest
from command_line import assert_same_result, invoke, refused
from fake_states import fake_header, fake_states, write_fake, write_increments
from PIL import Image
from small_cases import CASE, write_case
from sweeping import manifest_of

from fretsolve.errors import FileError
from fretsolve.post.stress.computed_file import opened_computed
from fretsolve.result import HistoryWriter, open_result
from fretsolve.result.parts import parts_folder
from fretsolve.system import atomic_files
from fretsolve.system.files import PICTURE_MARK

TEXT = "the user's own\n"


@pytest.fixture()
def own(tmp_path: Path) -> Path:
    path = tmp_path / "own"
    path.mkdir()
    for name in ("thesis.txt", "000000-000003.h5", "header.json", "lock", "notes.tmp"):
        (path / name).write_text(TEXT)
    return path


def untouched(own: Path) -> bool:
    return sorted(path.read_text() for path in own.iterdir()) == [TEXT] * 5


@pytest.mark.parametrize("option", ["--resume", "--overwrite", "-q"])
def test_parts_that_are_a_link(tmp_path: Path, own: Path, option: str) -> None:
    case = write_case(tmp_path)
    parts_folder(case.with_suffix(".h5")).symlink_to(own)
    line = refused(4, "run", case, option)
    assert line == f"{case.with_suffix('.h5')}.parts: {LINK}\n"
    assert untouched(own)


LINK = "is a link, which a run does not follow: remove it, or give another name with -o"


@pytest.mark.parametrize("name", ["lock", "holder"])
def test_a_link_among_the_parts(tmp_path: Path, own: Path, name: str) -> None:
    case = write_case(tmp_path)
    parts = parts_folder(case.with_suffix(".h5"))
    parts.mkdir()
    (parts / name).symlink_to(own / "thesis.txt")
    if name == "lock":
        assert refused(4, "run", case) == f"{parts / name}: {LINK}\n"
    else:
        assert invoke("run", case, "-q").exit_code == 0
    assert untouched(own)


OTHER_USER = 12345


as_root = pytest.mark.skipif(os.geteuid() != 0, reason="only root may give files away")


@as_root
@pytest.mark.parametrize("option", ["--resume", "--overwrite", "-q"])
def test_parts_of_another_user(tmp_path: Path, own: Path, option: str) -> None:
    case = write_case(tmp_path)
    parts = parts_folder(case.with_suffix(".h5"))
    own.rename(parts)
    (parts / "lock").rename(parts / "a lock")
    os.chown(parts, OTHER_USER, -1)
    line = refused(4, "run", case, option)
    assert line.startswith(f"{parts}: belongs to another user ({OTHER_USER}), so a run does not write there: copy it")
    assert untouched(parts)
    assert invoke("run", case, "-q", "-o", tmp_path / "other.h5").exit_code == 0


@as_root
def test_folders_of_one_owner(tmp_path: Path) -> None:
    """As on file systems that show one owner for all files, and where root works for a user."""
    case = write_case(tmp_path)
    os.chown(tmp_path, OTHER_USER, -1)
    out = case.with_suffix(".h5")
    write_increments(out, stop_after=3)
    os.chown(parts_folder(out), OTHER_USER, -1)
    write_increments(out, resume=True)
    assert open_result(out).increments == 6


@as_root
def test_temporary_files_of_another_user_stay(tmp_path: Path) -> None:
    ours, theirs = (tmp_path / f"t.csv.{digit * 16}.tmp" for digit in "01")
    for path in (ours, theirs):
        path.write_text(TEXT)
        os.utime(path, (0.0, 0.0))
    os.chown(theirs, OTHER_USER, -1)
    atomic_files.write_text(tmp_path / "t.csv", TEXT)
    assert (ours.exists(), theirs.exists()) == (False, True)


def test_temporary_files_of_others_stay(tmp_path: Path) -> None:
    out = write_fake(tmp_path / "out.h5")
    target = tmp_path / "t.csv"
    names = ["t.csv.tmp", "t.csv.mine.tmp", "t.csv.0123456789abcdeg.tmp", "t.csv.0123456789abcdef.tmp.tmp"]
    for name in names:
        (tmp_path / name).write_text(TEXT)
        os.utime(tmp_path / name, (0.0, 0.0))
    (tmp_path / "t.csv.0123456789abcdef.tmp").symlink_to(tmp_path / names[0])
    assert invoke("export", out, "--to", "csv", "-o", target).exit_code == 0
    assert [(tmp_path / name).read_text() for name in names] == [TEXT] * 4
    assert (tmp_path / "t.csv.0123456789abcdef.tmp").is_symlink()
    parts = parts_folder(tmp_path / "other.h5")
    parts.mkdir()
    (parts / "mine.tmp").write_text(TEXT)
    write_fake(tmp_path / "other.h5")
    assert (parts / "mine.tmp").read_text() == TEXT


def test_temporary_names_cannot_be_guessed_or_lead_elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target, victim = tmp_path / "t.csv", tmp_path / "victim"
    victim.write_text(TEXT)
    monkeypatch.setattr("secrets.token_hex", lambda size: "0" * (2 * size))
    (tmp_path / f"t.csv.{'0' * 16}.tmp").symlink_to(victim)
    with pytest.raises(FileExistsError):
        atomic_files.write_text(target, "new")
    assert (victim.read_text(), target.exists()) == (TEXT, False)


@pytest.mark.parametrize("words", [("export", "--to", "csv", "--overwrite"), ("plot", "loop")])
def test_what_a_link_leads_to_is_not_written(tmp_path: Path, words: tuple[str, ...]) -> None:
    out, victim = write_fake(tmp_path / "out.h5"), tmp_path / "victim"
    target = tmp_path / ("t.csv" if words[0] == "export" else "t.png")
    victim.write_text(f"{TEXT}{PICTURE_MARK}")  # as if it were a picture of fretsolve, which may be replaced
    target.symlink_to(victim)
    assert invoke(words[0], out, *words[1:], "-o", target).exit_code == 0
    assert victim.read_text() == f"{TEXT}{PICTURE_MARK}"
    assert not target.is_symlink()


@pytest.mark.parametrize("ending", ["png", "pdf", "svg", "gif"])
@pytest.mark.slow
def test_only_pictures_of_fretsolve_are_replaced(tmp_path: Path, ending: str) -> None:
    out, target = write_fake(tmp_path / "out.h5", increments=3), tmp_path / f"t.{ending}"
    words = ("plot", out, "animate" if ending == "gif" else "loop", "-o", target)
    for _ in range(2):  # its own is replaced
        assert invoke(*words).exit_code == 0
    if ending == "gif":
        with Image.open(target) as film, open_result(out) as result:
            assert film.n_frames == len(result.steps)
    target.write_text(TEXT)
    line = refused(4, *words)
    assert line.startswith(f"{target}: is not a picture of fretsolve, so it is not replaced: move it away, or give")
    assert target.read_text() == TEXT


def test_only_reports_of_fretsolve_are_replaced(tmp_path: Path) -> None:
    case, report = write_case(tmp_path), tmp_path / "report.xml"
    for _ in range(2):
        assert invoke("check", case, "--junit", report).exit_code == 0
    report.write_text("<testsuites/>")
    assert "is not a report of tests of fretsolve" in refused(4, "check", case, "--junit", report)
    assert report.read_text() == "<testsuites/>"


@pytest.mark.parametrize("pause", [0.0, 1000.0])
def test_a_file_that_takes_the_name_of_the_result(tmp_path: Path, pause: float) -> None:
    out = tmp_path / "out.h5"
    with HistoryWriter.open(out, fake_header(), pause=pause) as writer:
        for state in fake_states(6):
            writer.append(state)
        out.write_text(TEXT)
        with pytest.raises(
            FileError, match="another file has taken this name under way and is not touched; move it"
        ) as c:
            writer.finish("complete")
    assert str(c.value).endswith("away; 6 of 6 increments are kept, --resume goes on")
    assert out.read_text() == TEXT
    out.rename(tmp_path / "moved")
    with HistoryWriter.open(out, fake_header(), resume=True) as writer:
        assert len(writer.summaries) == 6
        writer.finish("complete")
    write_increments(tmp_path / "whole.h5")
    assert_same_result(out, tmp_path / "whole.h5")


def test_a_folder_that_is_removed_under_way(tmp_path: Path) -> None:
    out = tmp_path / "out.h5"
    with HistoryWriter.open(out, fake_header()) as writer:
        states = fake_states(6)
        writer.append(next(states))
        shutil.rmtree(parts_folder(out))
        with pytest.raises(FileError, match="cannot save the increment: No such file or directory; saved") as caught:
            writer.append(next(states))
    assert str(caught.value).endswith("; saved increments were removed under way")


class LateOs:
    """An `os` in which another file takes the name `target` just before a file gets it."""

    def __init__(self, target: Path):
        self.target = target

    def __getattr__(self, name: str) -> Any:
        return getattr(os, name)

    def link(self, source: Path, target: Path) -> None:
        self._appear(target)
        os.link(source, target)

    def replace(self, source: Path, target: Path) -> None:
        self._appear(target)
        source.replace(target)

    def _appear(self, target: Path) -> None:
        if target == self.target:
            target.write_text(TEXT)


class OsWithoutHardLinks(LateOs):
    """As on a file system that has none; the other file appears before that is found out."""

    def link(self, source: Path, target: Path) -> None:
        self._appear(target)
        raise PermissionError(errno.EPERM, os.strerror(errno.EPERM))

    def replace(self, source: Path, target: Path) -> None:
        source.replace(target)


@pytest.mark.parametrize(
    ("words", "kind"),
    [
        *((words, LateOs) for words in ("run", "csv", "npz", "pvd", "xdmf", "xdmf.h5", "schema", "stress", "collect")),
        *((words, OsWithoutHardLinks) for words in ("run", "csv", "stress")),
    ],
)
@pytest.mark.slow
def test_a_file_that_appears_at_the_last_moment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: str, kind: type[LateOs]
) -> None:
    case, target = write_case(tmp_path), tmp_path / f"t.{words}"
    if words == "run":
        target = tmp_path / "t.h5"
        command = ["run", case, "-o", target]
    elif words == "schema":
        target = tmp_path / "t.json"
        command = ["schema", "-o", target]
    elif words == "collect":
        target = tmp_path / "t.csv"
        command = ["sweep", "collect", manifest_of(tmp_path).folder, "-o", target]
    elif words == "stress":
        target = tmp_path / "t.h5"
        out = case.with_suffix(".h5")
        assert invoke("run", case, "-q").exit_code == 0
        command = ["stress", out, "-o", target]
    else:
        out, named = write_fake(tmp_path / "out.h5"), tmp_path / f"t.{words.removesuffix('.h5')}"
        command = ["export", out, "--to", {"pvd": "vtk", "xdmf.h5": "xdmf"}.get(words, words), "-o", named]
    before = sorted(tmp_path.rglob("*.tmp"))
    with monkeypatch.context() as patch:
        patch.setattr(atomic_files, "os", kind(target))
        result = invoke(*command)
    assert result.exit_code == 4, result.output
    assert "another file has taken this name" in result.stderr
    assert target.read_text() == TEXT
    assert sorted(tmp_path.rglob("*.tmp")) == before
    if words == "run":
        target.unlink()
        assert invoke(*command, "--resume").exit_code == 0
    else:
        assert "exists" in refused(2, *command)
        assert invoke(*command, "--overwrite").exit_code == 0
    assert target.read_bytes() != TEXT.encode()


def test_a_file_system_without_hard_links(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    case = write_case(tmp_path)
    monkeypatch.setattr(atomic_files, "os", OsWithoutHardLinks(tmp_path / "none"))
    assert invoke("run", case, "-q").exit_code == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["case.h5", "case.yaml"]


@pytest.mark.slow
def test_stresses_of_a_run_replace_no_other_file(tmp_path: Path) -> None:
    case, own = write_case(tmp_path, f"{CASE}output: {{stress: {{}}}}\n"), tmp_path / "case.stress.h5"
    own.write_text(TEXT)
    for option in ("-q", "--resume"):
        line = refused(2, "run", case, option)
        assert line.startswith(f"{own}: exists: the run would replace it by what output asks for: move it away, or")
    assert own.read_text() == TEXT
    assert sorted(path.name for path in tmp_path.iterdir()) == ["case.stress.h5", "case.yaml"]
    assert invoke("run", case, "-q", "--overwrite").exit_code == 0
    with opened_computed(own) as found:
        assert found is not None
    line = refused(2, "run", case)  # as after a kill while the stresses were written
    assert line.startswith(f"{case.with_suffix('.h5')}: exists: --resume goes on and writes what is missing beside it")
    case.with_suffix(".h5").unlink()
    assert "exists: the run would replace" in refused(2, "run", case)
    assert invoke("run", case, "-q", "--resume").exit_code == 0  # its own may be replaced


def test_a_result_that_could_not_be_written_is_refused_before_the_run(tmp_path: Path) -> None:
    case, out = write_case(tmp_path), tmp_path / "out.h5"
    out.symlink_to("nowhere")
    assert "is a link to a file that does not exist" in refused(4, "run", case, "-o", out)
    assert "is a link to a file that does not exist" in refused(4, "run", case, "-o", out, "--overwrite")
    out.unlink()
    longest = os.pathconf(tmp_path, "PC_NAME_MAX")
    line = refused(4, "run", case, "-o", tmp_path / f"{'x' * (longest - 13)}.h5")
    assert "the name is too long: a run adds an ending to it, so it must be shorter by 11 bytes" in line
    assert [path.name for path in tmp_path.iterdir()] == ["case.yaml"]
    fits = tmp_path / f"{'x' * (longest - 24)}.h5"
    assert invoke("run", case, "-q", "-o", fits).exit_code == 0


def test_export_leaves_what_it_has_not_written(tmp_path: Path, own: Path) -> None:
    out, folder = write_fake(tmp_path / "out.h5"), tmp_path / "out.vtk"
    words = ("export", out, "--to", "vtk")
    folder.symlink_to(own)
    assert "is a link, which is not followed" in refused(4, *words, "--overwrite")
    folder.unlink()
    shutil.copytree(own, folder)
    assert "holds other files than grids" in refused(4, *words, "--overwrite")
    assert untouched(own) and untouched(folder)
    shutil.rmtree(folder)
    assert invoke(*words).exit_code == 0
    (tmp_path / "out.pvd").unlink()
    assert "holds grids: --overwrite replaces them" in refused(2, *words)
    assert invoke(*words, "--overwrite").exit_code == 0
