"""``fretsolve schema``: the JSON Schema of the case file."""

from __future__ import annotations

import json
from pathlib import Path

from fretsolve.case import case_schema
from fretsolve.errors import CaseError, FileError


def schema_text() -> str:
    """The schema as indented JSON."""
    return json.dumps(case_schema(), indent=2, ensure_ascii=False)


def write_schema(path: Path) -> int:
    """Write the schema and tell where it lies; the exit code. Raises CaseError, FileError."""
    if path.suffix.lower() != ".json":
        raise CaseError("no name for a JSON Schema; one that ends on .json is needed", (), path)
    try:
        path.write_text(schema_text() + "\n", encoding="utf-8")
    except OSError as error:
        raise FileError(f"cannot be written: {error.strerror or error}", path) from error
    print(path)
    return 0
