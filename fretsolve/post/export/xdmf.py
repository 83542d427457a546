"""Write fields over time as XDMF, for ParaView: a small text that refers to the data in the result file itself.

In XDMF's own regular grids x runs fastest, in the result's arrays y. So the points are written once, into an HDF5 file
beside the text. The parts of an unfinished run change and are removed, so its fields are copied into that file too.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from xml.sax.saxutils import escape, quoteattr

import numpy as np
from numpy.typing import DTypeLike

from fretsolve.errors import CaseError
from fretsolve.post.export.selection import stored_names
from fretsolve.result import Result
from fretsolve.result.layout import create_field, is_single, stored_fields
from fretsolve.system import atomic_files
from fretsolve.system.files import require_utf8


def points_file(path: Path) -> Path:
    """Return the HDF5 file beside the text `path`."""
    return path.with_name(path.name + ".h5")


def require_readable(result: Result, path: Path) -> None:
    """Raise CaseError or FileError if readers of XDMF would not find the files that the text `path` refers to.

    They end a name at a colon, skip blanks before it, and end the folder of `path` at a backslash.
    """
    for name in (_source(result, path), points_file(path).name):
        require_utf8(name, path)
        if ":" in name or name[0].isspace() or "\\" in str(path.absolute()):
            unread = "rename files and folders whose names have a colon, a backslash or a blank at the beginning"
            raise CaseError(f"would refer to {name!r}, which readers of XDMF do not find: {unread}", (), path)


def _source(result: Result, path: Path) -> str:
    """Return how the text `path` names the file of the fields: the result once it is finished, else that beside it."""
    if not _is_finished(result):
        return points_file(path).name
    return os.path.relpath(result.path.absolute(), path.absolute().parent)


def _is_finished(result: Result) -> bool:
    return result.status in ("complete", "failed")


def write_xdmf(result: Result, steps: Sequence[int], path: Path, *, exclusive: bool) -> None:
    """Write ``path`` (.xdmf) and, beside it, the points (``.xdmf.h5``). Raises OSError, FileError."""
    beside = points_file(path)
    finished = _is_finished(result)
    with atomic_files.all_or_none() as making:
        with making(beside), atomic_files.new_hdf5(beside, exclusive=exclusive) as file:
            x, y = np.meshgrid(result.x, result.y, indexing="ij")
            points = np.stack([x, y, np.zeros_like(x)], axis=-1)
            file.create_dataset("points", data=points, compression="gzip", shuffle=True)
            copied = () if finished else stored_fields(stored_names(result), is_single(result.effective_case))
            for quantity in copied:
                dataset = create_field(file.require_group("fields"), quantity, len(steps), x.shape)
                for index, step in enumerate(steps):
                    dataset[index] = result.field(quantity.name, step)
        stored = result.steps if finished else tuple(steps)
        with atomic_files.new_file(path, durable=False, exclusive=exclusive) as text:
            lines = _document(result, steps, stored, _source(result, path), beside.name)
            text.writelines(f"{line}\n".encode() for line in lines)


def _document(result: Result, steps: Sequence[int], stored: Sequence[int], source: str, points: str) -> Iterator[str]:
    """Return the lines of the text. stored: the increments whose fields `source` holds, in its order."""
    shape = f"{len(result.x)} {len(result.y)}"
    places = {step: place for place, step in enumerate(stored)}
    types = {name: _type(result.field_type(name)) for name in result.fields}
    yield '<?xml version="1.0"?>\n<Xdmf Version="2.0">\n<Domain>'
    yield '<Grid Name="increments" GridType="Collection" CollectionType="Temporal">'
    for step in steps:
        yield f'<Grid Name="increment {step}" GridType="Uniform">\n<Time Value="{step}"/>'
        yield f'<Topology TopologyType="3DSMesh" Dimensions="1 {shape}"/>\n<Geometry GeometryType="XYZ">'
        yield f'<DataItem Dimensions="1 {shape} 3" {_type(np.float64)} Format="HDF">{escape(points)}:/points</DataItem>'
        yield "</Geometry>"
        # each field is a slab of the dataset, which holds the field of all increments
        slab = f"{places[step]} 0 0 1 1 1 1 {shape}"
        for name in result.fields:
            whole = f'Dimensions="{len(stored)} {shape}" {types[name]} Format="HDF"'
            yield f'<Attribute Name={quoteattr(name)} AttributeType="Scalar" Center="Node">'
            yield f'<DataItem ItemType="HyperSlab" Dimensions="1 {shape}" Type="HyperSlab">'
            yield f'<DataItem Dimensions="3 3" Format="XML">{slab}</DataItem>'
            yield f"<DataItem {whole}>{escape(source)}:/fields/{name}</DataItem>\n</DataItem>\n</Attribute>"
        yield "</Grid>"
    yield "</Grid>\n</Domain>\n</Xdmf>"


def _type(dtype: DTypeLike) -> str:
    kind = np.dtype(dtype)
    return f'NumberType="{"UChar" if kind == np.uint8 else "Float"}" Precision="{kind.itemsize}"'
