"""The numbers of a compiled kernel do not depend on which kernels the process has called before."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

from fretsolve.contact.kernels import cg
from fretsolve.elastic.kernels import compiling

pytest.importorskip("numba")

MODULES = sorted(path for one in (compiling, cg) for path in Path(one.__file__).parent.glob("*.py"))

CALLS = """
import sys
import numpy as np
from fretsolve.contact.kernels import friction
from fretsolve.elastic.kernels.compiling import form_of

loops = form_of(friction, compiled=True)

random = np.random.default_rng(1)
shear, normal = random.normal(size=(2, 2, 48, 48))
weight, axis = random.random((48, 48)), random.normal(size=48)
calls = {
    "sum_motions": lambda: loops.sum_motions(0, 48, shear, axis, axis),
    "gram": lambda: loops.gram(0, 48, weight, normal, axis, axis),
    "balance": lambda: loops.balance(0, 48, shear, weight, normal, axis, axis),
}
for name in sys.argv[1:]:
    print(name, calls[name]())
"""


def numbers(*order: str) -> list[str]:
    """Return what each kernel gives in a new process that calls them in this order."""
    process = subprocess.run([sys.executable, "-c", CALLS, *order], capture_output=True, text=True, check=True)
    return sorted(process.stdout.splitlines())


@pytest.mark.slow
def test_numbers_of_a_kernel_do_not_depend_on_the_ones_called_before() -> None:
    found = numbers("sum_motions", "gram", "balance")
    assert len(found) == 3
    assert numbers("balance", "gram", "sum_motions") == found


MARKS = {"compiled", "exact", "inlined"}


def decorator(function: ast.FunctionDef) -> str:
    return "".join(one.id for one in function.decorator_list if isinstance(one, ast.Name))


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.stem)
def test_what_kernels_call_is_put_into_them(path: Path) -> None:
    functions = {one.name: one for one in ast.parse(path.read_text()).body if isinstance(one, ast.FunctionDef)}
    kernels = [one for one in functions.values() if decorator(one) in MARKS]
    called = {
        node.func.id
        for one in kernels
        for node in ast.walk(one)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    }
    decorators = {decorator(functions[name]) for name in called if name in functions}
    assert decorators <= {"inlined", "exact"}  # exact functions give the same bits wherever their code stands
