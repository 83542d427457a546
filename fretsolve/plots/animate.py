"""Draw fields over the load path, as a GIF or an MP4."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.animation import FuncAnimation

from fretsolve.plots import maps
from fretsolve.plots.canvas import own_style, title_of
from fretsolve.plots.load_history import step_text
from fretsolve.plots.snapshot import Snapshot, chosen_step, view_box
from fretsolve.result import Result

FIELDS = ("pressure", "shear")
"""The panels by default."""

MOST_FRAMES = 60
"""Frames at most, evenly spread over the increments with fields."""

SECONDS = 10.0
SLOWEST, FASTEST = 2, 12
"""Frames per second: as many as make `SECONDS`, within these limits."""

DPI = 100


def animation(result: Result, *, fields: Sequence[str] | None = None) -> FuncAnimation:
    """Draw fields over the increments with fields, in at most 60 frames; ``.save`` or ``.to_jshtml`` shows them.

    fields: names of the case file; by default pressure and shear. All frames have the same colours and limits. Raises
    PictureError.
    """
    chosen_step(result, None)
    steps = result.steps
    if len(steps) > MOST_FRAMES:
        steps = tuple(steps[k] for k in np.linspace(0, len(steps) - 1, MOST_FRAMES).round().astype(int))
    names = maps.chosen_fields([Snapshot(result, step) for step in steps], fields, FIELDS)
    # Find the limits. The fields of one increment are held at a time.
    largest = [0.0] * len(names)
    contact = np.zeros((len(result.x), len(result.y)), bool)
    for snapshot in (Snapshot(result, step) for step in steps):
        contact |= snapshot.contact
        largest = [max(size, snapshot.magnitude(name).max()) for size, name in zip(largest, names, strict=True)]
    scales = [maps.scale_of(result, name, size) for name, size in zip(names, largest, strict=True)]
    last, box = Snapshot(result, steps[-1]), view_box(result, contact)
    with own_style():
        with maps.map_canvas(None, last, len(names), box) as drawn:
            for axes, scale in zip(drawn.axes, scales, strict=False):
                maps.draw_panel(drawn, axes, last, scale, box)
        # Lay the figure out once, so that the panels do not move from frame to frame.
        drawn.figure.draw_without_rendering()
        drawn.figure.set_layout_engine(None)

    def show(step: int) -> tuple[()]:
        """Draw one frame."""
        snapshot = Snapshot(result, step)
        for axes, scale in zip(drawn.axes, scales, strict=False):
            for artist in (*axes.images, *axes.collections):
                artist.remove()
            maps.draw_field(axes, snapshot, scale, box)
        drawn.heading(title_of(result), step_text(result, step))
        return ()

    interval = 1000.0 / min(max(round(len(steps) / SECONDS), SLOWEST), FASTEST)
    return FuncAnimation(
        drawn.figure, show, frames=steps, interval=interval, init_func=lambda: (), cache_frame_data=False
    )


def saved_film(film: FuncAnimation, file_format: str) -> bytes:
    """Return an animation as the content of a gif or mp4 file."""
    with tempfile.TemporaryDirectory() as folder, own_style():
        target = Path(folder) / f"film.{file_format}"
        film.save(target, writer="ffmpeg" if file_format == "mp4" else "pillow", dpi=DPI)
        return target.read_bytes()
