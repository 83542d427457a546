"""Whose run a file or a parts folder is: attributes and header, checked for kind and version."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import h5py

from fretsolve import __version__
from fretsolve.errors import FileError
from fretsolve.result.header import RunHeader
from fretsolve.result.layout import FORMAT_VERSION
from fretsolve.result.parts import HEADER_NAME, damage_reported


def read_attributes(out: Path) -> dict[str, Any]:
    """The root attributes of a result file. Raises FileError: no result, damaged, of a newer format."""
    if out.exists() and out.stat().st_size == 0:
        raise FileError("the file is empty", out)
    with damage_reported(out), h5py.File(out, "r") as file:
        attributes = dict(file.attrs)
    if "format_version" not in attributes or "fretsolve_version" not in attributes:
        raise FileError("an HDF5 file, but not a result of fretsolve", out)
    require_known_format(out, int(attributes["format_version"]), str(attributes["fretsolve_version"]))
    return {**attributes, "format_version": int(attributes["format_version"])}


def read_header(folder: Path) -> RunHeader:
    """The header in a parts folder. Raises FileError, and FileNotFoundError where there is none."""
    path = folder / HEADER_NAME
    text = path.read_text()
    try:
        values = json.loads(text)
        require_known_format(path, values["format_version"], values["version"])
        return RunHeader.from_json(text)
    except (ValueError, TypeError, KeyError) as error:
        raise FileError(f"not the header of a run: {error}", path) from error


def require_known_format(file: Path, format_version: int, version: str) -> None:
    """Raise FileError where this version is too old to read `file`."""
    if format_version > FORMAT_VERSION:
        raise FileError(
            f"has format {format_version}, written by fretsolve {version}; this is {__version__}, which reads"
            f" formats up to {FORMAT_VERSION}: install fretsolve {version} or newer",
            file,
        )
