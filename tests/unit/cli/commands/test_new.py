"""``fretsolve new``: commented cases that validate without a doubt, and run as they say."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from command_line import invoke, refused

from fretsolve import load_case
from fretsolve.case.templates import TEMPLATES

SMALLER = {"rough": ["grid.points=48"], "mode2": ["grid.points=64"], "mode3": ["grid.points=64"]}
"""Settings that keep the checks cheap."""


@pytest.mark.parametrize("kind", TEMPLATES)
def test_every_template_is_without_doubt_and_comes_out_as_it_expects(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = invoke("new", kind)
    assert (result.exit_code, result.stderr) == (0, "")
    assert result.stdout.splitlines()[-1] == f"{kind}.yaml"
    case = Path(f"{kind}.yaml")
    assert case.read_text().count("#") > 8
    validated = invoke("validate", case)
    assert (validated.exit_code, validated.stderr) == (0, "")
    words = [word for value in SMALLER.get(kind, []) for word in ("--set", value)]
    if load_case(case).expect:
        assert "warning" not in invoke("check", case, *words).output
    else:
        assert invoke("run", case, *words).stdout.endswith("complete: rough.h5, 7 increments\n")


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    case, heights = tmp_path / "my.case.yaml", tmp_path / "my.case.heights.txt"
    heights.write_text("mine")
    told = f"{heights}: exists: it is not touched; choose another name with -o\n"
    assert refused(2, "new", "rough", "-o", case) == told
    assert not case.exists()
    heights.unlink()
    assert invoke("new", "rough", "-o", case).stdout == f"{heights}\n{case}\n"
    assert yaml.safe_load(case.read_text())["surface"][1]["heights"]["file"] == heights.name
    before = case.read_text()
    assert refused(2, "new", "hertz", "-o", case)
    assert case.read_text() == before


def test_wrong_names(tmp_path: Path) -> None:
    kinds = "'mode4' is not one of 'hertz', 'mode1', 'mode2', 'mode3', 'gross-slip', 'rough', 'line', 'wear'"
    assert kinds in refused(2, "new", "mode4")
    assert invoke("new").exit_code == 2
    result, missing = tmp_path / "case.h5", tmp_path / "none" / "case.yaml"
    told = f"{result}: the name of a case must end in .yaml or .yml\n"
    assert refused(2, "new", "hertz", "-o", result) == told
    told = f"{missing}: cannot be written: No such file or directory\n"
    assert refused(4, "new", "hertz", "-o", missing) == told
