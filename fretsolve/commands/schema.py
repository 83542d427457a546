"""``fretsolve schema``: the JSON Schema of the case file."""

from __future__ import annotations

import json
from pathlib import Path

from fretsolve.case import case_schema
from fretsolve.system.files import require_ending, require_free, writing


def schema_text() -> str:
    """The schema as indented JSON."""
    return json.dumps(case_schema(), indent=2, ensure_ascii=False)


def write_schema(path: Path, *, overwrite: bool) -> int:
    """Write the schema and tell where it lies; the exit code. Raises CaseError, FileError."""
    require_ending(path, "a JSON Schema", ".json")
    require_free(path, overwrite=overwrite)
    with writing(path):
        path.write_text(schema_text() + "\n", encoding="utf-8")
    print(path)
    return 0
