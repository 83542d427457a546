"""Height maps of worn surfaces."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
from command_line import result_of
from small_cases import WORN, write_case

from fretsolve.errors import CaseError
from fretsolve.export.tables import require_wear, write_heights
from fretsolve.result import open_result


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A worn result on a grid beside the middle."""
    text = WORN.replace("points: 24", "points: [12, 10], size: [1.2 mm, 1.1 mm], center: [0.05 mm, -0.02 mm]")
    return result_of(write_case(tmp_path_factory.mktemp("worn"), text))


def test_maps_have_their_place_and_the_worn_separation(out: Path, tmp_path: Path) -> None:
    target = tmp_path / "maps.hdf5"
    with open_result(out) as result:
        step = result.increments - 1
        require_wear(result, step)
        write_heights(result, step, target, exclusive=True)
        depth = result.field("wear_depth", step).astype(float)
        sphere = (result.x[:, None] ** 2 + result.y**2) / 20.0
    assert depth.max() > 0.0
    with h5py.File(target) as file:
        for values in file.values():
            assert values.attrs["units"] == "mm"
            assert values.attrs["spacing"] == pytest.approx((0.1, 0.11))
            assert values.attrs["center"] == pytest.approx((0.05, -0.02))
        np.testing.assert_array_equal(file["wear_depth"], depth)
        np.testing.assert_allclose(file["separation"], sphere + depth, rtol=1e-12)


def test_an_increment_without_a_worn_depth_is_refused(out: Path) -> None:
    with open_result(out) as result, pytest.raises(CaseError, match="the worn depth is not stored"):
        require_wear(result, result.increments)
