"""List the kinds of pictures, without matplotlib, and make their files."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

from fretsolve.errors import PictureError
from fretsolve.post.plots.sheet import Sheet

if TYPE_CHECKING:  # the command line lists the kinds, and is to load click alone
    from fretsolve.post.stress.influence import Body
    from fretsolve.result import Result

STILL, MOVING = ("png", "pdf", "svg"), ("gif", "mp4")
"""File formats; the first one is the default."""

OPTIONS = {"step": "--step", "steps": "--step", "at": "--at", "fields": "--field", "body": "--body"}
"""Parameters of the functions that draw, with the options of the command line that set them."""


TENSION = "tension"
"""Name of the point of the surface where the tension is largest over a cycle."""


@dataclass(frozen=True)
class Shown:
    """The part of a result that is drawn: increments, a point (mm), fields, a body; without one what is usual.

    at: x and y, with a depth for a point below the surface, or `TENSION`, the place of largest tension.
    """

    steps: tuple[int, ...] = ()
    at: tuple[float, ...] | str | None = None
    fields: tuple[str, ...] = ()
    body: Body | None = None


class PictureKind(NamedTuple):
    """A kind of pictures.

    drawn_by: module of `pictures` and function; a function may not have the name of a module of `plots`, which would
    hide it. caption: what it shows. options: parameters of the function, of `OPTIONS`. beside: ending of a file beside
    the result that it draws. column, surfaces: of the history, and kinds of surfaces, that it draws, where not all
    results have them.
    """

    name: str
    drawn_by: str
    caption: str
    options: tuple[str, ...] = ()
    formats: tuple[str, ...] = STILL
    beside: str = ""
    column: str = ""
    surfaces: tuple[str, ...] = ()

    def applies_to(self, result: Result) -> bool:
        """Return whether a result has what the picture draws."""
        own = result.effective_case.get("surface", [])
        has_surface = any(name in one for one in own for name in self.surfaces)
        return (not self.column or self.column in result.history) and (not self.surfaces or has_surface)

    @property
    def draw(self) -> Callable[..., Any]:
        """The function, which returns a `Figure`, or a `FuncAnimation` for moving pictures."""
        module, _, function = self.drawn_by.partition(":")
        return getattr(import_module(f"fretsolve.post.plots.pictures.{module}"), function)  # type: ignore[no-any-return]

    def content(self, result: Result, file_format: str, shown: Shown, sheet: Sheet) -> bytes:
        """Return the content of a file of the picture. Raises PictureError."""
        from matplotlib.animation import FFMpegWriter

        from fretsolve.post.plots.canvas import rendered
        from fretsolve.post.plots.pictures.maps import saved_film

        if file_format == "mp4" and not FFMpegWriter.isAvailable():
            raise PictureError("mp4 needs ffmpeg, which is not on the path: install it, or write a .gif")
        if "step" in self.options and len(shown.steps) > 1:
            raise PictureError(f"shows one increment, not {len(shown.steps)}: give --step once")
        if self.name == "profiles" and shown.at is not None and len(shown.at) != 2:
            raise PictureError("shows lines on the surface: --at X,Y is needed")
        given = {**vars(shown), "step": shown.steps[0] if shown.steps else None}
        picture = self.draw(result, sheet, **{name: given[name] for name in self.options})
        if file_format in MOVING:
            return saved_film(picture, file_format, film_dpi(sheet.dpi))
        return rendered(picture, file_format, sheet.dpi)


def film_dpi(dpi: int) -> int:
    """Return the dots per inch of a film where pictures that stand still have `dpi`."""
    return dpi // 3


_ALL = (
    PictureKind("loop", "histories:loop", "Force over displacement; shaded: the energy dissipated in a cycle."),
    PictureKind("profiles", "profiles:profiles", "Fields along two lines through the contact.", ("steps", "at")),
    PictureKind("map", "maps:contact_map", "Fields over the contact; arrows show directions.", ("step", "fields")),
    PictureKind("streamlines", "directions:streamlines", "Lines along shear traction and slip.", ("step",)),
    PictureKind("slip-angle", "directions:slip_angle", "Angle from the load to the slip.", ("step",)),
    PictureKind("stick-history", "histories:stick_history", "Stick radius over contact radius, over the load."),
    PictureKind("wear", "profiles:wear", "Worn scar, volume and depth over the cycles.", column="wear_volume"),
    PictureKind("convergence", "histories:convergence", "Iterations and residuals of each increment."),
    PictureKind(
        "stress-map", "stresses:stress_map", "Stresses below the contact and on its surface.", ("step", "body")
    ),
    PictureKind("stress-cycle", "stresses:stress_cycle", "Stresses at a point over a cycle.", ("at", "body")),
    PictureKind(
        "fatigue-map",
        "fatigue_maps:fatigue_map",
        "Where cracks may begin, by `fretsolve fatigue`.",
        ("fields", "body"),
        beside=".fatigue.h5",
    ),
    PictureKind(
        "crack",
        "cracks:crack",
        "Whether a crack goes on, and its life, by `fretsolve crack`.",
        ("body",),
        beside=".crack.h5",
    ),
    PictureKind(
        "surface",
        "surfaces:measured_surface",
        "Measured or rough surface: map, profiles, spectrum.",
        surfaces=("heights", "roughness"),
    ),
    PictureKind("animate", "maps:animation", "Fields over the load path.", ("fields",), MOVING),
)
KINDS = {kind.name: kind for kind in _ALL}
"""The kinds of pictures, by their names on the command line."""
