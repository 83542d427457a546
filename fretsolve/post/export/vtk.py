"""Write surfaces, or volumes of stresses and fatigue parameters, for ParaView: a grid per body and increment, an index.

Grids are files of VTK's XML formats with binary data appended, compressed by zlib: structured (``.vts``) for deformed
surfaces, rectilinear (``.vtr``) for volumes; see VTK's "XML file formats". Points are the centres of the cells. Numbers
are of single precision, which is more than a picture shows. Body 1 lies above z = 0 and body 2 below. Stress components
keep the axes of the result, in which z points into body 2; normals of planes have the z of the grid.
"""

from __future__ import annotations

import re
import sys
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from fretsolve.errors import CaseError, FileError
from fretsolve.post.export.deformed_surfaces import BodySurface, DeformedSurfaces, FlatError
from fretsolve.post.export.selection import stored_names
from fretsolve.post.fatigue.fatigue_file import BodyFatigue, fatigue_bodies
from fretsolve.post.stress.computed_file import ComputedFile
from fretsolve.post.stress.invariants import principal, von_mises
from fretsolve.post.stress.stress_file import BodyStress, bodies_of
from fretsolve.result import Result
from fretsolve.system import atomic_files
from fretsolve.system.arrays import DoubleArray
from fretsolve.system.files import require_utf8

BYTE_ORDER = "LittleEndian" if sys.byteorder == "little" else "BigEndian"


GRID_NAME, VOLUME_NAME = (re.compile(rf".+\.[0-9]{{6,}}\.{end}(\.[0-9a-f]{{16}}\.tmp)?") for end in ("vts", "vtr"))
"""Names of the grids of surfaces and of volumes, also of grids that are being written."""


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
    try:
        surfaces, warnings = DeformedSurfaces(result), []
    except FlatError as error:
        surfaces, warnings = None, [f"the surfaces are left flat: {error}"]
    grids = []
    with atomic_files.all_or_none() as making:
        with making(folder):
            folder.mkdir(exist_ok=True)
        for step in steps:
            fields = _point_data(result, step)
            for part, body in enumerate(surfaces.at(step) if surfaces is not None else [_flat(result)]):
                grid = folder / f"{body.name.replace(' ', '_')}.{step:06d}.vts"
                with making(grid):
                    _write_surface(grid, body, fields, step)
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


def _write_surface(path: Path, body: BodySurface, fields: Mapping[str, NDArray[Any]], time: float) -> None:
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


def write_volumes(computed: ComputedFile, path: Path, *, exclusive: bool) -> None:
    """Write ``path`` (.pvd), which ParaView opens, and the grids of an open file in a folder beside it.

    exclusive: replace no index. Raises OSError, FileError.
    """
    folder = grids_folder(path)
    grids = []
    with atomic_files.all_or_none() as making:
        with making(folder):
            folder.mkdir(exist_ok=True)
        for number, body, step, fields in _volumes(computed):
            grid = folder / f"{computed.kind}_body_{number}.{step:06d}.vtr"
            with making(grid):
                _write_volume(grid, body, fields, up=number == 1)
            grids.append((grid, step, number - 1, f"body {number}"))
        write_index(path, grids, exclusive=exclusive)


def _volumes(computed: ComputedFile) -> Iterator[tuple[int, BodyStress | BodyFatigue, int, dict[str, DoubleArray]]]:
    """Yield each body with its number, an increment, and fields ``(depths, nx, ny)`` or ``(3, depths, nx, ny)``."""
    if computed.kind == "fatigue":
        for number, parameters in fatigue_bodies(computed).items():
            yield number, parameters, parameters.steps[-1], _fatigue_fields(parameters)
    else:
        for number, stresses in bodies_of(computed).items():
            for place, step in enumerate(stresses.steps.tolist()):
                yield number, stresses, step, _stress_fields(stresses, place)


def _stress_fields(body: BodyStress, place: int) -> dict[str, DoubleArray]:
    """Return the stored components of an increment, and invariants if all six are there."""
    stress = body.stress(place).astype(np.float64)
    fields: dict[str, DoubleArray] = dict(zip(body.components, stress, strict=True))
    if len(fields) == 6:
        fields |= {"von_mises": von_mises(stress), "first_principal": principal(stress)[0]}
    return fields


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


def _write_volume(path: Path, body: BodyStress | BodyFatigue, fields: Mapping[str, DoubleArray], *, up: bool) -> None:
    """Write a rectilinear grid with its point data; up: the body lies above z = 0. Raises OSError."""
    blobs: list[bytes] = []
    point_data = "".join(data_array(name, _ordered(field, up=up), blobs) for name, field in fields.items())
    axes: tuple[NDArray[np.float64], ...] = (body.x, body.y, body.depths if up else -body.depths[::-1])
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
    """Return a field as `data_array` takes it: z rises, and vectors have the z of the grid, upwards."""
    rising = field if up else field[..., ::-1, :, :]
    if field.ndim == 3:
        return np.asarray(rising.transpose(1, 2, 0).reshape(-1, order="F"))
    turned = rising * np.array([1.0, 1.0, -1.0])[:, None, None, None]
    return np.asarray(turned.transpose(0, 2, 3, 1).reshape(3, -1, 1, order="F"))
