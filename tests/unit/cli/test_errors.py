"""Whatever is wrong with a command: the right exit code and one line that says what would be right."""

from __future__ import annotations

import errno
from pathlib import Path

import pytest
from command_line import ended, environment, finish, invoke, refused, start_python
from small_cases import CASE, write_case

from fretsolve.cli import main as cli

USAGE = {
    ("rum",): "fretsolve: No such command 'rum'.",
    ("run",): "fretsolve run: Missing argument 'CASE'. (see fretsolve run --help)",
    ("run", "case.yaml", "--ovewrite"): "--overwrite",
    ("run", "case.yaml", "--resume", "--overwrite"): "--resume and --overwrite exclude each other.",
    ("run", "case.yaml", "--threads", "0"): "fretsolve run: --threads: '0' is not a whole number from 1 on (see ",
    ("sweep", "run", "x.yaml", "-j", "two"): "sweep run: --jobs: 'two' is not a whole number from 1 to 1024 (see ",
    ("plot", "x.h5", "loo"): "fretsolve plot: KIND: 'loo' is not one of 'loop', 'profiles', ",
    ("new", "mod1"): "fretsolve new: KIND: 'mod1' is not one of 'hertz', ",
    ("run", "case.yaml", "other.yaml"): "unexpected extra argument (other.yaml)",
    ("run", "case.yaml", "--set"): "fretsolve run: Option '--set' requires an argument. (see fretsolve run --help)",
    ("run", "case.yaml", "--error-bars=yes"): "does not take a value. (see fretsolve run --help)",
    ("check", "case.yaml", "--error-bars"): "No such option '--error-bars'. It is an option of run, validate. (see ",
    ("show", "out.h5", "--dry-run"): "No such option '--dry-run'. It is an option of sweep run. (see ",
    ("show", "out.h5", "--no-such"): "fretsolve show: No such option '--no-such'. (see fretsolve show --help)",
    ("check",): "Missing argument",
    ("export", "out.h5"): "Missing option '--to'. Choose from: vtk, xdmf, csv, npz",
    ("validate",): "Missing argument",
}


@pytest.mark.parametrize("words", USAGE, ids=" ".join)
def test_usage_error(words: tuple[str, ...]) -> None:
    assert USAGE[words] in refused(2, *words)


def test_usage_error_of_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SLURM_CPUS_PER_TASK", "many")
    assert "SLURM_CPUS_PER_TASK: 'many' is not a whole number from 1 on" in refused(2, "run", "case.yaml")


BAD = {
    "grid: {points: 16}": ("grid: {pints: 16}", ":6: grid.pints: unknown key 'pints'; did you mean 'points'?"),
    "friction: 0.1": ("friction: lots", ":7: friction: 'lots' has no number; a number such as '0.1' is needed"),
    "title: tiny": ("title: tiny\n\tgrid: 3", ":2: not valid YAML"),
    "  - {P: 400 N, increments: 1}": ("  - {P: 5 N mm}", ":9: stage.1.P: '5 N mm' is a moment; a force such as"),
}


@pytest.mark.parametrize("command", ["run", "validate", "check"])
@pytest.mark.parametrize("good", BAD)
def test_mistake_in_the_case(command: str, good: str, tmp_path: Path) -> None:
    bad, message = BAD[good]
    case = write_case(tmp_path, CASE.replace(good, bad))
    assert refused(2, command, case).startswith(f"{case}{message}")
    assert not case.with_suffix(".h5").exists()


SETS = {
    "foo": "--set foo: KEY=VALUE is needed",
    "grid.points=abc": "--set grid.points=abc: grid.points: 'abc' is not allowed; a whole number",
    "load_path.7.P=3 N": "load_path.7.P: the list has no entry 7; its entries are 0 to 1",
    "frictoin=0.2": "--set frictoin=0.2: frictoin: unknown key 'frictoin'; did you mean 'friction'?",
}


@pytest.mark.parametrize("override", SETS)
def test_mistake_in_an_override(override: str, tmp_path: Path) -> None:
    assert SETS[override] in refused(2, "run", write_case(tmp_path), "--set", override)


def test_all_mistakes_of_a_case_at_once(tmp_path: Path) -> None:
    case = write_case(tmp_path, CASE.replace("points: 16", "points: 0").replace("friction: 0.1", "friction: -1"))
    lines = invoke("run", case).stderr.splitlines()
    assert [line.split(": ")[:2] for line in lines] == [[f"{case}:6", "grid.points"], [f"{case}:7", "friction"]]


