"""Read results: complete, failed, stopped, or still growing."""

from __future__ import annotations

import json
import sys
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, suppress
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from fretsolve import __version__
from fretsolve.case.dimensions import counted
from fretsolve.errors import FileError
from fretsolve.result.header import LARGEST_HEADER, RunHeader, read_sealed
from fretsolve.result.layout import (
    FORMAT_VERSION,
    QUANTITIES,
    STEP,
    FieldQuantity,
    has_cycles,
    is_single,
    quantities_of,
)
from fretsolve.result.lock import is_locked
from fretsolve.result.part_reader import PartReader, Steps, damage_reported
from fretsolve.result.parts import (
    HEADER_NAME,
    ROUND_NAME,
    Part,
    component,
    contiguous_parts,
    parts_folder,
    read_rows,
    read_state,
)
from fretsolve.system.arrays import DoubleArray
from fretsolve.system.environment import how_to_install
from fretsolve.system.files import read_small_text, require_regular
from fretsolve.system.hdf5_files import open_hdf5

if TYPE_CHECKING:  # xarray is optional, and pydantic, which the case needs, takes long to load
    import xarray

    from fretsolve.case.models import Case
    from fretsolve.result.cycles.table import CycleTable

_COMPUTED = {
    "stress": "stresses, not the result that they were",
    "fatigue": "fatigue parameters, not the result that they were",
    "crack": "a crack, not the result that it was",
}
"""Files beside a result, by the words of their format, and what is said of them."""

CASE_ENDINGS = (".yaml", ".yml")

READ_ATTEMPTS = 20
"""Number of looks before giving up if a run finishes, or removes states, at the same moment."""


class Columns(dict[str, NDArray[Any]]):
    """Columns by their names; the KeyError for another name lists them."""

    def __missing__(self, name: str) -> NDArray[Any]:
        raise KeyError(f"no column {name!r} in the history, which has {', '.join(self)}")


