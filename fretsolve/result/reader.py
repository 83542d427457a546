"""Reading a result: one that is complete or has failed, and one that still grows or was stopped."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray

from fretsolve.errors import FileError
from fretsolve.result.final_file import attributes as root_attributes
from fretsolve.result.header_reader import read_attributes, read_header
from fretsolve.result.layout import ERRORS, HISTORY, RESTART, STEP, X, Y, is_single
from fretsolve.result.lock import is_locked
from fretsolve.result.parts import (
    HEADER_NAME,
    Part,
    Piece,
    contiguous_parts,
    damage_reported,
    open_piece,
    parts_folder,
)
from fretsolve.system.arrays import DoubleArray
from fretsolve.system.optional import how_to_install

if TYPE_CHECKING:
    import xarray

ATTEMPTS = 20
"""How often to look again where a run merges or finishes its parts at the same moment."""

_UNITS = {quantity.name: quantity.units for quantity in (STEP, *HISTORY, *ERRORS, X, Y, *RESTART)}


class Columns(dict[str, NDArray[Any]]):
    """Columns by their names; a KeyError for another name tells those that there are."""

    def __missing__(self, name: str) -> NDArray[Any]:
        raise KeyError(f"no column {name!r} in the history, which has {', '.join(self)}")


class Result:
    """A result, read lazily; a context manager.

    status: complete, failed, running or stopped. attributes: those of the root of the file. history: the
    columns of ``/history`` with `step`, each ``(increments,)``; error bars are columns ``<name>_error``. x, y: cell
    centres in mm. fields: names of the fields. steps: the increments of which fields are there.
    """

    def __init__(
        self,
        path: Path,
        attributes: Mapping[str, Any],
        history: Mapping[str, NDArray[Any]],
        axes: tuple[DoubleArray, DoubleArray],
        fields: Sequence[str],
        steps: Sequence[int],
        parts: Sequence[Part],
    ):
        self.path = path
        self.attributes = attributes
        self.history: Mapping[str, NDArray[Any]] = Columns(history)
        self.x, self.y = axes
        self.fields = tuple(fields)
        self.steps = tuple(steps)
        self._parts = list(parts)
        self._open: tuple[Part, Piece] | None = None

    @property
    def status(self) -> str:
        return str(self.attributes["status"])

    @property
    def coupling(self) -> str:
        return str(self.attributes["coupling"])

    @property
    def case_yaml(self) -> str:
        return str(self.attributes["case_yaml"])

    @property
    def effective_case(self) -> dict[str, Any]:
        values: dict[str, Any] = json.loads(self.attributes["effective_case"])
        return values

    @property
    def increments(self) -> int:
        """How many increments there are."""
        return len(self.history["step"])

    @property
    def why_empty(self) -> str:
        """Why there is no increment, where there is none, for a message."""
        if "failure" in self.attributes:
            return f"the run failed before its first increment: {self.attributes['failure']}"
        return "the result has no increment yet"

    def units(self, name: str) -> str:
        """Units of a column of the history, of a field or of an axis. Raises KeyError."""
        return _UNITS[name]

    def field_type(self, name: str) -> np.dtype[Any]:
        """The type of a field's values."""
        if name == "zone":
            return np.dtype(np.uint8)
        return np.dtype(np.float32 if is_single(self.effective_case) else np.float64)

    def field(self, name: str, step: int = -1) -> NDArray[Any]:
        """The field `name`, ``(nx, ny)``, at increment `step`, one of `steps` (-1: the last of them).

        ``shear`` and ``slip`` give both components, ``(2, nx, ny)``. Raises KeyError for what is not stored, FileError
        where the file is damaged.
        """
        if f"{name}_x" in self.fields:
            return np.array([self.field(f"{name}_x", step), self.field(f"{name}_y", step)])
        if name not in self.fields:
            raise KeyError(f"no field {name!r} in the result, which has {', '.join(self.fields) or 'none'}")
        wanted = self.steps[-1] if step == -1 and self.steps else step
        if wanted not in self.steps:
            stored = ", ".join(map(str, self.steps)) or "none"
            raise KeyError(f"no fields of increment {step} in the result; stored are those of {stored}")
        for _ in range(ATTEMPTS):
            try:
                return self._piece(wanted).read(name, wanted)
            except FileNotFoundError:
                self._parts = _parts_of(self.path)
        raise FileError("the parts of the result keep changing or were removed", self.path)

    def to_xarray(self, group: Literal["fields", "history"] = "fields") -> xarray.Dataset:
        """The fields over `step`, `x` and `y`, or the history over `step`, with units, meaning and root attributes.

        Fields are read when their values are asked for, also after `close`. Raises ImportError without xarray.
        """
        try:
            from fretsolve.result.xarray_view import as_xarray
        except ImportError as error:
            raise ImportError(f"datasets need xarray ({error}): {how_to_install('xarray')}") from error
        return as_xarray(self, group)

    def close(self) -> None:
        """Close the file, if one is open."""
        if self._open is not None:
            self._open[1].close()
            self._open = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<Result {self.path} {self.status}, {self.increments} increments>"

    def _piece(self, step: int) -> Piece:
        if self._open is not None and self._open[0].first <= step <= self._open[0].last:
            return self._open[1]
        self.close()
        for part in self._parts:
            if part.first <= step <= part.last:
                self._open = part, Piece(part.path)
                return self._open[1]
        raise FileNotFoundError(self.path)


