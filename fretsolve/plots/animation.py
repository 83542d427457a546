"""Fields over the load path, as a GIF or an MP4."""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, FuncAnimation, PillowWriter
from matplotlib.figure import Figure

from fretsolve.errors import PictureError
from fretsolve.plots.canvas import Canvas, canvas, own_style
from fretsolve.plots.load_history import step_text
from fretsolve.plots.maps import (
    Scale,
    arrangement,
    checked_fields,
    draw_field,
    draw_panel,
    finite_magnitude,
    hide_rest,
    outline_key,
    panel_size,
    present_fields,
    scale_of,
)
from fretsolve.plots.snapshot import Snapshot, Window, chosen_step, window
from fretsolve.system.arrays import BoolArray

if TYPE_CHECKING:
    from fretsolve.result import Result

FIELDS = ("pressure", "shear")
"""The panels where none are asked for."""

MOST_FRAMES = 60
"""Of more increments with fields, this many are shown, evenly spread."""

SECONDS = 10.0
SLOWEST, FASTEST = 2, 12
"""Frames per second: as many as make `SECONDS`, within these limits."""

DPI = 100


def animation(result: Result, *, fields: Sequence[str] | None = None) -> FuncAnimation:
    """Fields over the increments with fields, at most 60 of them; ``.save`` or ``.to_jshtml`` shows it.

    fields: by their names in the case file; by default pressure and shear. Raises PictureError.
    """
    return _film(result, fields).animation()


def animation_content(result: Result, file_format: str, fields: Sequence[str] | None = None) -> bytes:
    """The animation as the content of a gif or mp4 file. Raises PictureError, also where mp4 needs ffmpeg."""
    if file_format == "mp4" and not FFMpegWriter.isAvailable():
        raise PictureError("mp4 needs ffmpeg, which is not on the path: install it, or write a .gif")
    film = _film(result, fields)
    writer: AbstractMovieWriter
    writer = FFMpegWriter(fps=film.rate) if file_format == "mp4" else PillowWriter(fps=film.rate)
    with tempfile.TemporaryDirectory() as folder, own_style(), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing", UserWarning)
        target = Path(folder) / f"film.{file_format}"
        film.animation().save(target, writer=writer, dpi=DPI)
        return target.read_bytes()


@dataclass(frozen=True)
class _Film:
    """Frames at `steps`, drawn on `drawn` one after the other in the same colours and limits."""

    result: Result
    drawn: Canvas
    steps: tuple[int, ...]
    scales: tuple[Scale, ...]
    seen: Window

    @property
    def rate(self) -> int:
        """Frames per second."""
        return min(max(round(len(self.steps) / SECONDS), SLOWEST), FASTEST)

    def animation(self) -> FuncAnimation:
        return FuncAnimation(
            self.drawn.figure,
            self.show,
            frames=self.steps,
            interval=1000.0 / self.rate,
            init_func=lambda: (),
            cache_frame_data=False,
        )

    def show(self, step: int) -> tuple[()]:
        """Draw one frame."""
        snapshot = Snapshot(self.result, step)
        for axes, scale in zip(self.drawn.axes, self.scales, strict=False):
            for artist in (*axes.images, *axes.collections):
                artist.remove()
            draw_field(axes, snapshot, scale, self.seen)
        self.drawn.heading(self.result, step_text(self.result, step))
        return ()


def _film(result: Result, fields: Sequence[str] | None) -> _Film:
    chosen_step(result, None)
    steps = result.steps
    if len(steps) > MOST_FRAMES:
        steps = tuple(steps[k] for k in np.linspace(0, len(steps) - 1, MOST_FRAMES).round().astype(int))
    last = Snapshot(result, steps[-1])
    names = checked_fields(result, fields) if fields else present_fields([Snapshot(result, s) for s in steps], FIELDS)
    largest, contact = _extent(result, steps, names)
    seen = window(result, contact)
    scales = tuple(scale_of(result, name, size) for name, size in zip(names, largest, strict=True))
    columns, rows = arrangement(len(names), seen)
    with canvas(None, rows, columns, panel_size(seen)) as drawn:
        for axes, scale in zip(drawn.axes, scales, strict=False):
            draw_panel(drawn, axes, last, scale, seen)
        drawn.heading(result, step_text(result, last.step))
        hide_rest(drawn, len(names))
        drawn.legend(outline_key(last), columns=2)
        _settle(drawn.figure)
    return _Film(result, drawn, steps, scales, seen)


def _extent(result: Result, steps: Sequence[int], names: Sequence[str]) -> tuple[list[float], BoolArray]:
    """The largest value of each field over all frames, and the cells that are ever in contact."""
    largest = [0.0] * len(names)
    contact = np.zeros((len(result.x), len(result.y)), bool)
    for step in steps:
        snapshot = Snapshot(result, step)
        contact |= snapshot.contact
        for k, name in enumerate(names):
            largest[k] = max(largest[k], float(finite_magnitude(snapshot, name).max()))
    return largest, contact


def _settle(figure: Figure) -> None:
    """Lay the figure out once, so that the panels do not move from frame to frame."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing", UserWarning)
        figure.draw_without_rendering()
    figure.set_layout_engine(None)
