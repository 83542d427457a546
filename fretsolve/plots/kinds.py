"""The kinds of pictures as the command line asks for them, each with the options that it heeds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fretsolve.errors import PictureError
from fretsolve.plots import KINDS
from fretsolve.plots.angles import slip_angle
from fretsolve.plots.animation import animation_content
from fretsolve.plots.canvas import rendered
from fretsolve.plots.loops import loop
from fretsolve.plots.maps import contact_map
from fretsolve.plots.profiles import profiles
from fretsolve.plots.residuals import convergence
from fretsolve.plots.stick import stick_history
from fretsolve.plots.stream import streamlines

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from fretsolve.result import Result

STILL = ("png", "pdf", "svg")
MOVING = ("gif", "mp4")
"""File formats; the first one is the default."""


@dataclass(frozen=True)
class Selection:
    """What of the result to draw; empty or None for the kind's default. at: in mm."""

    steps: tuple[int, ...] = ()
    at: tuple[float, float] | None = None
    fields: tuple[str, ...] = ()

    @property
    def step(self) -> int | None:
        """The one increment that is asked for. Raises PictureError where there are several."""
        if len(self.steps) > 1:
            raise PictureError(f"shows one increment, not {len(self.steps)}: give --step once")
        return self.steps[0] if self.steps else None


Draw = Callable[["Result", Selection, str], bytes]
"""The content of a file of a picture, in a format."""


@dataclass(frozen=True)
class Kind:
    """A kind of pictures. caption: what is seen; options: those of the command line that it heeds."""

    name: str
    caption: str
    draw: Draw
    formats: tuple[str, ...] = STILL
    options: tuple[str, ...] = ()


def _still(draw: Callable[[Result, Selection], Figure]) -> Draw:
    return lambda result, selection, file_format: rendered(draw(result, selection), file_format)


_ALL = (
    Kind(
        "loop",
        "Force over displacement; the shaded area is dissipated in a cycle.",
        _still(lambda result, _: loop(result)),
    ),
    Kind(
        "profiles",
        "Pressure, shear and slip along two lines through the contact.",
        _still(lambda result, selection: profiles(result, steps=selection.steps, at=selection.at)),
        options=("--step", "--at"),
    ),
    Kind(
        "map",
        "Fields over the contact; arrows show directions.",
        _still(lambda result, selection: contact_map(result, step=selection.step, fields=selection.fields)),
        options=("--step", "--field"),
    ),
    Kind(
        "streamlines",
        "Lines along the shear and along the slip.",
        _still(lambda result, selection: streamlines(result, step=selection.step)),
        options=("--step",),
    ),
    Kind(
        "slip-angle",
        "Angle from the direction of the load to that of the slip.",
        _still(lambda result, selection: slip_angle(result, step=selection.step)),
        options=("--step",),
    ),
    Kind(
        "stick-history",
        "Stick radius over contact radius, over the load.",
        _still(lambda result, _: stick_history(result)),
    ),
    Kind(
        "convergence",
        "Iterations and residuals of each increment.",
        _still(lambda result, _: convergence(result)),
    ),
    Kind(
        "animate",
        "Fields over the load path.",
        lambda result, selection, file_format: animation_content(result, file_format, selection.fields),
        formats=MOVING,
        options=("--field",),
    ),
)


def kind_of(name: str) -> Kind:
    """The kind called `name`, one of `KINDS`."""
    return _ALL[KINDS.index(name)]
