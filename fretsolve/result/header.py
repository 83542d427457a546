"""The header of a run: its case and grid, and whether a stored run belongs to it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from fretsolve import __version__
from fretsolve.errors import FileError, KeyPath, dotted
from fretsolve.result.layout import (
    FORMAT_VERSION,
    FieldQuantity,
    Quantity,
    described,
    is_single,
    optional_columns,
    row_type,
    stored_fields,
)
from fretsolve.system.arrays import DoubleArray
from fretsolve.system.hdf5_files import own_dataset

WITHOUT_EFFECT = (
    *(("bodies", body, key) for body in (0, 1) for key in ("material", "yield_stress")),
    *(("title",), ("expect",), ("solver", "max_iterations"), ("solver", "accuracy", "at_most"), ("output", "stress")),
)
"""Keys of a case that change no number of a certified increment, so that a resumed run may change them."""

ERROR_BARS = ("solver", "error_bars")
"""Key of a case that asks for error bars."""

CHECKSUM = "sha256"
"""Name of the checksum in a header."""

HEADER = "header/json"
"""Dataset of a result that fretsolve reads instead of the root's attributes."""

CONTENT = "content"
"""Name of what a header says of the datasets."""

LARGEST_HEADER = 2**25
"""Bytes of a header's text. A case file has at most 4 MiB, which JSON may make three times as many, twice."""


@dataclass(frozen=True, eq=False)
class RunHeader:
    """Everything known of a run before its first increment.

    case_yaml: the case as written. effective_case, provenance: JSON objects. coupling: the terms kept; model: the
    reason for each part of the model, a JSON list. inputs: JSON object of the SHA-256 of files that the case names.
    x, y: cell centres in mm, ``(nx,)`` and ``(ny,)``. fields: which to store, as in a case; every: at which increments
    besides the last. errors: whether every increment comes with error bars.
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

    @cached_property
    def case(self) -> dict[str, Any]:
        """The effective case."""
        case: dict[str, Any] = json.loads(self.effective_case)
        return case

    @cached_property
    def optional_columns(self) -> tuple[Quantity, ...]:
        """The columns of the history that not every result has."""
        return optional_columns(self.case)

    @cached_property
    def row_type(self) -> np.dtype[Any]:
        """The type of a record of the history."""
        return row_type(self.errors, self.optional_columns)

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the version and of all that decides the numbers of the run; the same after a resume."""
        identity = sorted(([*map(str, key)], value) for key, value in _identity(self.attributes("running")).items())
        return _digest([self.version, identity])

    @property
    def stored_fields(self) -> tuple[FieldQuantity, ...]:
        """The datasets of `fields`."""
        return stored_fields(self.fields, is_single(self.case))

    def stores_fields(self, step: int) -> bool:
        """Return whether the fields of increment `step` are stored even if it is not the last."""
        return (step + 1) % self.every == 0

    def attributes(self, status: str, failure: tuple[str, str] | None = None) -> dict[str, Any]:
        """Return the root attributes of a result; failure: why the run failed, and the kind of failure."""
        names = ("format_version", "case_yaml", "effective_case", "coupling", "model", "inputs", "provenance")
        values = {"fretsolve_version": self.version, "status": status, **{name: getattr(self, name) for name in names}}
        return values if failure is None else {**values, "failure": failure[0], "failure_kind": failure[1]}

    def to_json(self) -> str:
        """Return text with a checksum from which `from_json` rebuilds the header exactly."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return sealed({**values, "x": self.x.tolist(), "y": self.y.tolist()})

    @classmethod
    def from_json(cls, text: str) -> RunHeader:
        """Rebuild a header. Raises ValueError, TypeError or KeyError if `text` is not from `to_json`."""
        values = unsealed(text)
        axes = {name: np.array(values[name], np.float64) for name in ("x", "y")}
        return cls(**{**values, **axes, "fields": tuple(values["fields"])})


def sealed(values: Mapping[str, Any]) -> str:
    """Return `values` as JSON with a checksum, which `unsealed` compares."""
    return json.dumps({**values, CHECKSUM: _digest(values)})


def unsealed(text: str) -> dict[str, Any]:
    """Return what `sealed` has been given. Raises ValueError if the text has changed."""
    values: dict[str, Any] = json.loads(text)
    if not isinstance(values, dict) or values.pop(CHECKSUM, None) != _digest(values):
        raise ValueError("the checksum does not match, so the text was changed or is damaged")
    return values


def _digest(values: Any) -> str:
    """Return the SHA-256 of what JSON can hold."""
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()


def write_sealed(file: Any, attributes: Mapping[str, Any], content: Mapping[str, Any]) -> None:
    """Write attributes to the root of an HDF5 file, and with `content` as text with a checksum, for `read_sealed`.

    h5py shows texts of attributes as such only if they have no fixed length, and HDF5 has no checksum for such texts.
    """
    file.attrs.update(attributes)
    text = np.frombuffer(sealed({**attributes, CONTENT: content}).encode(), np.uint8)
    header = file.create_dataset(HEADER, data=text, compression="gzip")
    header.attrs.update(described("1", "the attributes of the root as JSON text in UTF-8, with their SHA-256"))


def read_sealed(file: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return attributes and content that `write_sealed` wrote. Raises ValueError or KeyError if they are damaged."""
    stored = own_dataset(file, HEADER)
    if stored.nbytes > LARGEST_HEADER:
        raise ValueError(f"{HEADER} must hold at most {LARGEST_HEADER} bytes")
    attributes = unsealed(stored[:].tobytes().decode())
    return attributes, attributes.pop(CONTENT)


def require_same_run(file: Path, attributes: Mapping[str, Any], header: RunHeader) -> None:
    """Raise FileError unless the run stored in `file`, with these attributes, gives the same numbers as `header`'s."""
    if (version := attributes["fretsolve_version"]) != header.version:
        message = f"was begun by fretsolve {version}, this is {header.version}, whose numbers may differ"
        raise FileError(f"{message}: finish it with that version, or start anew with --overwrite", file)
    there, here = _identity(attributes), _identity(header.attributes("running"))
    if here.get(ERROR_BARS) != "true" and there == here | {ERROR_BARS: "true"}:
        raise FileError("holds a run with error bars; add --error-bars, or start anew with --overwrite", file)
    from fretsolve.case.keys.unrolled_path import typed_key  # with it pydantic, which other results do without

    load_path = header.case.get("load_path")
    differences = [
        f"{dotted(typed_key(load_path, key))} is {there.get(key, 'absent')} there, {here.get(key, 'absent')} now"
        for key in {**there, **here}
        if there.get(key) != here.get(key)
    ]
    if differences:
        more = f" and {len(differences) - 3} more" if len(differences) > 3 else ""
        message = f"holds a run of another case: {'; '.join(differences[:3])}{more}"
        raise FileError(f"{message}; give another -o, or start anew with --overwrite", file)


def is_same_run(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    """Return whether the cases in two mappings of attributes give the same numbers."""
    cases = [_identity({"effective_case": attributes.get("effective_case", "{}")}) for attributes in (one, other)]
    return cases[0] == cases[1]


def _identity(attributes: Mapping[str, Any]) -> dict[KeyPath, str]:
    """Return the keys and values, as JSON, that decide what numbers a run gives."""
    leaves = dict(_leaves(json.loads(attributes["effective_case"])))
    digests = json.loads(attributes.get("inputs", "{}"))
    leaves |= {("content of", name): digest for name, digest in digests.items()}
    return {key: json.dumps(value) for key, value in leaves.items()}


def _leaves(value: Any, key: KeyPath = ()) -> Iterator[tuple[KeyPath, Any]]:
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
