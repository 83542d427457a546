"""Carry out ``fretsolve surface``: read and prepare a measured map, say what it is, and draw it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from fretsolve.case.keys.map_keys import HeightsSurface
from fretsolve.case.line_case import LineHeights
from fretsolve.case.loading import CaseText, validated
from fretsolve.case.source import CaseSource, Place
from fretsolve.cli.commands.plot import picture_format, require_matplotlib, write_picture
from fretsolve.cli.map_summary import map_lines
from fretsolve.errors import CaseError, CaseErrors, together
from fretsolve.post.plots.sheet import Sheet
from fretsolve.problem.surface.load_map import load_height_map
from fretsolve.problem.surface.map_measures import measures_of, point_warnings
from fretsolve.system.progress import print_warnings


def describe_map(file: Path, overrides: Sequence[str], profile: bool, picture: Path | None, sheet: Sheet) -> int:
    """Print what a map is after its steps, draw it into `picture`, and return the exit code.

    overrides: KEY=VALUE with the keys of `heights`; profile: whether it is one of a line contact. Raises CaseError,
    FileError.
    """
    if picture is not None:
        require_matplotlib()
        picture_format(picture)
    data = {"file": str(file.absolute())}
    source = CaseSource(file, "", Place(1), data=data)
    text = CaseText(data, source).overridden(overrides)
    try:
        heights = validated(LineHeights if profile else HeightsSurface, text.data, text.source, text.problems)
        found = load_height_map(heights, ())
    except CaseError as error:  # keys stand on the command line and not in a line of the file
        problems = error.problems if isinstance(error, CaseErrors) else (error,)
        raise together([CaseError(one.message, one.key, file) for one in problems]) from None
    measures = measures_of(found)
    print(*map_lines(found, measures), sep="\n", flush=True)
    print_warnings(file, *found.doubts, *point_warnings(measures))
    if picture is not None:
        from fretsolve.post.plots.canvas import rendered
        from fretsolve.post.plots.pictures.surfaces import ShownMap, draw_maps

        figure = draw_maps([ShownMap("heights", (0.0, 0.0), found)], file.name, sheet)
        write_picture(picture, rendered(figure, picture_format(picture), sheet.dpi))
    return 0
