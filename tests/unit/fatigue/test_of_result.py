"""From a result or a file of stresses to cycles."""

from __future__ import annotations

from pathlib import Path

import pytest
from command_line import invoke, result_of
from small_cases import TWO_CYCLES, write_case

from fretsolve.errors import CaseError, FileError
from fretsolve.fatigue.request import FatigueRequest, read_material, stresses_of_cycle
from fretsolve.fatigue.stress_cycle import cycles_of, stresses_beside
from fretsolve.result import open_result
from fretsolve.stress.computed_file import opened_computed
from fretsolve.stress.tractions import TractionHistory

LIMITS = "tension_limit=300 MPa,torsion_limit=190 MPa"


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A result with the stresses of both bodies beside it."""
    case = write_case(tmp_path_factory.mktemp("cycles"), TWO_CYCLES.replace("points: 16", "points: 12"))
    out = result_of(case)
    words = ("--cycle", "last", "--depth", "20 um", "--body", 1, "--body", 2, "-q")
    assert invoke("stress", out, *words).exit_code == 0
    return out


def test_stresses_of_the_last_cycle(out: Path) -> None:
    request = FatigueRequest(read_material(LIMITS), ("findley",), bodies=(2,))
    with open_result(out) as result:
        found = stresses_of_cycle(TractionHistory(result), request)
    assert (found.bodies, list(found.steps)) == ((2,), [6, 7, 8, 9, 10])
    assert found.depths[0] == 0.0


def test_material_is_refused_before_anything_is_computed(out: Path) -> None:
    request = FatigueRequest(read_material("tension_limit=300 MPa"), ("findley",))
    with open_result(out) as result, pytest.raises(CaseError, match="torsion_limit"):
        stresses_of_cycle(TractionHistory(result), request)


@pytest.mark.parametrize(("asked", "found"), [((), [1, 2]), ((1,), [1]), ((2,), [2])])
def test_cycles_of_the_bodies_that_are_asked_for(out: Path, asked: tuple[int, ...], found: list[int]) -> None:
    stresses = out.with_suffix(".stress.h5")
    request = FatigueRequest(read_material(LIMITS), ("findley",), bodies=asked)  # type: ignore[arg-type]
    with opened_computed(stresses) as file:
        cycles = cycles_of(file, stresses, out, request)
    assert list(cycles.of_body) == found
    assert {cycle.chosen for cycle in cycles.of_body.values()} == {(0, 1, 2, 3, 4)}


def test_a_result_is_no_file_of_stresses(out: Path) -> None:
    request = FatigueRequest(read_material(LIMITS), ("findley",))
    with pytest.raises(FileError, match="is not a file of stresses"), opened_computed(out) as file:
        cycles_of(file, out, out, request)


def test_stresses_for_a_while_leave_nothing(tmp_path: Path) -> None:
    with stresses_beside(tmp_path / "out.fatigue.h5") as stresses:
        assert stresses.parent.parent == tmp_path
        stresses.write_bytes(b"x")
    assert list(tmp_path.iterdir()) == []