@pytest.mark.parametrize("command", ["run", "validate", "check", "show"])
def test_missing_file_and_folder(command: str, tmp_path: Path) -> None:
    for path in (tmp_path / "nothing.yaml", tmp_path):
        assert refused(4, command, path).startswith(f"{path}: ")


@pytest.mark.parametrize("content", [b"", b"title: a case, not a result\n", b"\x89HDF\r\n\x1a\n and then nothing"])
def test_show_something_else(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "some.h5"
    path.write_bytes(content)
    assert refused(4, "show", path).startswith(f"{path}: ")


def test_output_that_cannot_be_written(tmp_path: Path) -> None:
    case = write_case(tmp_path)
    folder, missing = tmp_path / "folder.h5", tmp_path / "missing" / "out.h5"
    folder.mkdir()
    told = f"{tmp_path}: the name of a result must end in .h5 or .hdf5\n"
    assert refused(2, "run", case, "-o", tmp_path) == told
    told = f"{folder}: is a folder; the name of a file is needed\n"
    assert refused(2, "run", case, "-o", folder, "--overwrite") == told
    told = f"{missing}: there is no folder {missing.parent}; mkdir -p {missing.parent} makes it\n"
    assert refused(4, "run", case, "-o", missing) == told


def test_bug_is_one_line_and_a_traceback_when_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken() -> None:
        raise ZeroDivisionError("of two\nlines")

    monkeypatch.delenv("FRETSOLVE_DEBUG", raising=False)
    monkeypatch.setattr("fretsolve.case.schema.case_schema", broken)
    told = "internal error: ZeroDivisionError: of two lines; please report it, with what it prints under "
    assert refused(70, "schema") == f"{told}FRETSOLVE_DEBUG=1\n"
    monkeypatch.setenv("FRETSOLVE_DEBUG", "1")
    assert isinstance(invoke("schema").exception, ZeroDivisionError)


WARNED = """
import sys, warnings
from fretsolve.cli import main
main.available = lambda threads: warnings.warn("divide by zero", RuntimeWarning) or 1
main.main(["run", "no.yaml"])
"""


@pytest.mark.parametrize("debug", [False, True])
def test_warnings_of_libraries_are_for_debugging(debug: bool) -> None:
    process = start_python("-c", WARNED, env=environment() | ({"FRETSOLVE_DEBUG": "1"} if debug else {}))
    code, _, messages = ended(process)
    assert (code, "RuntimeWarning: divide by zero" in messages) == (4, debug)
    assert messages.endswith("no.yaml: cannot be read: No such file or directory\n")


def test_no_permission_is_no_bug(monkeypatch: pytest.MonkeyPatch) -> None:
    def closed() -> None:
        raise PermissionError(errno.EACCES, "Permission denied", "a/b\n")

    monkeypatch.delenv("FRETSOLVE_DEBUG", raising=False)
    monkeypatch.setattr("fretsolve.case.schema.case_schema", closed)
    assert refused(4, "schema") == "a/b\\u000a: cannot be used: Permission denied\n"


def test_version_and_schema() -> None:
    import json

    from fretsolve import __version__

    assert invoke("--version").stdout == f"fretsolve {__version__}\n"
    schema = json.loads(invoke("schema").stdout)
    kinds = {"then": {"plane", "bodies", "surface", "load_path"}, "else": {"bodies", "surface", "load_path"}}
    assert {kind: set(schema[kind]["required"]) for kind in kinds} == kinds


def test_every_command_has_help() -> None:
    for name in cli.main.commands:
        result = invoke(name, "--help")
        assert result.exit_code == 0
        assert result.stdout.startswith(f"Usage: fretsolve {name} ")


COMPLETED = {
    "va": ["validate"],
    "run --re": ["--resume"],
    "new mo": ["mode1", "mode2", "mode3"],
    "export x.h5 --to v": ["vtk"],
}


@pytest.mark.parametrize("typed", COMPLETED)
def test_shell_completes_commands_options_and_values(typed: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("_FRETSOLVE_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", f"fretsolve {typed}")
    monkeypatch.setenv("COMP_CWORD", str(len(typed.split())))
    code, output, _ = finish()
    assert code == 0
    assert output.split() == [f"plain,{word}" for word in COMPLETED[typed]]


def test_shell_gets_a_script_for_completion(monkeypatch: pytest.MonkeyPatch) -> None:
    for shell in ("bash", "zsh", "fish"):
        monkeypatch.setenv("_FRETSOLVE_COMPLETE", f"{shell}_source")
        code, script, _ = finish()
        assert code == 0
        assert "_FRETSOLVE_COMPLETE" in script
