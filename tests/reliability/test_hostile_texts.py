"""Texts of users and files move no cursor, make no formula, and need no terminal that can show them."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest
from command_line import environment, finish, invoke, refused
from small_cases import CASE, SWEPT, case_of, write_case
from sweeping import manifest_of, write_sweep

from fretsolve.errors import printable
from fretsolve.sweep.table import column, write_table_csv

HOSTILE = "a\x1b[2J\x07\x9b31m\u202eb\u2066c\u2028d\x7f"
SHOWN = r"a\u001b[2J\u0007\u009b31m\u202eb\u2066c\u2028d\u007f"


def is_clean(text: str) -> bool:
    return all(character.isprintable() or character == "\n" for character in text)


def test_printable() -> None:
    assert printable(HOSTILE) == SHOWN
    assert printable("a\nb\tc", "\n") == "a\nb\\u0009c"
    assert printable("h\u00f6he \u00b5m \u0394 \u4e2d") == "h\u00f6he \u00b5m \u0394 \u4e2d"


@pytest.mark.parametrize("command", ["run", "validate", "check"])
def test_titles_of_cases(tmp_path: Path, command: str) -> None:
    title = json.dumps(f"{HOSTILE}\nsecond line")
    case = write_case(tmp_path, CASE.replace("title: tiny", f"title: {title}"))
    result = invoke(command, case)
    assert result.exit_code == 0
    assert is_clean(result.output)
    if command == "run":
        assert result.stdout.startswith(f"{SHOWN}\\u000asecond line\n")
        shown = invoke("show", case.with_suffix(".h5")).stdout
        assert shown.startswith(f"{SHOWN}\\u000asecond line\n")
        assert is_clean(shown)
        for line in invoke("run", case, "--overwrite", "--log-json").stdout.splitlines():
            event = json.loads(line)
            assert event.get("title", f"{HOSTILE}\nsecond line") == f"{HOSTILE}\nsecond line"


def test_names_of_files(tmp_path: Path) -> None:
    folder = tmp_path / f"{HOSTILE}\nnew"
    folder.mkdir()
    case = write_case(folder)
    assert invoke("run", case).exit_code == 0
    for words in (("show", case.with_suffix(".h5")), ("export", case.with_suffix(".h5"), "--to", "csv")):
        result = invoke(*words)
        assert result.exit_code == 0
        assert is_clean(result.output)
    for words in (("run", case), ("show", folder / "none.h5"), ("validate", case, "--set", f"friction={HOSTILE}")):
        assert is_clean(refused(4 if words[0] == "show" else 2, *words))


def test_settings_and_reasons_of_sweeps(tmp_path: Path) -> None:
    manifest = manifest_of(tmp_path)
    path = manifest.folder / "manifest.json"
    values = json.loads(path.read_text())
    values["title"] = HOSTILE
    values["cases"][0]["settings"]["friction"] = HOSTILE
    path.write_text(json.dumps(values))
    manifest.note(manifest.rows[0]).write_text(json.dumps({"exit_code": 4, "reason": HOSTILE}))
    for words in (("status",), ("collect",)):
        result = invoke("sweep", *words, manifest.folder)
        assert result.exit_code == 0
        assert is_clean(result.output)


@pytest.mark.parametrize("encoding", ["utf-8:strict", "ascii:strict"])
def test_a_name_that_is_not_utf_8_in_a_strict_locale(tmp_path: Path, encoding: str) -> None:
    case = Path(os.fsdecode(os.fsencode(tmp_path) + b"/h\xf6he.yaml"))
    case.write_text(CASE.replace("title: tiny", "title: H\u00f6he \u4e2d"), encoding="utf-8")
    own = environment() | {"PYTHONIOENCODING": encoding}
    for words in (("run", case), ("validate", case), ("show", case.with_suffix(".h5"))):
        code, _, messages = finish(*words, env=own, encoding="latin-1")
        assert (code, "internal error" in messages) == (0, False)
    code, _, messages = finish("run", case, env=own, encoding="latin-1")
    assert (code, messages.count("\n")) == (2, 1)
    assert r"h\udcf6he.h5: exists" in messages


CYCLED = case_of("{P: 400 N}, {cycle: {times: 1, stages: [{Qx: 20 N}, {Qx: -20 N}]}}", points=16)
EXPECTED = "expect=[{quantity: P, value: 400 N, rel: 1e-6}]"
SWT = "{criteria: [swt], material: {young_modulus: 200 GPa, poisson_ratio: 0.3}}"


@pytest.mark.slow
def test_every_command_takes_a_name_that_is_not_utf_8_or_refuses_it(tmp_path: Path) -> None:
    """The files of stresses and of fatigue, VTK's and XDMF's hold the name, so none of them is begun."""
    folder = Path(os.fsdecode(os.fsencode(tmp_path) + b"/h\xf6he"))
    folder.mkdir()
    case, sweep, out = folder / "\udcf6.yaml", folder / "\udcf6.sweep.yaml", folder / "\udcf6.h5"
    case.write_text(CYCLED, encoding="utf-8")
    sweep.write_text("case: plain.yaml\naxes: [{friction: [0.1, 0.2]}]\n", encoding="utf-8")
    (folder / "plain.yaml").write_text(case.read_text(), encoding="utf-8")
    refused_name = "the name of a file or folder is not UTF-8 text, which the file to be written could not hold"
    for spec in ("stress={}", f"fatigue={SWT}"):
        assert refused_name in refused(4, "run", case, "-q", "--set", f"output.{spec}")
    assert refused_name in refused(4, "sweep", "run", sweep, "-q")
    before = set(folder.iterdir())
    assert len(before) == 3
    for words in (
        ("validate", case),
        ("check", case, "--set", EXPECTED, "--junit", folder / "\udcf6.xml"),
        ("run", case, "-q"),
        ("show", out),
        ("show", out, "--json"),
        ("plot", out),
        ("plot", out, "map", "-o", folder / "\udcf6.svg"),
        ("export", out, "--to", "csv"),
        ("export", out, "--to", "npz"),
        ("study", case, "-q", "--vary", "grid.points=8,12", "--quantity", "P"),
    ):
        done = invoke(*words)
        assert done.exit_code == 0, (words, done.output)
    before = set(folder.iterdir())
    material = "young_modulus=200 GPa,poisson_ratio=0.3"
    for words in (
        ("stress", out),
        ("fatigue", out, "--criterion", "swt", "--material", material),
        ("export", out, "--to", "vtk"),
        ("export", out, "--to", "xdmf"),
        ("export", out, "--to", "xdmf", "-o", tmp_path / "elsewhere.xdmf"),
    ):
        assert refused_name in refused(4, *words)
    assert set(folder.iterdir()) == before
    for words in (("stress", out.rename(folder / "plain.h5"), "-q"), ("export", folder / "plain.h5", "--to", "xdmf")):
        assert invoke(*words).exit_code == 0


def test_formulas_in_tables(tmp_path: Path) -> None:
    texts = ["=1+1", "+cmd", "-2+3", "@SUM(A1)", "\tx", "-36 N", "-2 cmd", "+3", "-0.5", "plain", "a=b"]
    columns = [column("=key", texts), column("number", np.full(len(texts), -1.5))]
    write_table_csv(tmp_path / "t.csv", columns)
    head, *rows = (tmp_path / "t.csv").read_text().splitlines()
    assert head == "'=key,number"
    assert [row.rpartition(",")[0] for row in rows] == [
        *("'=1+1", "'+cmd", "'-2+3", "'@SUM(A1)", "'\tx", "-36 N", "'-2 cmd", "+3", "-0.5", "plain", "a=b")
    ]
    assert {row.rpartition(",")[2] for row in rows} == {"-1.5"}


EXTREMES = ["1" + "0" * 400, "-1e400", "9" * 5000, ".nan", "{}", "'\\0'"]


@pytest.mark.parametrize("value", EXTREMES, ids=lambda value: value[:8])
def test_numbers_and_words_beyond_any_range(tmp_path: Path, value: str) -> None:
    case = write_case(tmp_path)
    for key in ("grid.points", "grid.size", "friction", "load_path.0.P", "load_path.0.increments", "solver.tolerance"):
        result = invoke("validate", case, "--set", f"{key}={value}")
        assert result.exit_code == 2
        assert max(map(len, result.stderr.splitlines())) < 6000
    for axis in (
        f"friction: {{from: {value}, to: 2, count: 3}}",
        f"friction: {{from: 0.1, to: 0.2, count: {value}}}",
        f"friction: {{from: 0.1, to: {value}, count: 3, spacing: log}}",
        f"grid.points: [16, {value}]",
        f"latin_hypercube: {{samples: {value}, over: {{friction: {{from: 0.1, to: 0.2}}}}}}",
        f"latin_hypercube: {{samples: 3, over: {{friction: {{from: 0.1, to: {value}}}}}}}",
    ):
        file = write_sweep(tmp_path, f"case: case.yaml\naxes: [{{{axis}}}]\n", SWEPT)
        result = invoke("sweep", "run", file, "-q")
        assert result.exit_code == 2, result.output
        assert len(result.stderr.splitlines()) <= 3
    assert not (tmp_path / "sweep.sweep").exists()


BOMB = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n"
BOMB += "".join(f"a{i + 1}: &a{i + 1} [{', '.join([f'*a{i}'] * 9)}]\n" for i in range(12))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (BOMB.encode() + CASE.encode(), "its aliases expand to more than 100000 values"),
        (CASE.encode("utf-16"), "byte 0xff is not UTF-8 text; a YAML text file in UTF-8 is needed"),
        (CASE.encode("utf-32"), "byte 0xff is not UTF-8 text"),
        (b"a: " + b"[" * 5000 + b"]" * 5000, "values are nested more than 50 levels deep"),
        (b"".join(b" " * i + b"a:\n" for i in range(1000)), "values are nested more than 50 levels deep"),
        (b"a: &a {<<: *a}\n", "the alias contains itself"),
        (b"a: [" + b"1," * 500_000 + b"1]", "there are more than 100000 values"),
        (b"a: " + b"x" * 2**22, "the file is larger than 4 MiB"),
        (b"!!python/object/apply:os.system [true]", "unknown tag"),
    ],
    ids=["bomb", "UTF-16", "UTF-32", "5000 brackets", "1000 levels", "loop", "wide", "large", "tag"],
)
def test_yaml_that_takes_too_much(tmp_path: Path, content: bytes, message: str) -> None:
    case = tmp_path / "case.yaml"
    case.write_bytes(content)
    result = invoke("validate", case)
    assert (result.exit_code, result.stdout) == (2, "")
    assert message in result.stderr
    assert max(map(len, result.stderr.splitlines())) < 400


HEIGHTS = "{heights: {file: map.txt, unit: um, spacing: 1 um}}"


def test_text_maps_are_not_quoted_at_length(tmp_path: Path) -> None:
    case = write_case(tmp_path, CASE.replace("{sphere: {radius: 10 mm}}", HEIGHTS))
    (tmp_path / "map.txt").write_text("1 2 3 4\n1 2 3 " + "secret" * 10_000 + "\n")
    line = refused(4, "validate", case)
    assert len(line) < 300 + 2 * len(str(tmp_path))  # it names the case and the map
    assert "line 2 holds" in line and "which is no number" in line
