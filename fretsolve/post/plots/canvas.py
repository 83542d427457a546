"""Make figures of one style without pyplot, so that the user's own figures and settings stay as they are."""

from __future__ import annotations

import io
import re
import textwrap
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colorbar import Colorbar
from matplotlib.figure import Figure

from fretsolve.errors import PictureError
from fretsolve.post.plots.sheet import Sheet
from fretsolve.result import Result
from fretsolve.system.files import PICTURE_MARK

ONE_COLUMN, TWO_COLUMNS = 90.0 / 25.4, 190.0 / 25.4
"""Widths of a figure in a journal of two columns (inches)."""

Target = Axes | Sequence[Axes] | Sheet | None
"""Place to draw: the user's own axes, or a new figure."""

STYLE: dict[Any, Any] = {
    "font.size": 8.0,
    "axes.titlesize": 8.5,
    "figure.titlesize": 9.0,
    "legend.fontsize": 7.5,
    "axes.grid": True,
    "grid.color": "0.9",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "lines.linewidth": 1.2,
    "lines.markersize": 3.5,
    "image.interpolation": "nearest",
    "pdf.fonttype": 42,
    "svg.hashsalt": "fretsolve",
    "figure.constrained_layout.h_pad": 0.05,
    "figure.constrained_layout.w_pad": 0.05,
}

NO_BREAK = "\N{NO-BREAK SPACE}"

MOST_COLUMNS = 2
"""Panels side by side."""

PANEL_WIDTH = 3.7
"""Inches of a panel of curves or of a section, of which two are side by side on a page."""

BELOW_LABEL: dict[str, Any] = {
    "loc": "upper center",
    "bbox_to_anchor": (0.5, 0.0),
    "borderaxespad": 4.2,
    "frameon": False,
}
"""Place of a legend below the label of the x axis, whose distance is one of letters, however high the panel is."""

LETTERS = 18
"""Letters per inch of an entry in a legend, with the signs of its symbols."""

METADATA = {
    "png": {"Software": PICTURE_MARK},
    "pdf": {"Creator": PICTURE_MARK, "CreationDate": None},
    "svg": {"Creator": PICTURE_MARK, "Date": None},
}
"""Metadata per format with which the same result gives the same file."""


class Picture(Figure):
    """A figure that notebooks show without pyplot."""

    def _repr_png_(self) -> bytes:
        return rendered(self, "png", 150)


@dataclass(frozen=True)
class Canvas:
    """A figure and the axes of its panels. own: made here, and not given by the user; titled: it
    has a heading.
    """

    figure: Figure
    axes: Sequence[Axes]
    own: bool
    titled: bool

    def heading(self, title: str, detail: str = "") -> None:
        """Write a title and a line below it on a new figure. Only the line may have symbols between $."""
        if self.titled:
            width = int(14.0 * self.figure.get_figwidth())  # letters
            lines = textwrap.wrap(title, width, max_lines=2, placeholder=" ...")
            plain = [line.replace("$", r"\$") for line in lines]
            self.figure.suptitle("\n".join([*plain, *_wrapped(detail, width)]))

    def colorbar(self, axes: Axes, colors: ScalarMappable, label: str = "", extend: str = "neither") -> Colorbar:
        """Add a colour bar of 0.14 inches beside a panel whose limits are set, as high as the panel is in the end."""
        width = panel_width(axes)
        place = axes.inset_axes((1.0 + 0.08 / width, 0.0, 0.14 / width, 1.0))
        lines = textwrap.wrap(label, max(int(panel_height(axes) / 0.062), 12), break_on_hyphens=False)  # of a letter
        return self.figure.colorbar(colors, cax=place, label="\n".join(lines), extend=extend)

    def legend(self, handles: Sequence[Any], columns: int) -> None:
        """Add a legend below all panels of a new figure, or on the first of the user's axes."""
        if handles and self.own:
            most = max(1, int(self.figure.get_figwidth() / 1.7))  # inches of an entry
            columns = min(columns, most)
            width = int(LETTERS * self.figure.get_figwidth() / columns)
            texts = [str(handle.get_label()).replace(" = ", "\xa0=\xa0") for handle in handles]
            labels = [textwrap.fill(text, width).replace("\xa0", " ") for text in texts]
            self.figure.legend(handles, labels, loc="outside lower center", ncols=columns, frameon=False)
        elif handles:
            self.axes[0].legend(handles=handles)


