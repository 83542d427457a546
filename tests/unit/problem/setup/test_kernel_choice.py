"""Kernels are compiled where that saves more than loading numba takes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from fretsolve import load_case
from fretsolve.errors import CaseError
from fretsolve.problem.setup import problem
from fretsolve.simulation.problem_setup import set_up

ROOT = Path(__file__).parents[4]


def compiled(*overrides):
    return set_up(load_case(ROOT / "cases" / "mode1_dissimilar.yaml", ["expect=[]", *overrides])).compiled


@pytest.fixture
def installed(monkeypatch):
    monkeypatch.delenv("FRETSOLVE_NUMBA")
    monkeypatch.setattr(problem, "compiler_installed", lambda: True)


def test_the_work_of_a_case_decides(installed):
    assert not compiled("grid.points=32")
    assert compiled("grid.points=256")
    short = "load_path=[{P: 400, increments: 1}]"
    assert not compiled("grid.points=256", short)
    assert compiled("grid.points=2048", short)


@pytest.mark.parametrize(("asked", "expected"), [("0", False), ("1", True)])
def test_the_environment_decides_if_it_says_so(installed, monkeypatch, asked, expected):
    monkeypatch.setenv("FRETSOLVE_NUMBA", asked)
    assert [compiled("grid.points=32"), compiled("grid.points=256")] == [expected, expected]


@pytest.mark.parametrize("asked", ["yes", "2", "true", " 1"])
def test_the_environment_must_say_0_or_1(installed, monkeypatch, asked):
    monkeypatch.setenv("FRETSOLVE_NUMBA", asked)
    with pytest.raises(CaseError, match=f"FRETSOLVE_NUMBA is '{asked}'; 0 never uses numba, 1 always does"):
        compiled("grid.points=32")


def test_without_numba_nothing_is_compiled(installed, monkeypatch):
    monkeypatch.setattr(problem, "compiler_installed", lambda: False)
    monkeypatch.setenv("FRETSOLVE_NUMBA", "1")
    assert not compiled("grid.points=2048")


def test_a_short_run_does_not_import_numba(installed):
    code = """if True:
        import sys
        from fretsolve import load_case, run
        case = load_case("cases/mode1_similar.yaml", ["grid.points=32", "expect=[]", "load_path=[{P: 400}]"])
        print(len(list(run(case))), "numba" in sys.modules, "scipy" in sys.modules)"""
    child = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert child.stdout.split() == ["1", "False", "False"]


@pytest.mark.parametrize(
    "override",
    [
        "bodies=[{young_modulus: 200 GPa, poisson_ratio: 0.06}, {young_modulus: 200 GPa, poisson_ratio: 0.42}]",
        "surface={ellipsoid: {radius_x: 10 mm, radius_y: 14 mm}}",
    ],
)
def test_a_short_run_with_error_bars_does_not_import_scipy(installed, override):
    code = f"""if True:
        import sys
        from fretsolve import load_case, run_with_error_bars
        case = load_case(
            "cases/mode1_similar.yaml",
            ["grid.points=32", "expect=[]", "load_path=[{{P: 400, increments: 1}}]", {override!r}],
        )
        print(len(list(run_with_error_bars(case))), *(name for name in sys.modules if name.startswith("scipy")))"""
    child = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert child.stdout.split() == ["1"]
