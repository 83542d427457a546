"""Volumes of stresses for ParaView, read back from their files."""

from __future__ import annotations

import re
import zlib
from pathlib import Path

import h5py
import numpy as np
import pytest
from command_line import invoke, result_of
from small_cases import LOOP, write_case

from fretsolve.post.export.vtk import write_volumes
from fretsolve.post.stress.computed_file import opened_computed
from fretsolve.system.arrays import DoubleArray

DEPTHS = (0.01, 0.05)


def arrays_of(grid: Path) -> dict[str, DoubleArray]:
    """Return the arrays of a grid as they lie in the file, x fastest."""
    head, _, data = grid.read_bytes().partition(b'<AppendedData encoding="raw">\n_')
    found = {}
    for name, offset in re.findall(
        r'Name="(\w+)" NumberOfComponents="\d" format="appended" offset="(\d+)"', head.decode()
    ):
        start = int(offset)
        size = int(np.frombuffer(data[start + 24 : start + 32], np.uint64)[0])
        found[name] = np.frombuffer(zlib.decompress(data[start + 32 : start + 32 + size]), np.float32)
    return found


@pytest.fixture(scope="module")
def stresses(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The stresses of both bodies after the last increment of a loop."""
    out = result_of(write_case(tmp_path_factory.mktemp("volumes"), LOOP))
    words = ("--body", 1, "--body", 2, "--depth", "10 um", "--depth", "50 um", "--step", 3, "-q")
    assert invoke("stress", out, *words).exit_code == 0
    return out.with_suffix(".stress.h5")


def test_values_lie_at_their_places(stresses: Path, tmp_path: Path) -> None:
    """z points upwards, into body 1; components keep the axes of the result."""
    index = tmp_path / "s.pvd"
    with opened_computed(stresses) as computed:
        assert computed is not None
        write_volumes(computed, index, exclusive=True)
        with pytest.raises(FileExistsError):
            write_volumes(computed, index, exclusive=True)
    files = re.findall(r'timestep="(\d)" part="(\d)" name="([^"]+)" file="([^"]+)"', index.read_text())
    assert files == [("3", str(body - 1), f"body {body}", f"s.vtk/stress_body_{body}.000003.vtr") for body in (1, 2)]
    with h5py.File(stresses) as file:
        for body, heights in ((1, DEPTHS), (2, (-DEPTHS[1], -DEPTHS[0]))):
            group, found = file[f"stress/body_{body}"], arrays_of(tmp_path / files[body - 1][3])
            for name, expected in (("x", group["x"]), ("y", group["y"]), ("z", heights)):
                np.testing.assert_allclose(found[name], expected, rtol=1e-6)
            for name in ("xx", "xz"):
                rising = group[name][0][:: 1 if body == 1 else -1]
                np.testing.assert_array_equal(found[name], rising.transpose(0, 2, 1).ravel())
            xx, yy, zz, xy, xz, yz = (found[name].astype(float) for name in ("xx", "yy", "zz", "xy", "xz", "yz"))
            squares = 0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3.0 * (xy**2 + xz**2 + yz**2)
            np.testing.assert_allclose(found["von_mises"], np.sqrt(squares), rtol=1e-4)
            largest = np.linalg.eigvalsh(np.moveaxis([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], -1, 0))[:, -1]
            np.testing.assert_allclose(found["first_principal"], largest, atol=1e-3)
