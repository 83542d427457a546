"""Puts this folder on the import path, for the helpers that several tests share, and keeps plans out of the home."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

# A background job of a plain shell ignores SIGINT, and so would the processes that the tests start and interrupt.
signal.signal(signal.SIGINT, signal.default_int_handler)

# The cases of the tests are too small to pay for loading numba, but its kernels are to be tested where it is installed.
os.environ.setdefault("FRETSOLVE_NUMBA", "1")


@pytest.fixture(scope="session", autouse=True)
def _own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """FFTW's plans of the tests are kept for the session, not in the user's cache folder."""
    folder = tmp_path_factory.mktemp("cache")
    before = os.environ.get("FRETSOLVE_CACHE")
    os.environ["FRETSOLVE_CACHE"] = str(folder)
    yield folder
    if before is None:
        del os.environ["FRETSOLVE_CACHE"]
    else:
        os.environ["FRETSOLVE_CACHE"] = before


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Give each worker a stretch of tests, since neighbours share what they have computed: 10 % less processor time."""
    if config.getoption("dist") != "load":
        return None
    from xdist.scheduler import WorkStealingScheduling

    return WorkStealingScheduling(config, log)
