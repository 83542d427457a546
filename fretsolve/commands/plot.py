"""Carry out ``fretsolve plot``: draw pictures of a result, or all of them with a page that shows them."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from pathlib import Path

from fretsolve.errors import CaseError, PictureError
from fretsolve.plots.kinds import KINDS, MOVING, STILL, PictureKind, Selection
from fretsolve.result import Result, open_result
from fretsolve.system.environment import how_to_install
from fretsolve.system.files import make_folder, require_ending, writing

DEFAULT_KIND = "loop"


def plot_result(
    out: Path,
    kinds: Iterable[str],
    target: str | None,
    steps: tuple[int, ...],
    at: tuple[float, float] | None,
    fields: tuple[str, ...],
    every_kind: bool,
) -> int:
    """Draw the result `out`, print the names of the pictures, and return the exit code. Raises CaseError, FileError.

    target: a file or a folder; every_kind: write a page that shows them as well. The rest is for the pictures.
    """
    require_matplotlib()
    selection = Selection(steps, at, fields)
    chosen = [KINDS[name] for name in (KINDS if every_kind else kinds or (DEFAULT_KIND,))]
    _require_used(selection, chosen, out)
    with open_result(out) as result:
        if every_kind:
            _write_page(result, chosen, selection, Path(target) if target else result.path.with_suffix(".plots"))
            return 0
        for kind, path in zip(chosen, _targets(target, chosen, result.path), strict=True):
            try:
                content = kind.content(result, selection, _format(path))
            except PictureError as error:
                raise CaseError(f"{kind.name}: {error}", (), result.path) from error
            write_picture(path, content)
    return 0


def require_matplotlib() -> None:
    """Raise CaseError if matplotlib cannot be imported."""
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        raise CaseError(
            f"pictures need matplotlib, which cannot be imported ({error}): {how_to_install('plot')}"
        ) from error


def _require_used(selection: Selection, kinds: Sequence[PictureKind], result: Path) -> None:
    """Raise CaseError for an option that none of the kinds uses."""
    given = {"--step": selection.steps, "--at": selection.at, "--field": selection.fields}
    for option, value in given.items():
        if value and not any(option in kind.options.values() for kind in kinds):
            names = " and ".join(kind.name for kind in kinds)
            raise CaseError(f"{option} has no effect on {names}; leave it out", (), result)


def _targets(target: str | None, kinds: Sequence[PictureKind], result: Path) -> list[Path]:
    """Return the file of each kind. Raises CaseError if `target` does not fit."""
    out = Path(target) if target else result.parent
    if out.is_dir() or (target or "").endswith(os.sep) or (len(kinds) > 1 and not out.suffix):
        make_folder(out)
        return [out / f"{result.stem}.{kind.name}.{kind.formats[0]}" for kind in kinds]
    if len(kinds) > 1:
        raise CaseError(f"one file cannot hold {len(kinds)} pictures: name a folder", (), out)
    require_ending(out, kinds[0].name, *(f".{name}" for name in kinds[0].formats))
    return [out]


def picture_format(path: Path) -> str:
    """Return the format of a still picture by its name. Raises CaseError if the name has none."""
    require_ending(path, "a picture", *(f".{name}" for name in STILL))
    return _format(path)


def _format(path: Path) -> str:
    return path.suffix.removeprefix(".").lower()


def _write_page(result: Result, kinds: Sequence[PictureKind], selection: Selection, folder: Path) -> None:
    """Write all pictures and ``index.html`` to `folder`. Raises CaseError, FileError."""
    from fretsolve.plots.report_page import html_page

    if _format(folder) in (*STILL, *MOVING, "html"):
        raise CaseError("--all writes many files; the name of a folder is needed", (), folder)
    if not result.increments:
        raise CaseError(result.why_empty, (), result.path)
    make_folder(folder)
    pictures, left_out = {}, {}
    for kind in kinds:
        try:
            pictures[kind.name] = kind.content(result, selection, kind.formats[0])
        except PictureError as error:
            left_out[kind.name] = str(error)
            print(f"left out: {kind.name}: {error}")
        else:
            write_picture(folder / f"{kind.name}.{kind.formats[0]}", pictures[kind.name])
    write_picture(folder / "index.html", html_page(result, pictures, left_out).encode())


def write_picture(path: Path, content: bytes) -> None:
    """Write a file and print its name. Raises FileError."""
    with writing(path):
        path.write_bytes(content)
    print(path, flush=True)
