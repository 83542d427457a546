"""Damage to files: bytes and bits of any file, and the structure of HDF5 files."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import h5py
import numpy as np

BLOCKS = (1, 2, 3, 8, 16, 64, 200, 512)
KINDS = ("bit", "byte", "zeros", "ones", "noise", "cut", "longer", "removed", "repeated", "moved")


def damaged(data: bytes, chance: random.Random) -> bytes:
    """Return other bytes than `data`, as a bad disk, a broken copy or a text editor makes them."""
    while (other := _damaged(data, chance.choice(KINDS), chance)) == data:
        pass
    return other


def _damaged(data: bytes, kind: str, chance: random.Random) -> bytes:
    at, size = chance.randrange(len(data)), chance.choice(BLOCKS)
    before, block, after = data[:at], data[at : at + size], data[at + size :]
    match kind:
        case "bit":
            return before + bytes([data[at] ^ 1 << chance.randrange(8)]) + data[at + 1 :]
        case "byte":
            return before + chance.randbytes(1) + data[at + 1 :]
        case "zeros":
            return before + bytes(len(block)) + after
        case "ones":
            return before + b"\xff" * len(block) + after
        case "noise":
            return before + chance.randbytes(len(block)) + after
        case "cut":
            return before
        case "longer":
            return data + chance.randbytes(size)
        case "removed":
            return before + after
        case "repeated":
            return before + block + block + after
        case _:
            return before + after + block


def restructured(path: Path, chance: random.Random) -> str:
    """Change the structure of an HDF5 file as no disk would, and return what was done."""
    with h5py.File(path, "r+") as file:
        names: list[str] = []
        file.visit(names.append)
        name, kind = chance.choice(names), chance.choice(list(_REPLACEMENTS))
        old = file[name]
        values = old[()] if isinstance(old, h5py.Dataset) and old.shape is not None else np.arange(3.0)
        if kind == "attribute":
            owner = chance.choice([file, old])
            for attribute in chance.sample(sorted(owner.attrs), min(1, len(owner.attrs))):
                owner.attrs[attribute] = chance.choice(["", "failed", "{}", 3, np.nan, [1, 2], b"\xff\xfe", "[" * 2000])
            return f"{kind} of {name}"
        del old, file[name]
        _REPLACEMENTS[kind](file, name, values)
    return f"{kind} for {name}"


def _virtual(file: Any, name: str, values: Any) -> None:
    layout = h5py.VirtualLayout((3,), "float64")
    layout[:] = h5py.VirtualSource("elsewhere.h5", "values", (3,))
    file.create_virtual_dataset(name, layout)


def _external(file: Any, name: str, values: Any) -> None:
    file.create_dataset(name, (3,), "float64", external=[("/etc/passwd", 0, 24)])


def _put(file: Any, name: str, values: Any) -> None:
    file[name] = values


_REPLACEMENTS: dict[str, Any] = {
    "nothing": lambda file, name, values: None,
    "scalar": lambda file, name, values: _put(file, name, 1.0),
    "group": lambda file, name, values: file.create_group(name),
    "empty": lambda file, name, values: _put(file, name, np.zeros(0)),
    "null": lambda file, name, values: _put(file, name, h5py.Empty("f8")),
    "shorter": lambda file, name, values: _put(file, name, np.atleast_1d(values)[:-1]),
    "longer": lambda file, name, values: _put(file, name, np.repeat(np.atleast_1d(values), 2, axis=0)),
    "deeper": lambda file, name, values: _put(file, name, np.asarray(values)[..., None]),
    "text": lambda file, name, values: _put(file, name, ["a", "bb", "\u202e=1"]),
    "bytes": lambda file, name, values: _put(file, name, np.array([b"a", b"\xff"])),
    "compound": lambda file, name, values: _put(file, name, np.zeros(3, [("a", "f8"), ("b", "i4")])),
    "complex": lambda file, name, values: _put(file, name, np.zeros(np.shape(values), complex)),
    "nan": lambda file, name, values: _put(file, name, np.full(np.shape(values), np.nan)),
    "infinite": lambda file, name, values: _put(file, name, np.full(np.shape(values), -np.inf)),
    "huge": lambda file, name, values: file.create_dataset(name, (2**40,), "f8", chunks=(1024,)) and None,
    "huge planes": lambda file, name, values: file.create_dataset(name, (4, 2**20, 2**20), "f8", chunks=True) and None,
    "soft link": lambda file, name, values: _put(file, name, h5py.SoftLink(f"/{name}")),
    "external link": lambda file, name, values: _put(file, name, h5py.ExternalLink("elsewhere.h5", "/values")),
    "virtual": _virtual,
    "external": _external,
    "attribute": None,
}
