"""``fretsolve plot``: files and their names, and what cannot be drawn is one line that says why."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import pytest
from command_line import environment, finish, invoke, refused
from PIL import Image
from small_cases import DRAWN, write_case


def test_files_by_their_suffix(result_folder: Path, tmp_path: Path) -> None:
    for suffix, start in (("png", b"\x89PNG"), ("pdf", b"%PDF"), ("SVG", b"<?xml")):
        out = tmp_path / f"loop.{suffix}"
        done = invoke("plot", result_folder / "torsion.h5", "-o", out)
        assert (done.exit_code, done.output) == (0, f"{out}\n")
        assert out.read_bytes().startswith(start)
        assert 3_000 < out.stat().st_size < 300_000
    with Image.open(tmp_path / "loop.png") as picture:
        assert picture.size >= (600, 500)
    first = (tmp_path / "loop.SVG").read_bytes()
    invoke("plot", result_folder / "torsion.h5", "loop", "-o", tmp_path / "loop.SVG")
    assert (tmp_path / "loop.SVG").read_bytes() == first  # the same result, the same file


ERRORS = {
    ("fretting", "loop", "-o", "x.jpg"): "x.jpg: the name of a picture of kind loop must end in .png or .pdf or .svg",
    ("fretting", "loop", "-o", "x"): "x: the name of a picture of kind loop must end in .png or .pdf or .svg",
    ("fretting", "animate", "-o", "x.png"): "x.png: the name of a picture of kind animate must end in .gif or .mp4",
    ("fretting", "loop", "map", "-o", "x.png"): "one file cannot hold 2 pictures: name a folder",
    ("fretting", "loop", "--step", "1"): "fretting.h5: --step has no effect on loop; leave it out",
    ("fretting", "map", "--step", "99"): "map: there is no increment 99; there are 0 to 16",
    ("fretting", "map", "--step", "1", "--step", "2"): "map: shows one increment, not 2: give --step once",
    ("fretting", "map", "--field", "sheer"): "map: no field 'sheer' is stored, only pressure, shear, slip,",
    ("fretting", "profiles", "--at", "3,0"): "profiles: x = 3 mm is off the grid, whose cells lie from -0.35 to 0.35",
    ("fretting", "profiles", "--at", "here"): "'here' is not a point; two numbers in mm such as 0.1,-0.05 are needed",
    ("fretting", "slip-angle", "--step", "2"): "slip-angle: no tangential load changes in increment 2, so that",
    ("fretting", "loup"): "'loup' is not one of 'loop', 'profiles',",
    ("fretting", "loop", "--all"): "--all takes all kinds; leave KIND out.",
    ("fretting", "--all", "-o", "x.pdf"): "x.pdf: --all writes many files; the name of a folder is needed",
    ("mindlin", "map", "--step", "6"): "map: the fields of increment 6 are not stored (output.every); the nearest",
    ("hertz", "streamlines"): "streamlines: no field 'shear' is stored, only pressure, zone; output.fields",
    ("hertz", "slip-angle"): "slip-angle: no field 'shear' is stored, only pressure, zone; output.fields",
    ("hertz", "stick-history"): "stick-history: nothing sticks or slips without friction and shear traction",
    ("torsion", "slip-angle", "--step", "0"): "slip-angle: nothing slips in increment 0",
    ("torsion", "streamlines", "--step", "0"): "streamlines: shear and slip are 0 everywhere in increment 0",
}


@pytest.mark.parametrize("words", ERRORS, ids=" ".join)
def test_what_cannot_be_drawn_is_one_line(
    words: tuple[str, ...], result_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert ERRORS[words] in refused(2, "plot", result_folder / f"{words[0]}.h5", *words[1:])
    assert not list(tmp_path.iterdir())


def test_kinds_that_cannot_be_drawn_leave_the_others(result_folder: Path, tmp_path: Path) -> None:
    result = result_folder / "hertz.h5"
    done = invoke("plot", result, "loop", "stick-history", "-o", tmp_path)
    assert (done.exit_code, done.stdout) == (0, f"{tmp_path / 'hertz.loop.png'}\n")
    reason = "nothing sticks or slips without friction and shear traction"
    assert done.stderr == f"{result}: warning: stick-history: not drawn: {reason}\n"
    told = refused(2, "plot", result, "streamlines", "stick-history", "-o", tmp_path)
    assert told.startswith(f"{result}: streamlines: no field 'shear' is stored") and told.endswith(f"{reason}\n")
    assert [path.name for path in tmp_path.iterdir()] == ["hertz.loop.png"]


def test_names_of_kinds_and_fields_may_come_twice_or_with_commas(result_folder: Path, tmp_path: Path) -> None:
    result = result_folder / "fretting.h5"
    done = invoke("plot", result, "map", "map", "--field", "pressure,slip", "-o", tmp_path)
    assert (done.exit_code, done.stdout) == (0, f"{tmp_path / 'fretting.map.png'}\n")
    told = refused(2, "plot", result, "map", "--field", "pressure,sheer", "-o", tmp_path)
    assert "no field 'sheer' is stored" in told


def test_a_name_without_its_ending_or_of_the_case_is_asked_about(result_folder: Path, tmp_path: Path) -> None:
    shutil.copy(result_folder / "torsion.h5", tmp_path / "a.h5")
    (tmp_path / "a.yaml").touch()
    assert refused(4, "show", tmp_path / "a").endswith("nor parts of a run in a.parts; a.h5?\n")
    assert refused(4, "plot", tmp_path / "a.yaml").endswith("a.yaml: a case, not the result of a run; a.h5?\n")
    (tmp_path / "b.yaml").touch()
    assert refused(4, "plot", tmp_path / "b.yaml").endswith("b.yaml: a case, not the result of a run\n")


def test_picture_that_cannot_be_written(result_folder: Path, tmp_path: Path) -> None:
    result, missing, taken = result_folder / "torsion.h5", tmp_path / "missing" / "x.svg", tmp_path / "taken"
    told = f"{missing}: cannot be written: No such file or directory\n"
    assert refused(4, "plot", result, "-o", missing) == told
    taken.touch()
    assert refused(4, "plot", result, "--all", "-o", taken)
    assert "cannot be made a folder" in refused(4, "plot", result, "loop", "-o", f"{taken}/")
    assert refused(4, "plot", tmp_path / "no.h5")


def test_without_matplotlib(result_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    told = refused(2, "plot", result_folder / "torsion.h5")
    assert told.endswith("pip install '.[plot]' in a clone of fretsolve\n")


def test_a_display_that_matplotlib_does_not_have(result_folder: Path, tmp_path: Path) -> None:
    own = environment() | {"MPLBACKEND": "no such display"}
    line = ("plot", result_folder / "torsion.h5", "-o", tmp_path / "x.png")
    assert finish(*line, env=own) == (0, f"{tmp_path / 'x.png'}\n", "")


@pytest.mark.slow
def test_letters_that_the_font_lacks_are_no_warning(result_folder: Path, tmp_path: Path) -> None:
    text = DRAWN["hertz"].replace("bodies:", "title: 微动 接触\nbodies:").replace("points: 40", "points: 12")
    assert invoke("run", write_case(tmp_path, text), "-q").exit_code == 0
    code, output, messages = finish("plot", tmp_path / "case.h5", "loop")
    assert (code, output, messages) == (0, f"{tmp_path}/case.loop.png\n", "")
    with Image.open(tmp_path / "case.loop.png") as picture:
        picture.verify()