@dataclass(eq=False, repr=False)
class Result(AbstractContextManager["Result"]):
    """A result, read lazily; a context manager.

    status: complete, failed, running or stopped. attributes: of the root of the file. history: the
    columns of ``/history`` with `step`, each ``(increments,)``; error bars are columns ``<name>_error``. x, y: cell
    centres in mm. fields: names of the fields. steps: the increments whose fields are there.
    """

    path: Path
    attributes: Mapping[str, Any]
    history: Mapping[str, NDArray[Any]]
    x: DoubleArray
    y: DoubleArray
    fields: tuple[str, ...]
    steps: Steps
    _parts: list[Part]
    _newest: Mapping[str, NDArray[Any]]
    _open: PartReader | None = None

    @property
    def status(self) -> str:
        return str(self.attributes["status"])

    @property
    def coupling(self) -> str:
        return str(self.attributes["coupling"])

    @property
    def case_yaml(self) -> str:
        return str(self.attributes["case_yaml"])

    @cached_property
    def effective_case(self) -> dict[str, Any]:
        case: dict[str, Any] = json.loads(self.attributes["effective_case"])
        return case

    @cached_property
    def rounds_before(self) -> list[dict[str, Any]]:
        """The rounds of an accuracy before the one that the result holds, with what each was known to and cost."""
        rounds: list[dict[str, Any]] = self._provenance.get("rounds", [])
        return rounds

    @property
    def in_rounds(self) -> bool:
        """True if rounds of an accuracy have picked keys of the case."""
        return bool(self._provenance.get("picked_keys"))

    @cached_property
    def _provenance(self) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(self.attributes.get("provenance", "{}"))
        return found

    @cached_property
    def case(self) -> Case | None:
        """The case with its defaults, None if this version does not understand it."""
        from fretsolve.case.loading import stored_case

        return stored_case(self.effective_case)

    @cached_property
    def cycles(self) -> CycleTable | None:
        """The table of the cycles that are complete, None if there is none."""
        if not has_cycles(self.effective_case):
            return None
        from fretsolve.result.cycles.table import cycle_table  # takes 3 ms to load

        def slip(step: int) -> NDArray[Any] | None:
            return self.field("slip", step) if "slip_x" in self.fields and step in self.steps else None

        return cycle_table(self.history, self.effective_case, slip, ended=self.status == "complete")

    def cycle_columns(self) -> Mapping[str, NDArray[Any]] | None:
        """Return the columns of the table of cycles, None without any."""
        return None if self.cycles is None else self.cycles.columns

    @property
    def increments(self) -> int:
        """The number of increments."""
        return len(self.history["step"])

    @property
    def why_empty(self) -> str:
        """Reason why the result has no increment, if it has none; for a message."""
        if "failure" in self.attributes:
            return f"the run failed before its first increment: {self.attributes['failure']}"
        return "the result has no increment yet"

    def units(self, name: str) -> str:
        """Return the units of a column of the history, of a field or of an axis. Raises KeyError."""
        if name not in QUANTITIES:
            raise KeyError(f"no column, field or axis {name!r} in a result, which has {', '.join(QUANTITIES)}")
        return quantities_of(self.effective_case)[name].units

    def field_type(self, name: str) -> np.dtype[Any]:
        """Return the type of a field's values."""
        if name == "zone":
            return np.dtype(np.uint8)
        return np.dtype(np.float32 if is_single(self.effective_case) else np.float64)

    def field(self, name: str, step: int = -1) -> NDArray[Any]:
        """Return the field `name`, ``(nx, ny)``, at increment `step`, one of `steps` (-1: the last of them).

        ``shear`` and ``slip`` give both components, ``(2, nx, ny)``. Raises KeyError for what is not stored, FileError
        if the file is damaged.
        """
        if f"{name}_x" in self.fields:
            return np.array([self.field(f"{name}_x", step), self.field(f"{name}_y", step)])
        if name not in self.fields:
            raise KeyError(f"no field {name!r} in the result, which has {', '.join(self.fields) or 'none'}")
        wanted = self.steps[-1] if step == -1 and self.steps else step
        if wanted not in self.steps:
            few = self.steps if len(self.steps) < 10 else (*self.steps[:2], "...", self.steps[-1])
            stored = ", ".join(map(str, few)) or "none"
            raise KeyError(f"no fields of increment {step} in the result, which has those of {stored}")
        for _ in range(READ_ATTEMPTS):
            try:
                plane = self._plane(name, wanted)
            except FileNotFoundError:  # the run has finished
                self._parts = _parts_of(self.path)
                continue
            if plane.shape != (len(self.x), len(self.y)):
                raise FileError(f"{name} of increment {wanted} does not have the cells of the grid", self.path)
            return plane
        raise FileError(f"the fields of increment {wanted} are not kept any more", self.path)

    def to_xarray(self, group: Literal["fields", "history"] = "fields") -> xarray.Dataset:
        """Return the fields over `step`, `x` and `y`, or the history over `step`, with units, meaning and attributes.

        Fields are read when their values are asked for, also after `close`. Raises ImportError without xarray.
        """
        try:
            import xarray
            from xarray.core.indexing import LazilyIndexedArray

            from fretsolve.result.xarray_view import StoredField
        except ImportError as error:
            raise ImportError(f"datasets need xarray ({error}): {how_to_install('xarray')}") from error
        columns: dict[str, tuple[Any, Any]] = {}
        if group == "history":
            columns = {name: ("step", column) for name, column in self.history.items()}
        elif group == "fields":
            axes = {"step": np.array(self.steps, STEP.dtype), "x": self.x, "y": self.y}
            columns = {name: (name, values) for name, values in axes.items()}
            for name in self.fields:
                shape, dtype = (len(self.x), len(self.y)), self.field_type(name)
                field = StoredField(partial(self.field, name), self.steps, shape, dtype)
                columns[name] = tuple(axes), LazilyIndexedArray(field)
        else:
            raise ValueError(f"a result has the groups history and fields, not {group!r}")
        variables = {name: (*column, QUANTITIES[name].attributes) for name, column in columns.items()}
        return xarray.Dataset(variables, attrs=self.attributes)

    def close(self) -> None:
        """Close the file, if one is open."""
        if self._open is not None:
            self._open.file.close()
            self._open = None

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<Result {self.path} {self.status}, {counted(self.increments, 'increment')}>"

    def _plane(self, name: str, step: int) -> NDArray[Any]:
        """Return a field ``(nx, ny)`` at `step`. Raises FileNotFoundError if its file is not there any more."""
        if step == self.steps[-1] and name in self._newest:
            return self._newest[name].copy()
        index = bisect_right(self._parts, step, key=lambda part: part.first) - 1
        if index < 0 or step > self._parts[index].last:
            raise FileNotFoundError(self.path)
        part = self._parts[index]
        if self._open is None or self._open.path != part.path:
            self.close()
            self._open = PartReader(part.path)
        if step in self._open.field_steps:
            return self._open.read(name, step)
        quantity = QUANTITIES[name]
        assert isinstance(quantity, FieldQuantity)
        return component(read_state(part, (len(self.x), len(self.y))), quantity)


def open_result(path: str | Path) -> Result:
    """Open a result by its name, or by the name of its parts folder; complete, failed, stopped or still growing.

    Its history and fields are NumPy arrays, `Result.to_xarray` gives datasets of xarray. Raises FileError if it is not
    there, not a result, truncated, damaged, or of a newer format.
    """
    out = Path(path)
    if out.is_dir() and out.name.endswith(".parts"):
        out = out.with_name(out.name.removesuffix(".parts"))
    if out.suffix in CASE_ENDINGS and out.is_file():
        raise FileError(f"a case, not the result of a run{_other_name(out)}", out)
    for _ in range(READ_ATTEMPTS):
        try:
            if out.exists():
                return _open_file(out)
            if parts_folder(out).is_dir():
                between_rounds = not (parts_folder(out) / HEADER_NAME).exists() and _round_of(out).exists()
                return _open_file(_round_of(out)) if between_rounds else _open_parts(out)
        except FileNotFoundError:
            continue  # finished at this moment: look again
        except OSError as error:
            raise FileError(f"cannot be read: {error.strerror or error}", out) from error
        raise FileError(f"no such file, nor parts of a run in {parts_folder(out).name}{_other_name(out)}", out)
    raise FileError("the run has not begun to save increments", parts_folder(out))


