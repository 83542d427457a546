"""Figures of one style, without pyplot: nothing of it reaches the user's own figures and settings."""

from __future__ import annotations

import io
import textwrap
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colorbar import Colorbar
from matplotlib.figure import Figure

from fretsolve.errors import PictureError

if TYPE_CHECKING:
    from fretsolve.result import Result

Target = Axes | Sequence[Axes] | None
"""Where to draw: on the user's own axes, or (None) on a figure of its own."""

STYLE: dict[Any, Any] = {
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "figure.titlesize": 11.0,
    "legend.fontsize": 8.0,
    "axes.grid": True,
    "grid.color": "0.9",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "lines.linewidth": 1.4,
    "lines.markersize": 4.0,
    "image.interpolation": "nearest",
    "pdf.fonttype": 42,
    "svg.hashsalt": "fretsolve",
    "figure.constrained_layout.h_pad": 0.06,
    "figure.constrained_layout.w_pad": 0.06,
}

DPI = 150
MARGINS = 0.5
"""Height (inches) that heading and legend take."""

NARROWEST = 5.2
"""Width (inches) that a legend of outlines and a title need."""

TITLE_LETTERS = 11.5
"""Letters of a title per inch."""

MOST_TITLE_LINES = 2
BAR_SPACE, BAR_WIDTH = 0.08, 0.14
"""A colour bar's distance from its panel, and its width (inches)."""

WITHOUT_DATE = {"png": {}, "pdf": {"CreationDate": None}, "svg": {"Date": None}}
"""Metadata per format with which the same result gives the same file."""


class Picture(Figure):
    """A figure that notebooks show without pyplot."""

    def _repr_png_(self) -> bytes:
        return rendered(self, "png")


@dataclass(frozen=True)
class Canvas:
    """A figure and the axes of its panels. own: made here, and not given by the user."""

    figure: Figure
    axes: Sequence[Axes]
    own: bool

    def heading(self, result: Result, detail: str = "") -> None:
        """The case's title and a line below it, on a figure of its own."""
        if self.own:
            width = int(TITLE_LETTERS * self.figure.get_figwidth())
            lines = textwrap.wrap(title(result), width, max_lines=MOST_TITLE_LINES, placeholder=" ...")
            self.figure.suptitle("\n".join([*lines, *textwrap.wrap(detail, width)]), parse_math=False)

    def colorbar(self, axes: Axes, colors: ScalarMappable, label: str, extend: str = "neither") -> Colorbar:
        """A colour bar beside a panel whose limits are set, as high as the panel is in the end."""
        width = panel_width(axes)
        place = axes.inset_axes((1.0 + BAR_SPACE / width, 0.0, BAR_WIDTH / width, 1.0))
        return self.figure.colorbar(colors, cax=place, label=label, extend=extend)

    def legend(self, handles: Sequence[Any], columns: int) -> None:
        """A legend below all panels; on the first panel where the axes are the user's."""
        if not handles:
            return
        if self.own:
            self.figure.legend(handles=handles, loc="outside lower center", ncols=columns, frameon=False)
        else:
            self.axes[0].legend(handles=handles)


@contextmanager
def own_style() -> Iterator[None]:
    """Matplotlib's defaults with `STYLE`, whatever the user has set, until the block is left."""
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(STYLE)
        yield


@contextmanager
def canvas(
    target: Target, rows: int, columns: int, size: tuple[float, float], **options: Any
) -> Iterator[Canvas]:
    """A canvas of `rows` x `columns` panels of `size` (inches each), or one of the axes given.

    options: for `Figure.subplots`, such as `sharex`.
    """
    if target is not None:
        axes = [target] if isinstance(target, Axes) else list(target)
        if not axes:
            raise PictureError("no axes given to draw on")
        figure = axes[0].get_figure(root=True)
        if figure is None:
            raise PictureError("the axes given belong to no figure")
        yield Canvas(figure, axes, own=False)
        return
    with own_style():
        width = max(columns * size[0], NARROWEST)
        picture = Picture(figsize=(width, rows * size[1] + MARGINS), layout="constrained")
        grid = picture.subplots(rows, columns, squeeze=False, **options)
        yield Canvas(picture, list(grid.flat), own=True)


def panel_width(axes: Axes) -> float:
    """About how wide a panel is (inches), in equal scales less than its place."""
    figure = axes.get_figure(root=True)
    assert figure is not None, "the axes of a panel belong to a figure"
    place = axes.get_position()
    width = place.width * figure.get_figwidth()
    if axes.get_aspect() == "auto":
        return float(width)
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    return float(min(width, place.height * figure.get_figheight() * (right - left) / (high - low)))


def title(result: Result) -> str:
    """The case's title, or the file's name, in one line, with the status of what is not complete."""
    text = " ".join(str(result.effective_case.get("title") or result.path.name).split())
    printable = "".join(character if character.isprintable() else "?" for character in text)
    status = "" if result.status == "complete" else f"{result.status} with {result.increments} increments: "
    return status + printable


def rendered(figure: Figure, file_format: str) -> bytes:
    """The picture as the content of a PNG, PDF or SVG file."""
    buffer = io.BytesIO()
    with own_style(), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing", UserWarning)  # of a title in other scripts
        figure.savefig(
            buffer, format=file_format, dpi=DPI, metadata=WITHOUT_DATE[file_format], facecolor="white"
        )
    return buffer.getvalue()
