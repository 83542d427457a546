"""The comparison with other programs: what it leaves out and says, and its table, with workers made up here."""

from __future__ import annotations

import json
import re
import sys
from dataclasses import asdict, replace
from pathlib import Path
from types import ModuleType

import pytest

BENCHMARKS = Path(__file__).resolve().parents[3] / "benchmarks"

ANSWER = {
    "version": "1.2.3",
    "seconds": 0.25,
    "rigid": 9.1e-3,
    "peak": 2106.0,
    "radius": 0.3,
    "residual": 2e-7,
    "iterations": 7,
    "applications": None,
}
WORKS = f"""
import json, os, sys
task = json.loads(sys.argv[1])
assert os.environ["OMP_NUM_THREADS"] == "1"
print("chatter before the answer")
print(json.dumps({{**{ANSWER!r}, "seconds": task["points"] / 1024}}))
"""
WORKS_ALONE = f"import os; assert 'PYTHONPATH' not in os.environ\n{WORKS}"
FAILS = "raise RuntimeError('no such operator')"
NONSENSE = "print('all went well')"
INFINITE = f"import json; print(json.dumps({{**{ANSWER!r}, 'peak': float('inf')}}))"
HANGS = "import time; time.sleep(60)"


@pytest.fixture
def comparison(monkeypatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    import compare_programs

    return compare_programs


@pytest.fixture
def program(comparison, tmp_path):
    """Makes a program of the text of its worker."""

    def make(name: str, text: str, installs: tuple[tuple[str, ...], ...] = ()):
        worker = tmp_path / f"{name}.py"
        worker.write_text(text)
        return comparison.Program(name, worker, ("normal",), installs)

    return make


def test_one_that_works_among_some_that_do_not(comparison, program, tmp_path, capsys):
    programs = [
        program("failing", FAILS),
        program("talking", NONSENSE),
        program("infinite", INFINITE),
        program("working", WORKS),
    ]
    task, _ = comparison.base_case()
    rows = list(comparison.compare(programs, (128, 256), task, tmp_path, limit=60.0))
    assert [(row.program, row.points, row.answer.seconds) for row in rows] == [
        ("working", 128, 0.125),
        ("working", 256, 0.25),
    ]
    lines = capsys.readouterr().err.splitlines()
    assert lines == [
        "failing is left out: normal on 128 x 128 failed: RuntimeError: no such operator",
        "talking is left out: normal on 128 x 128: its worker gave no answer but 'all went well'",
        "infinite is left out: normal on 128 x 128: its worker gave peak as inf",
    ]


def test_one_that_hangs(comparison, program, tmp_path, capsys):
    task, _ = comparison.base_case()
    assert list(comparison.compare([program("hanging", HANGS)], (128, 256), task, tmp_path, limit=0.3)) == []
    assert capsys.readouterr().err == "hanging is left out: normal on 128 x 128 failed: took longer than 0.3 s\n"


def test_one_that_cannot_be_installed(comparison, program, tmp_path, capsys):
    no_folder = tmp_path / "a_file"
    no_folder.write_text("")
    programs = [program("absent", WORKS, (("nothing==1",),)), program("working", WORKS)]
    task, _ = comparison.base_case()
    rows = list(comparison.compare(programs, (128,), task, no_folder, limit=10.0))
    assert [row.program for row in rows] == ["working"]
    installing, left_out = capsys.readouterr().err.splitlines()
    assert installing == f"absent: installing into {no_folder / 'absent'}"
    assert re.match(r"absent is left out: cannot make its environment: Error: .*Not a directory", left_out)


def test_an_environment_is_used_again_until_other_packages_are_asked_for(comparison, program, tmp_path, monkeypatch):
    known = program("known", WORKS, (("known==1",),))
    calls = []

    def note(command, *_):
        calls.append([Path(command[0]), *command[1:]])
        (tmp_path / "known").mkdir(exist_ok=True)
        return ""

    monkeypatch.setattr(comparison, "_output", note)
    python = tmp_path / "known" / "bin" / "python"
    assert comparison.interpreter(known, tmp_path) == python
    assert calls == [
        [Path(sys.executable), "-m", "venv", str(tmp_path / "known")],
        [python, "-m", "pip", "install", "--quiet", "known==1"],
    ]
    assert comparison.interpreter(known, tmp_path) == python
    assert len(calls) == 2
    comparison.interpreter(replace(known, installs=(("known==2",),)), tmp_path)
    assert calls[3][-1] == "known==2"


def test_an_environment_of_its_own_does_not_see_the_path_of_this_one(comparison, program, tmp_path, monkeypatch):
    known = program("known", WORKS_ALONE, (("known==1",),))
    (tmp_path / "known" / "bin").mkdir(parents=True)
    (tmp_path / "known" / "bin" / "python").symlink_to(sys.executable)
    (tmp_path / "known" / comparison.COMPLETE).write_text(json.dumps(known.installs))
    monkeypatch.setenv("PYTHONPATH", str(BENCHMARKS))
    task, _ = comparison.base_case()
    assert len(list(comparison.compare([known], (128,), task, tmp_path, limit=60.0))) == 1


def test_an_installation_cut_short_is_not_taken_for_one(comparison, program, tmp_path, monkeypatch, capsys):
    known = program("known", WORKS, (("known==1",),))

    def fail_to_install(command, failure, *_):
        (tmp_path / "known").mkdir(exist_ok=True)
        if "pip" in command:
            raise comparison.UnusableError(f"{failure}: ERROR: No matching distribution found for known==1")
        return ""

    monkeypatch.setattr(comparison, "_output", fail_to_install)
    for _ in range(2):
        task, _ = comparison.base_case()
        assert list(comparison.compare([known], (128,), task, tmp_path, limit=1.0)) == []
        assert capsys.readouterr().err.splitlines() == [
            f"known: installing into {tmp_path / 'known'}",
            "known is left out: cannot be installed: ERROR: No matching distribution found for known==1",
        ]


def test_table(comparison):
    _, references = comparison.base_case()
    found = comparison.Answer(**ANSWER)
    rows = [
        comparison.Row("fretsolve", "normal", 128, replace(found, seconds=0.1, applications=12)),
        comparison.Row("other", "normal", 128, found),
        comparison.Row("other", "mode1", 128, replace(found, rigid=36.018)),
    ]
    heading, rule, *body = comparison.table(rows, references)
    assert heading.count("|") == rule.count("|") == len(comparison.HEADINGS) + 1
    cells = [line.strip("| ").split(" | ") for line in body]
    assert cells[0] == [
        *("fretsolve 1.2.3", "normal", "128", "0.1", "1.00", "12"),
        *("+0.3690 %", "-0.0233 %", "2.0e-07"),
    ]
    assert cells[1][3:6] == ["0.25", "2.50", "-"]
    assert cells[2][4] == "-"  # fretsolve has not run that job
    assert cells[2][6] == "+0.0500 %"


def test_closed_forms_of_the_base_case(comparison):
    task, references = comparison.base_case()
    assert task.delta_x == pytest.approx(0.863748e-3, rel=1e-6)
    assert task.contact_modulus == pytest.approx(109890.11, rel=1e-6)
    normal, mode1 = references["normal"], references["mode1"]
    assert (normal.rigid, normal.peak, normal.radius) == pytest.approx((9.066544e-3, 2106.491, 0.301107), rel=1e-6)
    assert (mode1.rigid, mode1.radius) == pytest.approx((36.0, 0.139761), rel=1e-5)
    assert mode1.peak == pytest.approx(0.1 * 2106.491 * (1 - (0.139761 / 0.301107) ** 2) ** 0.5, rel=1e-5)


def test_a_task_reaches_its_worker_whole(comparison, monkeypatch):
    from programs import task as protocol

    task, _ = comparison.base_case()
    task = replace(task, job="mode1", points=64)
    monkeypatch.setattr(sys, "argv", ["worker.py", json.dumps(asdict(task))])
    assert protocol.read_task() == task


def test_what_a_worker_tells_of_a_normal_contact(comparison):
    from programs import task as protocol

    task = replace(comparison.base_case()[0], job="normal", points=8)
    separation = task.separation()
    assert separation.shape == (8, 8)
    assert separation[0, 0] == pytest.approx(2 * (3.5 * 0.9 / 8) ** 2 / 20)
    inside = separation < 4e-3
    pressure = 100.0 * inside
    found = protocol.normal_contact(task, pressure, inside * (5e-3 - separation))
    assert found["rigid"] == pytest.approx(5e-3)
    assert found["peak"] == 100.0
    assert found["radius"] == pytest.approx((inside.sum() * task.cell**2 / 3.141592653589793) ** 0.5)
    # Outside, where nothing is displaced, the bodies overlap by what the approach exceeds the separation.
    assert found["residual"] == pytest.approx((5e-3 - separation[~inside].min()) / 5e-3)


def test_no_program_at_all(comparison, program, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(comparison, "PROGRAMS", (program("failing", FAILS),))
    assert comparison.main(["128", "--environments", str(tmp_path), "--limit", "10"]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert err.splitlines()[-1] == "no program could be run"
