"""The stress of a result by layers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from command_line import result_of
from small_cases import LOOP, write_case

from fretsolve import open_result
from fretsolve.errors import CaseError
from fretsolve.stress import request as requests
from fretsolve.stress.evaluate import layers
from fretsolve.stress.request import disk_problem, memory_problem, stress_request
from fretsolve.stress.tractions import TractionHistory, bounding_window


def test_groups_of_increments_give_the_same_bits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the spectra of all increments do not fit, they are computed in groups."""
    with open_result(result_of(write_case(tmp_path, LOOP))) as result:
        tractions = TractionHistory(result)
        request = stress_request(tractions, result.steps, bodies=(1, 2), depths=(0.0, 0.05))
        assert request.group == len(result.steps)
        whole = {(one.body, one.depth_index, one.step_index): one.stress for one in layers(tractions, request)}
        monkeypatch.setattr(requests, "SPECTRA_BYTES", 1)
        assert request.group == 1
        parts = {(one.body, one.depth_index, one.step_index): one.stress for one in layers(tractions, request)}
        assert whole.keys() == parts.keys()
        for key, stress in whole.items():
            np.testing.assert_array_equal(parts[key], stress)
        assert "fewer depths or increments" in str(disk_problem(request, 100))
        assert disk_problem(request, None) is None
        assert memory_problem(request, 1) is None
        with pytest.raises(CaseError, match="the depth -1 mm is not one"):
            stress_request(tractions, result.steps, depths=(-1.0,))


def test_the_window_of_cells() -> None:
    cells = np.zeros((7, 5), bool)
    assert bounding_window(cells) == (slice(3, 4), slice(2, 3))
    cells[2, 1] = cells[5, 1] = True
    assert bounding_window(cells) == (slice(2, 6), slice(1, 2))
