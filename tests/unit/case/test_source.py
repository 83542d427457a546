"""YAML of a case file: values, lines, and everything that YAML allows and a case file does not."""

from __future__ import annotations

from pathlib import Path

import pytest

from fretsolve.case.source import CaseSource, Override, Place, parse, read_text
from fretsolve.errors import CaseError, FileError


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-6", 1e-6),
        ("-.5e2", -50.0),
        ("010", 10),
        ("0x1F", "0x1F"),
        ("1_000", "1_000"),
        ("1:30", "1:30"),
        ("2024-01-31", "2024-01-31"),
        ("yes", "yes"),
        ("true", True),
        (".inf", float("inf")),
        ("'1e-6'", "1e-6"),
        ("1.5 um", "1.5 um"),
        ("!!str 5", "5"),
        ("[1, a]", [1, "a"]),
    ],
)
def test_scalars_follow_yaml_1_2(text: str, value: object) -> None:
    parsed = parse(f"key: {text}")
    assert parsed.value == {"key": value}
    assert type(parsed.value["key"]) is type(value)
    assert parsed.flaws == ()


TEXT = """# comment
title: a
load_path:
  - {P: 1,
     Qx: 2}
  - cycle:
      stages:
        - Qy: 3

"""


@pytest.mark.parametrize(
    ("key", "line"),
    [
        (("title",), 2),
        (("load_path",), 3),
        (("load_path", 0), 4),
        (("load_path", 0, "P"), 4),
        (("load_path", 0, "Qx"), 5),
        (("load_path", 1, "cycle", "stages", 0, "Qy"), 8),
        (("load_path", 1, "cycle", "times"), 6),
        (("load_path", 9), 3),
        (("nowhere", "at", "all"), 2),
        ((), 2),
    ],
)
def test_line_of_a_key_or_of_its_nearest_parent(key: tuple[str | int, ...], line: int) -> None:
    source = CaseSource(Path("case.yaml"), TEXT, parse(TEXT).place)
    assert source.locate(key) == line


def test_problem_names_the_last_override_that_gave_the_value() -> None:
    overrides = (Override(("grid",), "grid={}"), Override(("grid", "points"), "grid.points=x"))
    source = CaseSource(Path("case.yaml"), "grid: 1", parse("grid: 1").place, overrides)
    assert str(source.problem("wrong", ("grid", "points"))) == "--set grid.points=x: grid.points: wrong"
    assert str(source.problem("wrong", ("grid", "size"))) == "--set grid={}: grid.size: wrong"
    assert str(source.problem("wrong", ("title",))) == "case.yaml:1: title: wrong"
    assert source.locate(("grid", "points")) is None


def test_unprintable_keys_stay_on_one_line() -> None:
    source = CaseSource(Path("case.yaml"), "", Place(1))
    assert str(source.problem("wrong", ("a\nb",))) == "case.yaml:1: 'a\\nb': wrong"


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("a: 1\nb: 2\na: 3\n", 3, "duplicate key 'a', given first on line 1; keep one of the two"),
        ("a: 1\ntrue: b\n", 2, "the key 'true' is not a name; keys are text"),
        ("a: 1\n? [x, y]\n: b\n", 2, "the key 'of several parts' is not a name; keys are text"),
        ("a:\n  b:\n", 2, "no value is given; give one or remove the key"),
        ("a:\n  b: ~\n", 2, "no value is given; give one or remove the key"),
        ("a: !thing 3\n", 1, "unknown tag '!thing'; a value without a tag is needed"),
        (
            "a: !!python/name:os.system x\n",
            1,
            "unknown tag 'tag:yaml.org,2002:python/name:os.system'; a value without a tag is needed",
        ),
        ("a: !!set {b, c}\n", 1, "unknown tag 'tag:yaml.org,2002:set'; a value without a tag is needed"),
        ("a: !!int x\n", 1, "'x' cannot be read as a number"),
        ("a: &a [*a]\n", 1, "the alias contains itself; a value without a loop is needed"),
    ],
)
def test_flaw_with_its_line(text: str, line: int, message: str) -> None:
    (flaw,) = parse(text).flaws
    assert (flaw.line, flaw.message) == (line, message)


