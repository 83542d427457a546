"""Results that the tests of pictures and of exported files share, and the handlers of signals."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from command_line import invoke
from small_cases import DRAWN, WORN, write_case

from fretsolve.result import Result, open_result
from fretsolve.system.signals import SIGNALS


@pytest.fixture(scope="session")
def result_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder with the results of `DRAWN`."""
    place = tmp_path_factory.mktemp("plots")
    for name, text in DRAWN.items():
        done = invoke("run", write_case(place, text, f"{name}.yaml"), "-q")
        assert done.exit_code == (3 if name == "sliding" else 0), done.stderr
    return place


@pytest.fixture(scope="session")
def worn(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file of a worn result."""
    path = write_case(tmp_path_factory.mktemp("worn"), WORN)
    assert invoke("run", path, "-q").exit_code == 0
    return path.with_suffix(".h5")


@pytest.fixture
def results(result_folder: Path) -> Iterator[dict[str, Result]]:
    """The results of `DRAWN`, open."""
    opened = {name: open_result(result_folder / f"{name}.h5") for name in DRAWN}
    yield opened
    for result in opened.values():
        result.close()


@pytest.fixture
def handlers() -> Iterator[None]:
    """Restore the handlers of signals after a test, since a stop leaves signals ignored."""
    before = {number: signal.getsignal(number) for number in SIGNALS}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)
