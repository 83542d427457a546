"""Runs of many short processes, which need not load numba's compiler: it would take most of their time."""

from __future__ import annotations

from collections.abc import Iterator

import pytest


@pytest.fixture(scope="module", autouse=True)
def _without_compiled_kernels() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("FRETSOLVE_NUMBA", "0")
        yield