def test_integer_of_thousands_of_digits_is_a_flaw() -> None:
    (flaw,) = parse(f"a: {'9' * 5000}").flaws
    assert "cannot be read as a number" in flaw.message
    assert len(flaw.message) < 120


def test_aliases_repeat_a_value() -> None:
    parsed = parse("a: &x {P: 1}\nb: *x\n")
    assert parsed.value == {"a": {"P": 1}, "b": {"P": 1}}
    source = CaseSource(Path("case.yaml"), "", parsed.place)
    assert source.locate(("b",)) == 2
    assert source.locate(("b", "P")) == 1


def test_aliases_that_explode_are_refused() -> None:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]" for i in range(1, 12)]
    flaws = parse("\n".join(lines)).flaws
    assert flaws
    assert all("aliases expand to more than" in flaw.message for flaw in flaws)


def test_aliases_that_nest_deeply_are_refused() -> None:
    lines = ["a0: &a0 [x]", *(f"a{i}: &a{i} [*a{i - 1}]" for i in range(1, 60))]
    assert any("levels" in flaw.message for flaw in parse("\n".join(lines)).flaws)


@pytest.mark.parametrize(
    ("text", "line", "part"),
    [
        ("a: 1\n\tb: 2\n", 2, "indent with spaces"),
        ("a:\n\tb: 2\n", 2, "indent with spaces"),
        ("a: [1, 2\n", 2, "begun on line 1"),
        ("a: *nowhere\n", 1, "undefined alias"),
        ("a: 1\n---\nb: 2\n", 2, "document"),
        ("a: 1\nb: \x07\n", 2, "control character #x07"),
        ('a: "\\ud800"\n', 1, "invalid Unicode"),
        ("a: \ud800", 1, "not valid Unicode"),
        ("[" * 100_000, 1, "nested more than 50 levels"),
        ("a: @x\n", 1, "cannot start any token"),
        ("a: b: c\n", 1, "mapping values are not allowed"),
    ],
)
def test_text_that_is_no_yaml(text: str, line: int, part: str) -> None:
    with pytest.raises(CaseError) as caught:
        parse(text)
    assert caught.value.line == line
    assert part in caught.value.message
    assert "\n" not in caught.value.message


def test_file_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(FileError) as caught:
        read_text(tmp_path / "none.yaml")
    assert str(caught.value) == f"{tmp_path / 'none.yaml'}: cannot be read: No such file or directory"
    with pytest.raises(FileError, match="Is a directory"):
        read_text(tmp_path)
    with pytest.raises(FileError, match="cannot be read"):
        read_text(Path("a\0b"))


def test_file_that_is_no_text(tmp_path: Path) -> None:
    path = tmp_path / "case.yaml"
    path.write_bytes(b"a: 1\n\x89HDF\r\n\x1a\n")
    with pytest.raises(CaseError) as caught:
        read_text(path)
    assert str(caught.value) == f"{path}:2: byte 0x89 is not UTF-8 text; a YAML text file in UTF-8 is needed"
    path.write_bytes(b" " * (4 * 1024 * 1024 + 1))
    with pytest.raises(CaseError, match="larger than 4 MiB"):
        read_text(path)


def test_byte_order_mark_is_no_part_of_the_text(tmp_path: Path) -> None:
    path = tmp_path / "case.yaml"
    path.write_bytes(b"\xef\xbb\xbfa: \xc2\xb5m\n")
    assert read_text(path) == "a: µm\n"


def test_a_result_in_the_place_of_a_case_is_named_as_such(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    path.write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(64))
    with pytest.raises(CaseError) as caught:
        read_text(path)
    assert str(caught.value).startswith(f"{path}: an HDF5 file, such as the result of a run; a case, a YAML text file")
