"""Write stresses below the surface as volumes for ParaView: a rectilinear grid per body and increment, and an index.

The format is VTK's XML (``.vtr``), as for the surfaces. Body 1 lies above z = 0 and body 2 below, as the surfaces do.
Components keep the axes of the result, in which z points into body 2.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from fretsolve.export.vtk import BYTE_ORDER, data_array, grids_folder
from fretsolve.stress.invariants import principal, von_mises
from fretsolve.stress.stress_file import BodyStress, bodies_of
from fretsolve.system import atomic_files
from fretsolve.system.foreign_files import open_hdf5


def write_stress_vtk(stresses: Path, path: Path, *, exclusive: bool) -> None:
    """Write ``path`` (.pvd), which ParaView opens, and the grids of a file of stresses in a folder beside it.

    Raises OSError, FileError.
    """
    folder = grids_folder(path)
    folder.mkdir(exist_ok=True)
    index = ['<?xml version="1.0"?>', f'<VTKFile type="Collection" version="1.0" byte_order="{BYTE_ORDER}">']
    index.append("<Collection>")
    with open_hdf5(stresses) as file:
        for part, (number, body) in enumerate(bodies_of(file, stresses).items()):
            for place, step in enumerate(body.steps.tolist()):
                grid = folder / f"stress_body_{number}.{step:06d}.vtr"
                _write_grid(grid, body, place, up=number == 1)
                name, file_name = quoteattr(f"body {number}"), quoteattr(f"{folder.name}/{grid.name}")
                index.append(f'<DataSet timestep="{step}" part="{part}" name={name} file={file_name}/>')
    with atomic_files.new_file(path, durable=False, exclusive=exclusive) as written:
        written.write("\n".join([*index, "</Collection>", "</VTKFile>", ""]).encode())


def _write_grid(path: Path, body: BodyStress, place: int, *, up: bool) -> None:
    stress = body.stress(place).astype(np.float64)
    heights = body.depths if up else -body.depths[::-1]
    fields: dict[str, NDArray[Any]] = dict(zip(body.components, stress, strict=True))
    if len(fields) == 6:
        fields |= {"von_mises": von_mises(stress), "first_principal": principal(stress)[0]}
    blobs: list[bytes] = []
    # In VTK x runs fastest, then y, then z.
    ordered = {name: (field if up else field[::-1]).transpose(0, 2, 1).ravel() for name, field in fields.items()}
    point_data = "".join(data_array(name, values, blobs) for name, values in ordered.items())
    axes = "".join(
        data_array(name, values, blobs) for name, values in zip("xyz", (body.x, body.y, heights), strict=True)
    )
    extent = f"0 {len(body.x) - 1} 0 {len(body.y) - 1} 0 {len(body.depths) - 1}"
    head = (
        '<?xml version="1.0"?>\n'
        f'<VTKFile type="RectilinearGrid" version="1.0" byte_order="{BYTE_ORDER}" header_type="UInt64"'
        ' compressor="vtkZLibDataCompressor">\n'
        f'<RectilinearGrid WholeExtent="{extent}">\n<Piece Extent="{extent}">\n<PointData>\n{point_data}</PointData>\n'
        f"<Coordinates>\n{axes}</Coordinates>\n</Piece>\n</RectilinearGrid>\n"
        '<AppendedData encoding="raw">\n_'
    )
    with atomic_files.new_file(path, durable=False) as file:
        file.writelines([head.encode(), *blobs, b"\n</AppendedData>\n</VTKFile>\n"])
