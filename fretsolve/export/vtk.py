"""Write deformed surfaces and fields for ParaView: a file of VTK's XML format per body and increment, and an index.

The format is that of structured grids (``.vts``) with binary data appended, compressed by zlib: see VTK's "XML file
formats". Points are the centres of the cells. Numbers are of single precision, which is more than a picture shows.
"""

from __future__ import annotations

import re
import sys
import zlib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from fretsolve.errors import CaseError, FileError
from fretsolve.export.deformed_surfaces import BodySurface, DeformedSurfaces, FlatError
from fretsolve.export.selection import stored_names
from fretsolve.result import Result
from fretsolve.system import atomic_files
from fretsolve.system.files import require_utf8

BYTE_ORDER = "LittleEndian" if sys.byteorder == "little" else "BigEndian"


GRID_NAME = re.compile(r".+\.[0-9]{6,}\.vts(\.[0-9a-f]{16}\.tmp)?")


def grids_folder(path: Path) -> Path:
    """Return the folder of the grids that belong to the index `path`."""
    return path.with_name(f"{path.stem}.vtk")


def require_own_grids(path: Path, names: re.Pattern[str] = GRID_NAME, *, overwrite: bool) -> None:
    """Raise CaseError or FileError if the folder of the grids of `path` is a link, or holds other files than `names`.

    overwrite: whether grids in it may be replaced. Raises OSError.
    """
    folder = grids_folder(path)
    require_utf8(folder.name, path)
    if folder.is_symlink():
        raise FileError("is a link, which is not followed; give another name with -o", folder)
    there = [one.name for one in folder.iterdir()] if folder.exists() else []
    if not all(map(names.fullmatch, there)):
        raise FileError("holds other files than grids; give another name with -o", folder)
    if there and not overwrite:
        raise CaseError("holds grids: --overwrite replaces them, or give another name with -o", (), folder)


def write_vtk(result: Result, steps: Sequence[int], path: Path, *, exclusive: bool) -> list[str]:
    """Write ``path`` (.pvd), which ParaView opens, and the grids of `steps` in a folder beside it.

    Returns warnings: why the surfaces are left flat. Raises OSError, FileError.
    """
    folder = grids_folder(path)
    folder.mkdir(exist_ok=True)
    try:
        surfaces, warnings = DeformedSurfaces(result), []
    except FlatError as error:
        surfaces, warnings = None, [f"the surfaces are left flat: {error}"]
    grids = []
    for step in steps:
        fields = _point_data(result, step)
        for part, body in enumerate(surfaces.at(step) if surfaces is not None else [_flat(result)]):
            grid = folder / f"{body.name.replace(' ', '_')}.{step:06d}.vts"
            _write_grid(grid, body, fields, step)
            grids.append((grid, step, part, body.name))
    write_index(path, grids, exclusive=exclusive)
    return warnings


def write_index(path: Path, grids: Iterable[tuple[Path, int, int, str]], *, exclusive: bool) -> None:
    """Write the .pvd that ParaView opens; grids: in a folder beside it, each with increment, part and name."""
    index = ['<?xml version="1.0"?>', f'<VTKFile type="Collection" version="1.0" byte_order="{BYTE_ORDER}">']
    index.append("<Collection>")
    for grid, step, part, name in grids:
        file = quoteattr(f"{grid.parent.name}/{grid.name}")
        index.append(f'<DataSet timestep="{step}" part="{part}" name={quoteattr(name)} file={file}/>')
    with atomic_files.new_file(path, durable=False, exclusive=exclusive) as written:
        written.write("\n".join([*index, "</Collection>", "</VTKFile>", ""]).encode())


def _point_data(result: Result, step: int) -> dict[str, NDArray[Any]]:
    """Return the fields of an increment, ``(nx, ny)``, shear and slip as vectors ``(3, nx, ny)``."""
    found: dict[str, NDArray[Any]] = {}
    for name in stored_names(result):
        values = result.field(name, step)
        found[name] = np.concatenate([values, np.zeros_like(values[:1])]) if values.ndim == 3 else values
    return found


def _flat(result: Result) -> BodySurface:
    points = np.zeros((3, len(result.x), len(result.y)))
    points[0], points[1] = result.x[:, None], result.y[None, :]
    return BodySurface("plane", points, np.zeros_like(points), np.ones(points.shape[1:], bool))


def _write_grid(path: Path, body: BodySurface, fields: Mapping[str, NDArray[Any]], time: float) -> None:
    """Write a structured grid with its point data. Raises OSError."""
    nx, ny = body.material.shape
    extent = f"0 {nx - 1} 0 {ny - 1} 0 0"
    blobs: list[bytes] = []
    data = dict(fields) | {"displacement": body.displacement}
    if not body.material.all():
        data["vtkGhostType"] = np.where(body.material, 0, 2).astype(np.uint8)  # 2: hidden
    point_data = "".join(data_array(name, values, blobs) for name, values in data.items())
    points = data_array("Points", body.points, blobs)
    write_grid(
        path,
        "StructuredGrid",
        f'<StructuredGrid WholeExtent="{extent}">\n'
        f'<FieldData><DataArray type="Float64" Name="TimeValue" NumberOfTuples="1" format="ascii">{time:g}</DataArray>'
        f'</FieldData>\n<Piece Extent="{extent}">\n'
        f"<PointData>\n{point_data}</PointData>\n<Points>\n{points}</Points>\n</Piece>\n</StructuredGrid>\n",
        blobs,
    )


def write_grid(path: Path, kind: str, grid: str, blobs: Iterable[bytes]) -> None:
    """Write a file of VTK with a grid of a kind; blobs: the arrays that it refers to. Raises OSError."""
    head = (
        '<?xml version="1.0"?>\n'
        f'<VTKFile type="{kind}" version="1.0" byte_order="{BYTE_ORDER}" header_type="UInt64"'
        f' compressor="vtkZLibDataCompressor">\n{grid}<AppendedData encoding="raw">\n_'
    )
    with atomic_files.new_file(path, durable=False) as file:
        file.writelines([head.encode(), *blobs, b"\n</AppendedData>\n</VTKFile>\n"])


def data_array(name: str, values: NDArray[Any], blobs: list[bytes]) -> str:
    """Add an array ``(nx, ny)`` or ``(3, nx, ny)`` to `blobs`, compressed, and return the element that refers to it.

    In VTK x runs fastest, and the components of a vector stand together: both are the transpose of the array.
    """
    kind, dtype = ("UInt8", np.uint8) if values.dtype == np.uint8 else ("Float32", np.float32)
    components = values.shape[0] if values.ndim == 3 else 1
    offset = sum(map(len, blobs))
    content = values.T.astype(dtype).tobytes()
    block = zlib.compress(content, level=1)
    sizes = [1, len(content), 0, len(block)]  # number of blocks, size of a block and of the rest, compressed sizes
    blobs.append(np.array(sizes, np.uint64).tobytes() + block)
    return (
        f'<DataArray type="{kind}" Name={quoteattr(name)} NumberOfComponents="{components}" format="appended"'
        f' offset="{offset}"/>\n'
    )
