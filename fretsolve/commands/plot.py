"""Carry out ``fretsolve plot``: draw pictures of a result, or all of them with a page that shows them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from fretsolve.errors import CaseError, PictureError
from fretsolve.plots.kinds import KINDS, MOVING, STILL, PictureKind, Selection
from fretsolve.result import Result, open_result
from fretsolve.system.files import make_folder, writing
from fretsolve.system.optional import how_to_install

DEFAULT_KIND = "loop"


@dataclass(frozen=True)
class PlotOrder:
    """What the command line asks for.

    out: a file, a folder or None; to_folder: `out` is meant as a folder; every_kind: all kinds and the page.
    """

    result: Path
    kinds: tuple[str, ...]
    out: Path | None
    to_folder: bool
    steps: tuple[int, ...]
    at: tuple[float, float] | None
    fields: tuple[str, ...]
    every_kind: bool


def plot_result(order: PlotOrder) -> int:
    """Write the pictures, print their names, and return the exit code. Raises CaseError, FileError."""
    require_matplotlib()
    selection = Selection(order.steps, order.at, order.fields)
    kinds = [KINDS[name] for name in (KINDS if order.every_kind else order.kinds or (DEFAULT_KIND,))]
    _require_used(selection, kinds)
    with open_result(order.result) as result:
        if order.every_kind:
            _write_page(result, kinds, selection, order.out or result.path.with_suffix(".plots"))
            return 0
        for kind, path in zip(kinds, _targets(order, kinds, result.path), strict=True):
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


def _require_used(selection: Selection, kinds: Sequence[PictureKind]) -> None:
    """Raise CaseError for an option that none of the kinds uses."""
    given = {"--step": selection.steps, "--at": selection.at, "--field": selection.fields}
    for option, value in given.items():
        if value and not any(option in kind.options.values() for kind in kinds):
            names = " and ".join(kind.name for kind in kinds)
            raise CaseError(f"{option} has no effect on {names}; leave it out")


def _targets(order: PlotOrder, kinds: Sequence[PictureKind], result: Path) -> list[Path]:
    """Return the file of each kind. Raises CaseError if `-o` does not fit."""
    out = order.out
    if out is None or out.is_dir() or order.to_folder or (len(kinds) > 1 and not out.suffix):
        folder = result.parent if out is None else out
        make_folder(folder)
        return [folder / f"{result.stem}.{kind.name}.{kind.formats[0]}" for kind in kinds]
    if len(kinds) > 1:
        raise CaseError(f"one file cannot hold {len(kinds)} pictures: name a folder", (), out)
    require_format(out, kinds[0].name, kinds[0].formats)
    return [out]


def require_format(path: Path, what: str, formats: Sequence[str]) -> None:
    """Raise CaseError if a name does not end on one of `formats`; what: the picture."""
    if _format(path) not in formats:
        allowed = ", ".join(f".{name}" for name in formats)
        raise CaseError(f"no name for {what}; one that ends on {allowed} is needed", (), path)


def picture_format(path: Path) -> str:
    """Return the format of a still picture by its name. Raises CaseError if the name has none."""
    require_format(path, "a picture", STILL)
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
