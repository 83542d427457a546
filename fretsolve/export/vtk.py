"""Deformed surfaces and fields for ParaView: a file of VTK's XML format per body and increment, and one of all times.

The format is that of structured grids (``.vts``) with binary data appended, compressed by zlib: see VTK's "XML file
formats". Points are the centres of the cells. Numbers are of single precision, which is more than a picture shows.
"""

from __future__ import annotations

import sys
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from fretsolve.export.deformed_surfaces import BodySurface, FlatError, Surfaces
from fretsolve.system import atomic_files

if TYPE_CHECKING:
    from fretsolve.result import Result

Arrays = Mapping[str, NDArray[Any]]

BLOCK_BYTES = 2**20
COMPRESSION_LEVEL = 1
HIDDEN_POINT = 2
"""VTK's mark of points that are not to be shown, in the array ``vtkGhostType``."""

_ENDIAN = "LittleEndian" if sys.byteorder == "little" else "BigEndian"
_TYPES = {"f4": "Float32", "u1": "UInt8"}


def write_vtk(result: Result, steps: Sequence[int], path: Path) -> list[str]:
    """Write ``path`` (.pvd), which ParaView opens, and the grids of `steps` in a folder beside it.

    Returns what a person should hear: why the surfaces are left flat. Raises OSError, FileError.
    """
    folder = path.with_name(f"{path.stem}.vtk")
    folder.mkdir(exist_ok=True)
    notes: list[str] = []
    surfaces: Surfaces | None = None
    try:
        surfaces = Surfaces(result)
    except FlatError as error:
        notes.append(f"the surfaces are left flat: {error}")
    entries = []
    for step in steps:
        fields = point_data(result, step)
        for part, body in enumerate(surfaces.at(step) if surfaces is not None else [_flat(result)]):
            grid = folder / f"{body.name.replace(' ', '_')}.{step:06d}.vts"
            write_grid(grid, body, fields, step)
            entries.append((step, part, body.name, f"{folder.name}/{grid.name}"))
    with atomic_files.new_file(path, durable=False) as file:
        file.write(_collection(entries).encode())
    return notes


def point_data(result: Result, step: int) -> dict[str, NDArray[Any]]:
    """The fields of an increment, ``(nx, ny)``; shear and slip as vectors ``(3, nx, ny)``."""
    found: dict[str, NDArray[Any]] = {}
    for name in result.fields:
        vector = name.removesuffix("_x").removesuffix("_y")
        if vector == name:
            found[name] = result.field(name, step)
        elif vector not in found:
            components = result.field(vector, step)
            found[vector] = np.concatenate([components, np.zeros((1, *components.shape[1:]))])
    return found


def _flat(result: Result) -> BodySurface:
    points = np.zeros((3, len(result.x), len(result.y)))
    points[0], points[1] = result.x[:, None], result.y[None, :]
    return BodySurface("plane", points, np.zeros_like(points), np.ones(points.shape[1:], bool))


def write_grid(path: Path, body: BodySurface, fields: Arrays, time: float) -> None:
    """Write a structured grid with its point data. Raises OSError."""
    nx, ny = body.material.shape
    extent = f"0 {nx - 1} 0 {ny - 1} 0 0"
    blobs: list[bytes] = []
    data = dict(fields) | {"displacement": body.displacement}
    if not body.material.all():
        data["vtkGhostType"] = np.where(body.material, 0, HIDDEN_POINT).astype(np.uint8)
    point_data = "".join(_data_array(name, values, blobs) for name, values in data.items())
    points = _data_array("Points", body.points, blobs)
    head = (
        '<?xml version="1.0"?>\n'
        f'<VTKFile type="StructuredGrid" version="1.0" byte_order="{_ENDIAN}" header_type="UInt64"'
        ' compressor="vtkZLibDataCompressor">\n'
        f'<StructuredGrid WholeExtent="{extent}">\n'
        f'<FieldData><DataArray type="Float64" Name="TimeValue" NumberOfTuples="1" format="ascii">{time:g}</DataArray>'
        f'</FieldData>\n<Piece Extent="{extent}">\n'
        f"<PointData>\n{point_data}</PointData>\n<Points>\n{points}</Points>\n</Piece>\n</StructuredGrid>\n"
        '<AppendedData encoding="raw">\n_'
    )
    with atomic_files.new_file(path, durable=False) as file:
        file.write(head.encode())
        for blob in blobs:
            file.write(blob)
        file.write(b"\n</AppendedData>\n</VTKFile>\n")


def _data_array(name: str, values: NDArray[Any], blobs: list[bytes]) -> str:
    """The element of an array ``(nx, ny)`` or ``(3, nx, ny)``, whose data follow on `blobs`, to which they are added.

    In VTK x runs fastest, and the components of a vector stand together.
    """
    dtype = np.uint8 if values.dtype == np.uint8 else np.float32
    in_order = np.ascontiguousarray(values.transpose(2, 1, 0) if values.ndim == 3 else values.T, dtype)
    components = values.shape[0] if values.ndim == 3 else 1
    offset = sum(map(len, blobs))
    blobs.append(_compressed(in_order))
    kind = _TYPES[in_order.dtype.str[1:]]
    return (
        f'<DataArray type="{kind}" Name={quoteattr(name)} NumberOfComponents="{components}" format="appended"'
        f' offset="{offset}"/>\n'
    )


def _compressed(values: NDArray[Any]) -> bytes:
    """Blocks compressed one by one, after their number and sizes."""
    content = values.tobytes()
    blocks = [
        zlib.compress(content[start : start + BLOCK_BYTES], COMPRESSION_LEVEL)
        for start in range(0, len(content), BLOCK_BYTES)
    ]
    sizes = [len(blocks), BLOCK_BYTES, len(content) % BLOCK_BYTES, *map(len, blocks)]
    return np.array(sizes, np.uint64).tobytes() + b"".join(blocks)


def _collection(entries: Sequence[tuple[int, int, str, str]]) -> str:
    """The file that tells ParaView which grids belong to which time."""
    lines = [
        f'<DataSet timestep="{step}" part="{part}" name={quoteattr(name)} file={quoteattr(file)}/>'
        for step, part, name, file in entries
    ]
    return "\n".join(
        [
            '<?xml version="1.0"?>',
            f'<VTKFile type="Collection" version="1.0" byte_order="{_ENDIAN}">',
            "<Collection>",
            *lines,
            "</Collection>",
            "</VTKFile>",
            "",
        ]
    )
