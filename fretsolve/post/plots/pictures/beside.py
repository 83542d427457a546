"""Open the files beside a result that pictures draw."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

from fretsolve.errors import PictureError
from fretsolve.post.stress.computed_file import CONTENTS, ComputedFile, Kind, opened_computed, require_readable
from fretsolve.post.stress.influence import Body
from fretsolve.result import Result

OfBody = TypeVar("OfBody")


@contextmanager
def file_beside(result: Result, path: Path, kind: Kind) -> Iterator[ComputedFile]:
    """Open the file of a kind beside a result. Raises PictureError if it is not of the result, FileError if damaged."""
    with opened_computed(path) as computed:
        if computed is None and path.exists():
            require_readable(path)
        if computed is None or computed.kind != kind:
            content = CONTENTS[kind].removeprefix("a ")
            is_no, it = ("is no", "it") if content != CONTENTS[kind] else ("are no", "them")
            raise PictureError(f"there {is_no} {content} in {path.name}; `fretsolve {kind}` writes {it}")
        if computed.attributes.get("effective_case") != result.attributes["effective_case"]:
            raise PictureError(f"{path.name} is not of this result; `fretsolve {kind} --overwrite` writes it again")
        yield computed


def chosen_bodies(found: Mapping[int, OfBody], body: Body | None, what: str) -> dict[int, OfBody]:
    """Return the bodies to draw, by number, all by default; what: the content of the file. Raises PictureError."""
    if body is None:
        return dict(found)
    if body not in found:
        there = " and ".join(f"body {number}" for number in found)
        raise PictureError(f"the file has no {what} of body {body}, only of {there}")
    return {body: found[body]}
