"""Keep what takes long in files, so that a script that was stopped goes on where it was."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any


def kept(folder: Path | None, name: str, make: Callable[[], Any]) -> Any:
    """Return what `make` returns, as JSON has it, from the file of that name in `folder` if it is there.

    Without a folder nothing is kept. Delete the folder where the solver or the cases have changed.
    """
    if folder is None:
        return make()
    file = folder / f"{re.sub('[^A-Za-z0-9.]+', '_', name)}.json"
    if not file.exists():
        folder.mkdir(parents=True, exist_ok=True)
        unfinished = file.with_suffix(".part")
        unfinished.write_text(json.dumps(make()))
        unfinished.rename(file)
    return json.loads(file.read_text())
