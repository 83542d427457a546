"""Beginnings that cases of a sweep share: the stages up to which their load paths and all else agree.

A beginning is solved once, by the first case that comes to its end. The other cases go on from its last state, and have
the numbers of a run alone. The file of a beginning is a convenience: where it is missing or damaged, a case is solved
from its start. Pressing unlike bodies takes many increments, so a sweep of their shear takes 1.2 to 1.9 times as long
without this module; like bodies are pressed in one increment, too short to be shared.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Annotated

from pydantic import Field

from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result import RunHeader

FOLDER_NAME = "beginnings"
_FILE_NAME = re.compile(r"[0-9a-f]{16}\.h5")

LEAST_SECONDS = 0.05
"""Estimated time of a beginning from which it is shared: to write or to read one takes 10 to 20 ms."""

OF_THE_PATH = ("title", "expect", "load_path")
"""Keys of a case on which its increments do not depend, beyond what is imposed in them."""


@dataclass(frozen=True)
class Beginning:
    """The first increments of a case, up to the end of a stage. key: equal where they give equal numbers."""

    key: Annotated[str, Field(pattern=r"^[0-9a-f]{16}$")]  # becomes the name of a file
    increments: Annotated[int, Field(ge=1)]


def beginnings_of(setup: ProblemSetup, header: RunHeader, seconds: float) -> tuple[Beginning, ...]:
    """Return the beginnings of a case, one for each stage but the last, where they take long enough to be shared.

    None with error bars, which need all stages, and none where cycles end by themselves. seconds: estimated time of the
    case.
    """
    periodic = any(stage.cycle is not None and stage.cycle.until for stage in setup.load_path.stages)
    if setup.case.solver.error_bars or periodic:
        return ()
    case = {name: value for name, value in header.case.items() if name not in OF_THE_PATH}
    model, axes = setup.model, (header.x.tolist(), header.y.tolist())
    terms = (astuple(model.terms), model.has_shear, model.may_slip)
    columns = [one.name for one in header.optional_columns]
    rest = json.dumps([case, header.inputs, header.version, axes, terms, columns], sort_keys=True)
    digest = hashlib.sha256(rest.encode())
    found = []
    for last_step, imposed in zip(setup.load_path.last_steps[:-1], setup.load_path.imposed_in_stages(), strict=False):
        digest.update(json.dumps(imposed).encode())
        if seconds * (last_step + 1) >= LEAST_SECONDS * setup.load_path.increments:
            found.append(Beginning(digest.hexdigest()[:16], last_step + 1))
    return tuple(found)


def shared(beginnings: Mapping[str, Sequence[Beginning]]) -> dict[str, tuple[Beginning, ...]]:
    """Return the beginnings of each case (by its id) from which other cases go on in another way."""
    counts = Counter(one.key for own in beginnings.values() for one in own)
    found = {}
    for name, own in beginnings.items():
        later = [*(counts[one.key] for one in own[1:]), 1]
        found[name] = tuple(one for one, longer in zip(own, later, strict=False) if counts[one.key] > longer)
    return found


def files_of(beginnings: Sequence[Beginning], folder: Path) -> dict[int, Path]:
    """Return the files of beginnings in the folder of a sweep, by their last steps."""
    return {one.increments - 1: folder / FOLDER_NAME / f"{one.key}.h5" for one in beginnings}


def remove_beginnings(folder: Path) -> None:
    """Remove the beginnings in the folder of a sweep, and what held them if nothing else is there."""
    held = folder / FOLDER_NAME
    if held.is_symlink():
        return
    with suppress(OSError):
        for path in held.iterdir():
            if _FILE_NAME.fullmatch(path.name) and not path.is_dir():
                path.unlink()
        held.rmdir()  # fails if it is not empty
