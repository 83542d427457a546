"""Tables as files: CSV, HDF5 and Parquet, for sweeps and studies alike."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from fretsolve import __version__
from fretsolve.errors import CaseError
from fretsolve.system import atomic_files
from fretsolve.system.files import writing


@dataclass(frozen=True, eq=False)
class Column:
    """Values ``(rows,)`` under a name: texts, or numbers (NaN if there is none) in `units`.

    meaning: for HDF5, the name by default; attributes: more of them there.
    """

    name: str
    units: str
    values: NDArray[Any]
    meaning: str = ""
    attributes: Mapping[str, Any] = field(default_factory=dict)

    @property
    def heading(self) -> str:
        """The name with the units, as in CSV."""
        return f"{self.name} ({self.units})" if self.units else self.name


def column(name: str, values: ArrayLike, units: str = "", meaning: str = "", **attributes: Any) -> Column:
    """Return a column; texts become objects, as HDF5 and CSV need them."""
    array = np.asarray(values)
    return Column(name, units, array.astype(object) if array.dtype.kind == "U" else array, meaning, attributes)


def write_csv(path: Path, columns: Iterable[Column], first: Sequence[Any] = ()) -> None:
    """Write a row per case, units in the heading; what is not known is empty. first: one more row. Raises FileError."""
    columns = list(columns)
    rows = zip(*(column.values.tolist() for column in columns), strict=True)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([column.heading for column in columns])
    writer.writerows([_cell(value) for value in row] for row in ([first, *rows] if first else rows))
    with writing(path):
        atomic_files.write_text(path, text.getvalue())


def write_hdf5(
    path: Path, columns: Mapping[str, Iterable[Column]], attributes: Mapping[str, str], links: Mapping[str, Any] = {}
) -> None:
    """Write each column as a dataset in its group, with units and meaning. Raises FileError.

    columns: by group, empty for none; links: by their names in the file.
    """
    with writing(path), atomic_files.new_hdf5(path) as file:
        file.attrs.update({"fretsolve_version": __version__, **attributes})
        for group, members in columns.items():
            for one in members:
                values = one.values.astype(np.uint8) if one.values.dtype == bool else one.values
                kind = h5py.string_dtype() if values.dtype == object else None
                dataset = file.create_dataset(f"{group}/{one.name}" if group else one.name, data=values, dtype=kind)
                meaning = {"units": one.units, "long_name": one.meaning or one.name, **one.attributes}
                dataset.attrs.update(meaning)
        for name, link in links.items():
            file[name] = link


def write_parquet(path: Path, columns: Iterable[Column]) -> None:
    """Write the same as the CSV file, with types. Raises CaseError without pyarrow, FileError."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as error:
        raise CaseError(f"Parquet needs pyarrow, which cannot be imported ({error}): pip install pyarrow") from error
    content = io.BytesIO()
    arrays = {column.heading: pyarrow.array(column.values.tolist()) for column in columns}
    pyarrow.parquet.write_table(pyarrow.table(arrays), content)
    with writing(path), atomic_files.new_file(path) as file:
        file.write(content.getvalue())


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.10g}" if np.isfinite(value) else ""
    return str(value)
