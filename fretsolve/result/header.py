"""What a run is: its case, its grid, and whether a stopped run belongs to it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fretsolve import __version__
from fretsolve.errors import FileError, dotted
from fretsolve.result.layout import FORMAT_VERSION, FieldQuantity, is_single, stored_fields
from fretsolve.system.arrays import DoubleArray

WITHOUT_EFFECT = (("title",), ("expect",), ("solver", "max_iterations"))
"""Keys of a case that change no number of a certified increment, so that a resumed run may change them."""

SHOWN_DIFFERENCES = 3


@dataclass(frozen=True, eq=False)
class RunHeader:
    """What is known of a run before its first increment.

    case_yaml: the case as written. effective_case, provenance: JSON objects. coupling: the terms kept, and model: the
    reason for each part of the model, a JSON list. inputs: JSON object of the SHA-256 of files that the case names.
    x, y: cell centres in mm, ``(nx,)`` and ``(ny,)``. fields: which to store, of `pressure`, `shear`, `slip`,
    `slip_path`, `work_density`, `zone`, `gap`; every: of which increments, besides the last. errors: whether every
    increment comes with error bars.
    """

    case_yaml: str
    effective_case: str
    coupling: str
    provenance: str
    x: DoubleArray
    y: DoubleArray
    fields: tuple[str, ...]
    every: int
    model: str = "[]"
    inputs: str = "{}"
    errors: bool = False
    version: str = __version__
    format_version: int = FORMAT_VERSION

    @property
    def shape(self) -> tuple[int, int]:
        """Cells along x and y."""
        return len(self.x), len(self.y)

    @property
    def stored_fields(self) -> tuple[FieldQuantity, ...]:
        """The datasets of `fields`."""
        return stored_fields(self.fields, is_single(json.loads(self.effective_case)))

    @property
    def fingerprint(self) -> str:
        """Equal for runs that give the same numbers (SHA-256 of case and versions, hexadecimal)."""
        return fingerprint(self.effective_case, self.inputs, self.version, self.format_version)

    def stores_fields(self, step: int) -> bool:
        """Whether the fields of increment `step` are stored even if it is not the last."""
        return (step + 1) % self.every == 0

    def to_json(self) -> str:
        """As text from which `from_json` rebuilds it exactly."""
        values = {name: getattr(self, name) for name in self.__dataclass_fields__}
        return json.dumps({**values, "x": self.x.tolist(), "y": self.y.tolist()}, indent=1)

    @classmethod
    def from_json(cls, text: str) -> RunHeader:
        """Raises ValueError, TypeError or KeyError where `text` is not from `to_json`."""
        values = json.loads(text)
        axes = {name: np.array(values[name], np.float64) for name in ("x", "y")}
        return cls(**{**values, **axes, "fields": tuple(values["fields"])})


def fingerprint(effective_case: str, inputs: str, version: str, format_version: int) -> str:
    """See `RunHeader.fingerprint`."""
    values = {dotted(key): value for key, value in _identity(effective_case, inputs)}
    identity = json.dumps([values, version, format_version], sort_keys=True)
    return hashlib.sha256(identity.encode()).hexdigest()


def require_same_run(file: Path, effective_case: str, inputs: str, version: str, header: RunHeader) -> None:
    """Raise FileError unless the run stored in `file` gives the same numbers as that of `header`."""
    if version != header.version:
        raise FileError(
            f"was begun by fretsolve {version}, this is {header.version}, whose numbers may differ:"
            " finish it with that version, or start anew with --overwrite",
            file,
        )
    there = dict(_identity(effective_case, inputs))
    here = dict(_identity(header.effective_case, header.inputs))
    differing = [key for key in {**there, **here} if there.get(key, _ABSENT) != here.get(key, _ABSENT)]
    if differing:
        shown = [f"{dotted(key)} is {_text(there, key)} there, {_text(here, key)} now" for key in differing]
        more = f" and {len(shown) - SHOWN_DIFFERENCES} more" if len(shown) > SHOWN_DIFFERENCES else ""
        raise FileError(
            f"holds a run of another case: {'; '.join(shown[:SHOWN_DIFFERENCES])}{more};"
            " give another -o, or start anew with --overwrite",
            file,
        )


_Key = tuple[str | int, ...]
_ABSENT = object()


def _identity(effective_case: str, inputs: str) -> Iterator[tuple[_Key, Any]]:
    yield from _leaves(json.loads(effective_case))
    yield from ((("content of", name), digest) for name, digest in json.loads(inputs).items())


def _leaves(value: Any, key: _Key = ()) -> Iterator[tuple[_Key, Any]]:
    if key in WITHOUT_EFFECT:
        return
    if isinstance(value, dict) and value:
        for name, inner in value.items():
            yield from _leaves(inner, (*key, name))
    elif isinstance(value, list) and value:
        for index, inner in enumerate(value):
            yield from _leaves(inner, (*key, index))
    else:
        yield key, value


def _text(values: dict[_Key, Any], key: _Key) -> str:
    return json.dumps(values[key]) if key in values else "absent"
