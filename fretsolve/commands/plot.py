"""``fretsolve plot``: pictures of a result as files, and a report that has them all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fretsolve.errors import CaseError, PictureError
from fretsolve.plots import KINDS
from fretsolve.result import open_result
from fretsolve.system.files import make_folder, writing
from fretsolve.system.optional import how_to_install

if TYPE_CHECKING:
    from fretsolve.plots.kinds import Kind, Selection
    from fretsolve.result import Result

DEFAULT_KIND = "loop"


@dataclass(frozen=True)
class PlotOrder:
    """What the command line asks for.

    out: a file, a folder or None; to_folder: it is meant as a folder; every_kind: all kinds and a report.
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
    """Write the pictures and tell where they lie; the exit code. Raises CaseError, FileError."""
    require_matplotlib()
    from fretsolve.plots.kinds import Selection, kind_of

    selection = Selection(order.steps, order.at, order.fields)
    kinds = [kind_of(name) for name in (KINDS if order.every_kind else order.kinds or (DEFAULT_KIND,))]
    _require_heeded(selection, kinds)
    with open_result(order.result) as result:
        if order.every_kind:
            _write_report(result, kinds, selection, order.out or result.path.with_suffix(".plots"))
            return 0
        for kind, path in zip(kinds, _files(order, kinds, result.path), strict=True):
            try:
                content = kind.draw(result, selection, _format(path))
            except PictureError as error:
                raise CaseError(f"{kind.name}: {error}", (), result.path) from error
            write_picture(path, content)
    return 0


def require_matplotlib() -> None:
    """Raise CaseError where there is none."""
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        raise CaseError(
            f"pictures need matplotlib, which cannot be imported ({error}): {how_to_install('plot')}"
        ) from error


def _require_heeded(selection: Selection, kinds: Sequence[Kind]) -> None:
    """Raise CaseError for an option that none of the kinds heeds."""
    given = {"--step": selection.steps, "--at": selection.at, "--field": selection.fields}
    for option, value in given.items():
        if value and not any(option in kind.options for kind in kinds):
            names = " and ".join(kind.name for kind in kinds)
            raise CaseError(f"{option} has no effect on {names}; leave it out")


def _files(order: PlotOrder, kinds: Sequence[Kind], result: Path) -> list[Path]:
    """Where the picture of each kind goes. Raises CaseError where `-o` does not fit."""
    out = order.out
    if out is None or out.is_dir() or order.to_folder or (len(kinds) > 1 and not out.suffix):
        folder = result.parent if out is None else out
        make_folder(folder)
        return [folder / f"{result.stem}.{kind.name}.{kind.formats[0]}" for kind in kinds]
    if len(kinds) > 1:
        raise CaseError(f"one file cannot hold {len(kinds)} pictures: name a folder", (), out)
    if _format(out) not in kinds[0].formats:
        allowed = ", ".join(f".{name}" for name in kinds[0].formats)
        raise CaseError(f"no name for {kinds[0].name}; one that ends on {allowed} is needed", (), out)
    return [out]


def picture_format(path: Path) -> str:
    """The format of a still picture by its name. Raises CaseError for a name of none."""
    from fretsolve.plots.kinds import STILL

    if _format(path) not in STILL:
        raise CaseError(f"no name for a picture; one that ends on .{', .'.join(STILL)} is needed", (), path)
    return _format(path)


def _format(path: Path) -> str:
    return path.suffix.removeprefix(".").lower()


def _write_report(result: Result, kinds: Sequence[Kind], selection: Selection, folder: Path) -> None:
    """All pictures and ``index.html`` in `folder`. Raises CaseError, FileError."""
    from fretsolve.plots.kinds import MOVING, STILL
    from fretsolve.plots.load_history import require_increments
    from fretsolve.plots.page import Entry, html_page

    if _format(folder) in (*STILL, *MOVING, "html"):
        raise CaseError("--all writes many files; the name of a folder is needed", (), folder)
    try:
        require_increments(result)
    except PictureError as error:
        raise CaseError(str(error), (), result.path) from error
    make_folder(folder)
    entries = []
    for kind in kinds:
        try:
            content = kind.draw(result, selection, kind.formats[0])
            entries.append(Entry(kind, kind.formats[0], content))
        except PictureError as error:
            entries.append(Entry(kind, reason=str(error)))
    for entry in entries:
        if entry.reason:
            print(f"left out: {entry.kind.name}: {entry.reason}")
        else:
            write_picture(folder / f"{entry.kind.name}.{entry.file_format}", entry.content)
    write_picture(folder / "index.html", html_page(result, entries).encode())


def write_picture(path: Path, content: bytes) -> None:
    """Write a file and say so. Raises FileError."""
    with writing(path):
        path.write_bytes(content)
    print(path, flush=True)
