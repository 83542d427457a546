"""List the kinds of pictures for the command line, and put all of a result on one HTML page."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from html import escape

from matplotlib.animation import FuncAnimation
from matplotlib.figure import Figure

from fretsolve.errors import PictureError
from fretsolve.export.text_report import print_report
from fretsolve.plots import KINDS
from fretsolve.plots.animate import animation, require_writer, saved_film
from fretsolve.plots.canvas import rendered, title
from fretsolve.plots.directions import slip_angle, streamlines
from fretsolve.plots.histories import convergence, loop, stick_history
from fretsolve.plots.line_profiles import profiles
from fretsolve.plots.maps import contact_map
from fretsolve.result import Result

STILL = ("png", "pdf", "svg")
MOVING = ("gif", "mp4")
"""File formats; the first one is the default."""

OPTIONS = {"step": "--step", "steps": "--step", "at": "--at", "fields": "--field"}
"""Option of the command line by the parameter of a function."""

STYLE = (
    "body{font-family:sans-serif;max-width:70rem;margin:2rem auto;padding:0 1rem;color:#222}"
    "img{max-width:100%;height:auto}figure{margin:2rem 0}figcaption{color:#555}"
    "pre{overflow-x:auto;background:#f6f6f6;padding:1rem;font-size:.8rem;line-height:1.25}"
)


@dataclass(frozen=True)
class Selection:
    """What to draw of a result. at: a point in mm. Empty or None: the default of the kind."""

    steps: tuple[int, ...] = ()
    at: tuple[float, float] | None = None
    fields: tuple[str, ...] = ()

    @property
    def step(self) -> int | None:
        """The increment of a picture that shows one. Raises PictureError for several."""
        if len(self.steps) > 1:
            raise PictureError(f"shows one increment, not {len(self.steps)}: give --step once")
        return self.steps[0] if self.steps else None


@dataclass(frozen=True)
class PictureKind:
    """A kind of pictures. caption: what it shows; parameters: those of `draw` that the command line sets."""

    name: str
    caption: str
    draw: Callable[..., Figure | FuncAnimation]
    parameters: tuple[str, ...] = ()
    formats: tuple[str, ...] = STILL

    @property
    def options(self) -> list[str]:
        """Options of the command line that have an effect."""
        return [OPTIONS[name] for name in self.parameters]

    def content(self, result: Result, selection: Selection, file_format: str) -> bytes:
        """Return the content of a file of the picture. Raises PictureError."""
        require_writer(file_format)
        picture = self.draw(result, **{name: getattr(selection, name) for name in self.parameters})
        return rendered(picture, file_format) if isinstance(picture, Figure) else saved_film(picture, file_format)


@dataclass(frozen=True)
class PageEntry:
    """A kind on the page: its picture in `file_format`, or the reason why it is left out."""

    kind: PictureKind
    file_format: str = ""
    content: bytes = b""
    reason: str = ""


_ALL = (
    PictureKind("loop", "Force over displacement; the shaded area is the energy dissipated in a cycle.", loop),
    PictureKind(
        "profiles", "Pressure, shear traction and slip along two lines through the contact.", profiles, ("steps", "at")
    ),
    PictureKind("map", "Fields over the contact; arrows show directions.", contact_map, ("step", "fields")),
    PictureKind("streamlines", "Lines along the shear traction and along the slip.", streamlines, ("step",)),
    PictureKind("slip-angle", "Angle from the direction of the load to that of the slip.", slip_angle, ("step",)),
    PictureKind("stick-history", "Stick radius over contact radius, over the load.", stick_history),
    PictureKind("convergence", "Iterations and residuals of each increment.", convergence),
    PictureKind("animate", "Fields over the load path.", animation, ("fields",), MOVING),
)


def kind_of(name: str) -> PictureKind:
    """Return the kind called `name`, one of `KINDS`."""
    return _ALL[KINDS.index(name)]


def html_page(result: Result, entries: Sequence[PageEntry]) -> str:
    """Return a page that needs no other file: table, pictures, what is left out and why, and the case."""
    table = io.StringIO()
    print_report(result, file=table)
    name = escape(title(result))
    left_out = [f"<li>{escape(entry.kind.name)}: {escape(entry.reason)}</li>" for entry in entries if entry.reason]
    parts = [
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<title>{name}</title>',
        f"<style>{STYLE}</style>\n</head>\n<body>\n<h1>{name}</h1>",
        f"<pre>{escape(table.getvalue())}</pre>",
        *(_figure(entry) for entry in entries if not entry.reason),
        *(["<h2>Left out</h2>\n<ul>", *left_out, "</ul>"] if left_out else []),
        f"<h2>Case</h2>\n<pre>{escape(result.case_yaml)}</pre>\n</body>\n</html>\n",
    ]
    return "\n".join(parts)


def _figure(entry: PageEntry) -> str:
    name, caption = escape(entry.kind.name), escape(entry.kind.caption)
    data = base64.b64encode(entry.content).decode()
    image = f'<img src="data:image/{entry.file_format};base64,{data}" alt="{name}: {caption}">'
    return f'<figure id="{name}">\n<h2>{name}</h2>\n{image}\n<figcaption>{caption}</figcaption>\n</figure>'
