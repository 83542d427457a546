"""Results that the tests of pictures share."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from command_line import invoke
from small_cases import DRAWN, write_case

from fretsolve.result import Result, open_result


@pytest.fixture(scope="session")
def result_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder with the results of `DRAWN`."""
    place = tmp_path_factory.mktemp("plots")
    for name, text in DRAWN.items():
        done = invoke("run", write_case(place, text, f"{name}.yaml"), "-q")
        assert done.exit_code == (3 if name == "sliding" else 0), done.stderr
    return place


@pytest.fixture
def results(result_folder: Path) -> Iterator[dict[str, Result]]:
    """The results of `DRAWN`, open."""
    opened = {name: open_result(result_folder / f"{name}.h5") for name in DRAWN}
    yield opened
    for result in opened.values():
        result.close()