def _round_of(out: Path) -> Path:
    return parts_folder(out) / ROUND_NAME


def _other_name(out: Path) -> str:
    """Return a question with the result that may be meant; empty if there is none of such a name."""
    meant = out.with_suffix(".h5") if out.suffix in CASE_ENDINGS else out.with_name(f"{out.name}.h5")
    return f"; {meant.name}?" if meant.exists() or parts_folder(meant).is_dir() else ""


def read_attributes(out: Path) -> dict[str, Any]:
    """Return the root attributes of a result file. Raises FileError: no result, damaged, of a newer format."""
    return _read_attributes(out)[0]


def _read_attributes(out: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the root attributes of a result file, and digests of its content."""
    require_regular(out)
    if out.stat().st_size == 0:
        raise FileError("the file is empty", out)
    with damage_reported(out, "header"), open_hdf5(out) as file:
        if "header" not in file:
            raise FileError("an HDF5 file, but not a result of fretsolve: it has no header", out)
        attributes, content = read_sealed(file)
        for kind, of in _COMPUTED.items():
            if str(attributes.get("format", "")).startswith(f"fretsolve {kind} "):
                raise FileError(f"a file of {of} computed from, {attributes.get('result', '')}", out)
        _require_known_format(out, attributes["format_version"], attributes["fretsolve_version"])
        return attributes, content


def read_header(folder: Path) -> RunHeader:
    """Return the header in a parts folder. Raises FileError, and FileNotFoundError if there is none."""
    path = folder / HEADER_NAME
    text = read_small_text(path, "the header of a run", LARGEST_HEADER)
    try:
        values = json.loads(text)
        _require_known_format(path, values["format_version"], values["version"])
        return RunHeader.from_json(text)
    except (ValueError, TypeError, LookupError, AttributeError, RecursionError) as error:
        raise FileError(f"not the header of a run: {error}", path) from error


def _require_known_format(file: Path, format_version: int, version: str) -> None:
    """Raise FileError if this version is too old to read `file`."""
    if format_version > FORMAT_VERSION:
        message = f"has format {format_version}, written by fretsolve {version}; this is {__version__}"
        advice = f"which reads formats up to {FORMAT_VERSION}: install fretsolve {version} or newer"
        raise FileError(f"{message}, {advice}", file)


def _parts_of(out: Path) -> list[Part]:
    return [Part(out, 0, sys.maxsize)] if out.exists() else contiguous_parts(parts_folder(out))


def _open_file(out: Path) -> Result:
    attributes, content = _read_attributes(out)
    with ExitStack() as opened:
        reader = opened.enter_context(PartReader(out))
        x, y = reader.grid
        reader.require_content(content)
        reader.require_fields((len(x), len(y)))
        columns = _columns(reader.rows)
        del reader.rows  # the columns hold the same, and a result is open for long
        opened.pop_all()
    fields, steps = tuple(reader.field_names), reader.field_steps
    return Result(out, attributes, columns, x, y, fields, steps, _parts_of(out), {}, reader)


def _open_parts(out: Path) -> Result:
    folder = parts_folder(out)
    status = "running" if is_locked(folder) else "stopped"
    header = read_header(folder)
    parts = contiguous_parts(folder)
    newest = _newest_fields(header, parts)  # first, since reading a long history takes longer than they are kept
    rows = read_rows(header, parts)
    steps = [step for step in rows["step"].tolist() if header.stores_fields(step)]
    if not (folder / HEADER_NAME).exists():
        raise FileNotFoundError(folder)  # the run has finished, and may have begun to remove parts
    if parts and parts[-1].last not in steps:
        steps.append(parts[-1].last)  # the state has its fields
    fields = tuple(quantity.name for quantity in header.stored_fields)
    attributes = header.attributes(status)
    return Result(out, attributes, _columns(rows), header.x, header.y, fields, Steps(steps), parts, newest)


def _newest_fields(header: RunHeader, parts: Sequence[Part]) -> dict[str, NDArray[Any]]:
    """Return the fields of the last increment, by their names, if they are in its state alone.

    A run that goes on removes the state after a while. Of a state that cannot be read, nothing is returned:
    `Result.field` says why.
    """
    if parts and not header.stores_fields(parts[-1].last):
        with suppress(FileError, FileNotFoundError):
            state = read_state(parts[-1], header.shape)
            return {quantity.name: component(state, quantity) for quantity in header.stored_fields}
    return {}


def _columns(rows: NDArray[Any]) -> Columns:
    return Columns({name: np.ascontiguousarray(rows[name]) for name in rows.dtype.names or ()})
