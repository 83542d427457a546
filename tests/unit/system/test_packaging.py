"""All places that describe the package agree, and its oldest dependencies are those that are tested."""

from __future__ import annotations

import ast
import re
import tomllib
from pathlib import Path

import yaml

import fretsolve

ROOT = Path(__file__).parents[3]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def lower_bounds(requirements: list[str]) -> dict[str, str]:
    matches = [re.fullmatch(r"([\w-]+)>=([\d.]+)", requirement) for requirement in requirements]
    assert all(matches), requirements
    return {match[1]: match[2] for match in matches if match}


def test_version_stands_in_one_place_and_the_citation_follows() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert PROJECT["dynamic"] == ["version"]
    assert str(citation["version"]) == fretsolve.__version__
    assert citation["license"] == PROJECT["license"]


def test_public_functions_and_classes_say_what_they_are() -> None:
    """Loops for numba are described by their namesakes in NumPy."""
    package = Path(fretsolve.__file__).parent
    silent = [
        f"{path.relative_to(package)}:{node.lineno} {node.name}"
        for path in sorted(package.rglob("*.py"))
        for node in ast.parse(path.read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef | ast.ClassDef)
        and node.name[0] != "_"
        and not node.name.endswith("_loops")
        and ast.get_docstring(node) is None
    ]
    assert silent == []


def test_package_is_typed() -> None:
    assert (Path(fretsolve.__file__).parent / "py.typed").exists()


def test_oldest_dependencies_are_those_that_are_tested() -> None:
    pinned = dict(re.findall(r"^([\w-]+)==([\d.]+)", (ROOT / ".ci" / "oldest.txt").read_text(), re.MULTILINE))
    extras = PROJECT["optional-dependencies"]
    allowed = lower_bounds([*PROJECT["dependencies"], *extras["plot"], *extras["fast"], *extras["xarray"]])
    assert allowed.keys() <= pinned.keys()
    for name, bound in allowed.items():
        assert pinned[name].startswith(bound), name
