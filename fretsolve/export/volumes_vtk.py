"""Write stresses or fatigue parameters as volumes for ParaView: a grid per body and increment, and an index.

The format is VTK's XML (``.vtr``), as for the surfaces. Body 1 lies above z = 0 and body 2 below, as the surfaces do.
Stress components keep the axes of the result, in which z points into body 2; normals of planes have the z of the grid.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fretsolve.export.vtk import data_array, grids_folder, write_grid, write_index
from fretsolve.fatigue.fatigue_file import BodyFatigue, fatigue_bodies
from fretsolve.stress.computed_file import ComputedFile
from fretsolve.stress.invariants import principal, von_mises
from fretsolve.stress.stress_file import BodyStress, bodies_of
from fretsolve.system.arrays import DoubleArray

VOLUME_NAME = re.compile(r".+\.[0-9]{6,}\.vtr(\.[0-9a-f]{16}\.tmp)?")
"""Names of the grids of volumes, also of those that are being written."""


@dataclass(frozen=True, eq=False)
class _Volume:
    """A volume of a body. fields: ``(depths, nx, ny)``, or ``(3, depths, nx, ny)`` in the axes of the result."""

    kind: str
    body: int
    step: int
    x: DoubleArray
    y: DoubleArray
    depths: DoubleArray
    fields: Mapping[str, DoubleArray]


def write_volumes(computed: ComputedFile, source: Path, path: Path, *, exclusive: bool) -> None:
    """Write ``path`` (.pvd), which ParaView opens, and the grids of an open file of `source` in a folder beside it.

    exclusive: replace no index. Raises OSError, FileError.
    """
    folder = grids_folder(path)
    folder.mkdir(exist_ok=True)
    grids = []
    volumes = _stresses(computed, source) if computed.kind == "stress" else _parameters(computed, source)
    for volume in volumes:
        grid = folder / f"{volume.kind}_body_{volume.body}.{volume.step:06d}.vtr"
        _write_grid(grid, volume)
        grids.append((grid, volume.step, volume.body - 1, f"body {volume.body}"))
    write_index(path, grids, exclusive=exclusive)


def _stresses(computed: ComputedFile, source: Path) -> Iterator[_Volume]:
    for number, body in bodies_of(computed).items():
        for place, step in enumerate(body.steps.tolist()):
            yield _Volume("stress", number, step, body.x, body.y, body.depths, _stress_fields(body, place))


def _stress_fields(body: BodyStress, place: int) -> dict[str, DoubleArray]:
    """Return the stored components of an increment, and invariants if all six are there."""
    stress = body.stress(place).astype(np.float64)
    fields: dict[str, DoubleArray] = dict(zip(body.components, stress, strict=True))
    if len(fields) == 6:
        fields |= {"von_mises": von_mises(stress), "first_principal": principal(stress)[0]}
    return fields


def _parameters(computed: ComputedFile, source: Path) -> Iterator[_Volume]:
    for number, body in fatigue_bodies(computed).items():
        yield _Volume("fatigue", number, body.steps[-1], body.x, body.y, body.depths, _fatigue_fields(body))


def _fatigue_fields(body: BodyFatigue) -> dict[str, DoubleArray]:
    """Return the parameters with what follows from them; normals as vectors, endless lives as the largest number."""
    fields: dict[str, DoubleArray] = {}
    for name in body.criteria:
        for suffix in ("", "_utilisation", "_life", "_normal"):
            if name + suffix not in body.group:
                continue
            values = np.asarray(body.field(name + suffix), np.float64)
            if suffix == "_life":
                values = np.minimum(values, float(np.finfo(np.float32).max))
            fields[name + suffix] = np.moveaxis(values, -1, 0) if suffix == "_normal" else values
    return fields


def _write_grid(path: Path, volume: _Volume) -> None:
    """Write a rectilinear grid with its point data. Raises OSError."""
    up = volume.body == 1
    blobs: list[bytes] = []
    point_data = "".join(data_array(name, _ordered(field, up=up), blobs) for name, field in volume.fields.items())
    axes: tuple[NDArray[np.float64], ...] = (volume.x, volume.y, volume.depths if up else -volume.depths[::-1])
    coordinates = "".join(data_array(name, values, blobs) for name, values in zip("xyz", axes, strict=True))
    extent = " ".join(f"0 {len(values) - 1}" for values in axes)
    write_grid(
        path,
        "RectilinearGrid",
        f'<RectilinearGrid WholeExtent="{extent}">\n<Piece Extent="{extent}">\n<PointData>\n{point_data}</PointData>\n'
        f"<Coordinates>\n{coordinates}</Coordinates>\n</Piece>\n</RectilinearGrid>\n",
        blobs,
    )


def _ordered(field: DoubleArray, *, up: bool) -> DoubleArray:
    """Return a field as `data_array` takes it: z rises, and of vectors z is that of the grid, upwards."""
    rising = field if up else field[..., ::-1, :, :]
    if field.ndim == 3:
        return np.asarray(rising.transpose(1, 2, 0).reshape(-1, order="F"))
    turned = rising * np.array([1.0, 1.0, -1.0])[:, None, None, None]
    return np.asarray(turned.transpose(0, 2, 3, 1).reshape(3, -1, 1, order="F"))
