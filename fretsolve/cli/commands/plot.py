"""Carry out ``fretsolve plot``: draw pictures of a result, or all of them with a page that shows them."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from fretsolve.errors import CaseError, PictureError
from fretsolve.post.plots.kinds import KINDS, MOVING, OPTIONS, STILL, PictureKind, Shown
from fretsolve.post.plots.sheet import Sheet
from fretsolve.result import Result, open_result
from fretsolve.system import atomic_files
from fretsolve.system.environment import how_to_install
from fretsolve.system.files import PICTURE_MARK, make_folder, require_ending, require_own, writing
from fretsolve.system.progress import print_warnings

PAGE_NAME = "index.html"


def plot_result(out: Path, kinds: Sequence[str] | None, target: str | None, shown: Shown, sheet: Sheet) -> int:
    """Draw the result `out`, print the names of the pictures, and return the exit code. Raises CaseError, FileError.

    kinds: names, None to draw what the result gives, and a page that shows it; target: a file or a folder.
    """
    require_matplotlib()
    every_kind = kinds is None
    chosen = [KINDS[name] for name in dict.fromkeys(kinds or KINDS)]
    if every_kind:
        chosen = [kind for kind in chosen if not kind.beside or out.with_suffix(kind.beside).exists()]
    _require_effect(shown, chosen, " and ".join(kinds or KINDS), out)
    with open_result(out) as result:
        if every_kind:
            chosen = [kind for kind in chosen if kind.applies_to(result)]
        files = _page_files(target, chosen, result) if every_kind else _files(target, chosen, result.path)
        for path in files:
            require_own(path, PICTURE_MARK.encode(), "a picture")
        pictures, left_out = {}, {}
        for kind, path in zip(chosen, files, strict=True):
            try:
                pictures[kind.name] = kind.content(result, _format(path), shown, sheet)
            except PictureError as error:
                left_out[kind.name] = str(error)
                if every_kind:
                    print(f"left out: {kind.name}: {error}")
            else:
                write_picture(path, pictures[kind.name])
        if every_kind:
            from fretsolve.post.plots.report_page import html_page, increment_frames

            frames = increment_frames(result) if result.steps and result.fields else {}
            page = html_page(result, pictures, left_out, frames, sheet.dpi)
            _write(files[0].with_name(PAGE_NAME), page.encode())
        elif not pictures:
            raise CaseError("; ".join(f"{name}: {reason}" for name, reason in left_out.items()), (), result.path)
        else:
            print_warnings(result.path, *(f"{name}: not drawn: {reason}" for name, reason in left_out.items()))
    return 0


def _require_effect(shown: Shown, kinds: Sequence[PictureKind], names: str, out: Path) -> None:
    """Raise CaseError for an option that none of the kinds takes."""
    given = {"--step": shown.steps, "--at": shown.at, "--field": shown.fields, "--body": shown.body}
    for option, value in given.items():
        if value and not any(OPTIONS[name] == option for kind in kinds for name in kind.options):
            raise CaseError(f"{option} has no effect on {names}; leave it out", (), out)


def require_matplotlib() -> None:
    """Raise CaseError if matplotlib cannot be imported."""
    os.environ["MPLBACKEND"] = "agg"  # pictures go to files; a wrong name in it would end the import
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        raise CaseError(
            f"pictures need matplotlib, which cannot be imported ({error}): {how_to_install('plot')}"
        ) from error


def _files(target: str | None, kinds: Sequence[PictureKind], result: Path) -> list[Path]:
    """Return the file of each kind. Raises CaseError if `target` does not fit."""
    out = Path(target) if target else result.parent
    if out.is_dir() or (target or "").endswith(os.sep) or (len(kinds) > 1 and not out.suffix):
        make_folder(out)
        return [out / f"{result.stem}.{kind.name}.{kind.formats[0]}" for kind in kinds]
    if len(kinds) > 1:
        raise CaseError(f"one file cannot hold {len(kinds)} pictures: name a folder", (), out)
    require_ending(out, f"a picture of kind {kinds[0].name}", *(f".{name}" for name in kinds[0].formats))
    return [out]


def _page_files(target: str | None, kinds: Sequence[PictureKind], result: Result) -> list[Path]:
    """Return the file of each kind in a folder of their own. Raises CaseError if there is nothing to draw."""
    folder = Path(target) if target else result.path.with_suffix(".plots")
    if _format(folder) in (*STILL, *MOVING, "html"):
        raise CaseError("--all writes many files; the name of a folder is needed", (), folder)
    if not result.increments:
        raise CaseError(result.why_empty, (), result.path)
    from fretsolve.post.plots.report_page import OWN_MARK

    make_folder(folder)
    require_own(folder / PAGE_NAME, OWN_MARK.encode(), "a page")
    return [folder / f"{kind.name}.{kind.formats[0]}" for kind in kinds]


def picture_format(path: Path) -> str:
    """Return the format of a still picture by its name. Raises CaseError if the name has none."""
    require_ending(path, "a picture", *(f".{name}" for name in STILL))
    return _format(path)


def _format(path: Path) -> str:
    return path.suffix.removeprefix(".").lower()


def write_picture(path: Path, content: bytes) -> None:
    """Write a picture and print its name. Raises FileError, also if another file than a picture is there."""
    require_own(path, PICTURE_MARK.encode(), "a picture")
    _write(path, content)


def _write(path: Path, content: bytes) -> None:
    exclusive = not os.path.lexists(path)
    with writing(path), atomic_files.new_file(path, durable=False, exclusive=exclusive) as file:
        file.write(content)
    print(path, flush=True)
