"""All places that describe the package agree, and its oldest dependencies are those that are tested."""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Callable
from pathlib import Path

import yaml

import fretsolve
from fretsolve.kernels.on_grid import Steps

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
    """Most kernels for numba are described by their namesakes for NumPy, whole steps of CG by `Steps`."""
    package = Path(fretsolve.__file__).parent
    silent = [
        f"{path.relative_to(package)}:{node.lineno} {node.name}"
        for path in sorted(package.rglob("*.py"))
        if not path.stem.endswith("_numba")
        for node in ast.parse(path.read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name[0] != "_" and ast.get_docstring(node) is None
    ]
    assert silent == []
    for compiled in sorted(package.glob("kernels/*_numba.py")):
        plain = compiled.with_name(compiled.name.replace("_numba", "_numpy"))
        steps = set(vars(Steps)) if compiled.stem == "cg_numba" else set()
        described = _public(plain) if plain.exists() else set()  # zones have no namesakes, so they describe themselves
        assert _public(compiled, ast.get_docstring) <= described | steps


def _public(path: Path, left_out: Callable[[ast.FunctionDef], object] = lambda _: False) -> set[str]:
    found = ast.parse(path.read_text(encoding="utf-8")).body
    functions = [node for node in found if isinstance(node, ast.FunctionDef) and node.name[0] != "_"]
    return {node.name for node in functions if not left_out(node)}


def test_package_is_typed() -> None:
    assert (Path(fretsolve.__file__).parent / "py.typed").exists()


def test_oldest_dependencies_are_those_that_are_tested() -> None:
    pinned = dict(re.findall(r"^([\w-]+)==([\d.]+)", (ROOT / ".ci" / "oldest.txt").read_text(), re.MULTILINE))
    extras = PROJECT["optional-dependencies"]
    allowed = lower_bounds([*PROJECT["dependencies"], *extras["plot"], *extras["fast"], *extras["xarray"]])
    assert allowed.keys() <= pinned.keys()
    for name, bound in allowed.items():
        assert pinned[name].startswith(bound), name