def _wrapped(detail: str, width: int) -> list[str]:
    """Return lines of about `width` letters, with a quantity and its value in one of them."""
    kept = re.sub(r" = \S+( [^\s,]+(?=,|$))?", lambda found: found[0].replace(" ", NO_BREAK), detail)
    return [line.replace(NO_BREAK, " ") for line in textwrap.wrap(kept, width)]


@contextmanager
def own_style() -> Iterator[None]:
    """Use matplotlib's defaults with `STYLE` inside the block, whatever the user has set.

    Letters that the font lacks, as of titles in other scripts, cause no warning.
    """
    with matplotlib.rc_context(), warnings.catch_warnings():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(STYLE)
        warnings.filterwarnings("ignore", "Glyph .* missing", UserWarning)
        yield


@contextmanager
def canvas(
    target: Target,
    count: int,
    size: tuple[float, float],
    columns: int = MOST_COLUMNS,
    *,
    share: str = "",
    narrowest: float = 0.72,
    heights: Sequence[float] = (),
) -> Iterator[Canvas]:
    """Make a canvas of `count` panels of about `size` (inches each) in at most `columns`, or one of the axes given.

    A new figure is as wide as its sheet says, else one column of a journal, or two if its panels need more. share: "x",
    all panels have one x axis, or "row", the panels of a row have one y axis. narrowest: least part of its width that a
    panel keeps, since a narrower sheet has fewer side by side. heights: heights of the panels (inches) where they
    differ, of which a row has the largest. Raises PictureError for axes that belong to no figure.
    """
    if target is not None and not isinstance(target, Sheet):
        axes = [target] if isinstance(target, Axes) else list(target)
        if not axes:
            raise PictureError("no axes given to draw on")
        yield Canvas(_figure_of(axes[0]), axes, own=False, titled=False)
        return
    sheet = target or Sheet()
    columns = min(columns, count)
    width = (
        sheet.width / 25.4 if sheet.width else (ONE_COLUMN if columns * size[0] <= 1.2 * ONE_COLUMN else TWO_COLUMNS)
    )
    columns = min(columns, max(1, int(width / (narrowest * size[0]))))
    rows = -(-count // columns)
    each = heights or [size[1]] * count
    tall = [max(each[row * columns : (row + 1) * columns]) for row in range(rows)]
    height = sum(tall) * min(width / (columns * size[0]), 1.25)
    with own_style():
        # a legend below the panels and a title need some more height
        picture = Picture(figsize=(width, height + 0.4), layout="constrained")
        panels = picture.subplots(
            rows,
            columns,
            squeeze=False,
            sharex=share == "x",
            sharey="row" if share == "row" else False,
            height_ratios=tall,
        ).ravel()
        for unused in panels[count:]:
            unused.remove()
        yield Canvas(picture, list(panels[:count]), own=True, titled=sheet.title)


def scaled_height(aspect: float, width: float) -> float:
    """Return the height (inches) of a panel `width` wide whose axes have one scale.

    aspect: height of the axes over their width. A colour bar, labels and a title take a part of both.
    """
    return min(max((width - 1.4) * aspect, 0.5), 4.0) + 0.75


def panel_width(axes: Axes) -> float:
    """Return about how wide a panel is (inches); with equal scales it may not fill its place."""
    axes.apply_aspect()
    return float(axes.bbox.width / _figure_of(axes).dpi)


def panel_height(axes: Axes) -> float:
    """Return about how high a panel is (inches); with equal scales it may not fill its place."""
    axes.apply_aspect()
    return float(axes.bbox.height / _figure_of(axes).dpi)


def _figure_of(axes: Axes) -> Figure:
    figure = axes.get_figure(root=True)
    if figure is None:
        raise PictureError("the axes given belong to no figure")
    return figure


def one_line(text: str) -> str:
    """Return a title in one line, with ? for what cannot be printed."""
    return "".join(character if character.isprintable() else "?" for character in " ".join(text.split()))


def title_of(result: Result) -> str:
    """Return the case's title, or the file's name, with the status of a result that is not complete."""
    status = "" if result.status == "complete" else f"{result.status} with {result.increments} increments: "
    return status + one_line(str(result.effective_case.get("title") or result.path.name))


def rendered(figure: Figure, file_format: str, dpi: int = Sheet.dpi) -> bytes:
    """Return the picture as the content of a PNG, PDF or SVG file. dpi: dots per inch of pixels."""
    buffer = io.BytesIO()
    with own_style():
        figure.savefig(buffer, format=file_format, dpi=dpi, metadata=METADATA[file_format], facecolor="white")
    return buffer.getvalue()