def open_result(path: str | Path) -> Result:
    """Open a result by its name, or by that of its parts folder; complete, failed, stopped or still growing.

    Its history and fields are NumPy arrays, `Result.to_xarray` gives datasets of xarray.

    Raises FileError: not there, not a result, truncated or damaged, or of a newer format.
    """
    out = Path(path)
    if out.is_dir() and out.name.endswith(".parts"):
        out = out.with_name(out.name.removesuffix(".parts"))
    for _ in range(ATTEMPTS):
        try:
            if out.exists():
                return _open_file(out)
            if parts_folder(out).is_dir():
                return _open_parts(out)
        except FileNotFoundError:
            continue  # merged or finished at this moment: look again
        except OSError as error:
            raise FileError(f"cannot be read: {error.strerror or error}", out) from error
        raise FileError(f"no such file, nor parts of a run in {parts_folder(out).name}", out)
    raise FileError("the run has not begun to save increments", parts_folder(out))


def _parts_of(out: Path) -> list[Part]:
    if out.exists():
        return [Part(out, 0, sys.maxsize)]
    return contiguous_parts(parts_folder(out))


def _open_file(out: Path) -> Result:
    attributes = read_attributes(out)
    piece = Piece(out)
    try:
        history = piece.history()
        with damage_reported(out, "grid"):
            axes = piece.file["fields/x"][:], piece.file["fields/y"][:]
        result = Result(
            out, attributes, history, axes, piece.field_names, piece.field_steps, parts := _parts_of(out)
        )
    except BaseException:
        piece.close()
        raise
    result._open = parts[0], piece
    return result


def _open_parts(out: Path) -> Result:
    folder = parts_folder(out)
    running = is_locked(folder)
    header = read_header(folder)
    parts = contiguous_parts(folder)
    columns: list[dict[str, NDArray[Any]]] = []
    steps: list[int] = []
    for part in parts:
        with open_piece(part.path) as piece:
            columns.append(piece.history())
            steps += piece.field_steps
    if not (folder / HEADER_NAME).exists():
        raise FileNotFoundError(folder)  # the run has finished, and may have begun to remove parts
    history = {
        quantity.name: np.concatenate(
            [np.empty(0, quantity.dtype), *(column[quantity.name] for column in columns)]
        )
        for quantity in (STEP, *HISTORY, *(ERRORS if header.errors else ()))
    }
    if parts and parts[-1].last not in steps:
        steps.append(parts[-1].last)  # its fields are among the restart data
    return Result(
        out,
        root_attributes(header, "running" if running else "stopped"),
        history,
        (header.x, header.y),
        [quantity.name for quantity in header.stored_fields],
        steps,
        parts,
    )
