"""Cases from a dict, and the public functions that an editor lists."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

import fretsolve
from fretsolve.case.loading import read_case
from fretsolve.errors import CaseError, CaseErrors

DATA = {
    "bodies": ("rigid", {"young_modulus": "200 GPa", "poisson_ratio": np.float64(0.3)}),
    "surface": {"sphere": {"radius": "10 mm"}},
    "grid": {"points": np.int64(16), "size": np.array([1.0, 1.0])},
    "load_path": [{"P": 400}],
}


def test_it_is_the_case_of_the_file_with_these_keys(tmp_path: Path) -> None:
    path = tmp_path / "case.yaml"
    case = fretsolve.case_from_dict(DATA)
    path.write_text(case.source.text)
    assert read_case(path).case() == case
    assert case.grid.points == (16, 16)
    assert yaml.safe_load(case.source.text)["bodies"][0] == "rigid"


def test_files_are_relative_to_the_folder(tmp_path: Path) -> None:
    np.save(tmp_path / "map.npy", np.zeros((4, 4)))
    heights = {"heights": {"file": Path("map.npy"), "spacing": "1 mm"}}
    case = fretsolve.case_from_dict(DATA | {"surface": heights}, tmp_path)
    assert case.surface[0].file == tmp_path / "map.npy"


def test_problems_name_their_keys() -> None:
    with pytest.raises(CaseError, match=r"^grid.points: 0 is too small; a whole number >= 1 is needed$"):
        fretsolve.case_from_dict(DATA | {"grid": {"points": 0}})
    with pytest.raises(CaseErrors, match=r"^friction: -1 is out of range; .*\nstage.1.P: '4 mm' is a length; .*$"):
        fretsolve.case_from_dict(DATA | {"friction": -1, "load_path": [{"P": "4 mm"}]})
    with pytest.raises(TypeError, match="cannot stand in a case"):
        fretsolve.case_from_dict(DATA | {"title": object()})


def test_it_is_solved() -> None:
    (state,) = fretsolve.run(fretsolve.case_from_dict(DATA))
    assert pytest.approx(400.0) == state.summary.P


def test_public_functions_are_listed() -> None:
    assert set(fretsolve.__all__) <= set(dir(fretsolve))
    assert {"load_case", "case_from_dict", "run", "run_with_error_bars", "open_result"} <= set(dir(fretsolve))


def test_editors_know_the_same_functions() -> None:
    stub = Path(fretsolve.__file__).with_suffix(".pyi").read_text(encoding="utf-8")
    functions = {name for name in fretsolve.__all__ if name[0] != "_"}
    assert functions == {line.split()[-1] for line in stub.splitlines() if line.startswith("from ")}
    assert all(getattr(fretsolve, name).__module__ in stub or name == "open_result" for name in functions)
