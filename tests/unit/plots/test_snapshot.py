"""Pictures of results that failed or are still growing."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from command_line import invoke
from fake_states import fake_header, fake_states
from pictures import heading, image_of, panels

from fretsolve import plots
from fretsolve.plots.snapshot import middle, shown_place
from fretsolve.result import HistoryWriter, Result, open_result
from fretsolve.system.arrays import DoubleArray


def test_failed_and_growing_results(results: dict[str, Result], tmp_path: Path) -> None:
    figure = plots.loop(results["sliding"])
    assert heading(figure).startswith("failed with 4 increments: sliding.h5")
    np.testing.assert_allclose(panels(figure)[0].lines[0].get_ydata(), [0.0, 10.0, 20.0, 30.0], atol=1e-9)
    with HistoryWriter.open(tmp_path / "out.h5", fake_header()) as writer:
        with open_result(tmp_path / "out.h5") as empty, pytest.raises(plots.PictureError, match="no increment yet"):
            plots.loop(empty)
        done = invoke("plot", tmp_path / "out.h5", "--all", "-o", tmp_path / "pictures")
        assert (done.exit_code, done.stderr) == (2, f"{tmp_path}/out.h5: the result has no increment yet\n")
        assert not (tmp_path / "pictures").exists()
        for state in fake_states(4):
            writer.append(state)
        with open_result(tmp_path / "out.h5") as growing:
            figure = plots.contact_map(growing)
            assert heading(figure).startswith("running with 4 increments: made up")
            np.testing.assert_allclose(
                image_of(panels(figure)[0]).compressed(), growing.field("pressure").T[growing.field("zone").T > 0]
            )
            assert len(panels(plots.loop(growing))) >= 1


class TwoSpots:
    """The fields of a snapshot with two spots away from the middle, the second with the larger pressure."""

    def __init__(self) -> None:
        x = y = np.linspace(-4.0, 4.0, 9)
        self.pressure = np.zeros((9, 9))
        self.pressure[1, 4], self.pressure[7, 4], self.pressure[7, 5] = 1.0, 2.0, 3.0
        self.contact = self.pressure > 0.0
        self.result = SimpleNamespace(x=x, y=y, fields=("pressure",))

    def field(self, name: str) -> DoubleArray:
        return self.pressure


def test_place_that_is_shown_is_in_contact() -> None:
    spots: Any = TwoSpots()
    assert middle(spots) == (0.0, 0.0)
    assert shown_place(spots) == (3.0, 1.0)
    spots.contact[4, 4] = True
    assert shown_place(spots) == (0.0, 0.0)
