"""Draw a crack from the surface: its stress intensity beside the threshold, and the lives that follow."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator

from fretsolve.post.crack.crack_file import BodyCrack, crack_bodies
from fretsolve.post.names import crack_path
from fretsolve.post.plots.canvas import BELOW_LABEL, PANEL_WIDTH, Target, canvas, title_of
from fretsolve.post.plots.labels import UPWARDS, marks
from fretsolve.post.plots.pictures.beside import chosen_bodies, file_beside
from fretsolve.post.stress.influence import Body
from fretsolve.result import Result
from fretsolve.system.arrays import DoubleArray

LENGTH = "length of the crack $b$ (mm)"

LIVES = {"initiation_life": "initiation", "propagation_life": "propagation", "total_life": "total"}
"""Columns of a life, in words."""


def crack(result: Result, ax: Target = None, *, body: Body | None = None) -> Figure:
    """Draw the cracks that `fretsolve crack` wrote beside the result: stress intensity, and the lives that are known.

    body: by default all in the file. Raises PictureError, FileError if the file is damaged.
    """
    with file_beside(result, crack_path(result.path), "crack") as computed:
        bodies = chosen_bodies(crack_bodies(computed), body, "crack")
    return crack_figure(bodies, title_of(result), ax)


def crack_figure(bodies: Mapping[int, BodyCrack], title: str, ax: Target = None) -> Figure:
    """Draw a row for each body: the range of stress intensity over the length beside the threshold, and the lives."""
    with_lives = any(name in one.columns for one in bodies.values() for name in LIVES)
    columns = 2 if with_lives else 1
    with canvas(ax, columns * len(bodies), (PANEL_WIDTH, 3.0), columns=columns) as drawn:
        panels = iter(drawn.axes)
        for number, one in reversed(list(bodies.items())):
            where = f"body {number}, " if len(bodies) > 1 else ""
            for draw, what in ((_draw_range, "range of stress intensity"), (_draw_lives, "life"))[:columns]:
                if (axes := next(panels, None)) is None:
                    break
                draw(axes, one)
                axes.set(xlabel=LENGTH, title=where + what)
        drawn.heading(title, "; ".join(_described(number, one) for number, one in reversed(list(bodies.items()))))
    return drawn.figure


def _described(number: int, crack: BodyCrack) -> str:
    """Return the place of a crack, its verdict and the length at which its life ends, in words."""
    row = f", $y$ = {crack.y:.4g} mm" if crack.y else ""
    parts = [f"body {number}, crack at $x$ = {crack.x:.4g} mm{row}"]
    if crack.verdict == "arrests":
        error = crack.values.get("arrest_length_error", np.nan)
        bar = f" ± {error:.1g}" if np.isfinite(error) else ""
        doubt = ", but may go through" if np.isinf(error) else ""
        parts.append(f"arrests at $b$ = {crack.values['arrest_length']:.3g}{bar} mm{doubt}")
    elif crack.verdict is not None:
        parts.append(crack.verdict)
    if "final_length" in crack.values and np.isfinite(crack.values.get("life", 0.0)):
        parts.append(f"life ends at $b_f$ = {crack.values['final_length']:.3g} mm")
    return ", ".join(parts)


def _last(crack: BodyCrack) -> float:
    """Return the length up to which a crack is drawn (mm): where its life ends, if that is known."""
    return min(float(crack.lengths[-1]), crack.values.get("final_length", np.inf))


def _draw_range(axes: Axes, crack: BodyCrack) -> None:
    """Draw the range of stress intensity with its error band and the threshold, both axes logarithmic."""
    length, value = crack.lengths, crack.columns["range"]
    threshold = crack.columns.get("threshold")
    open_at = (value > 0.0) & (length <= _last(crack))
    there = np.concatenate([value[open_at], () if threshold is None else threshold[length <= _last(crack)]])
    axes.set(xscale="log", yscale="log", xlim=(length[0], _last(crack)))
    if len(there):  # without the steep end of a range that closes
        axes.set_ylim(0.7 * np.quantile(there, 0.03), 1.4 * there.max())
    axes.set_ylabel(r"$\Delta K$ (MPa m$^{1/2}$)")
    axes.yaxis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter("{x:g}")
    axes.plot(length, np.where(value > 0.0, value, np.nan), color="#3b528b", label=r"$\Delta K$")
    if (error := crack.columns.get("range_error")) is not None and np.isfinite(error).any():
        low, high = np.maximum(value - error, axes.get_ylim()[0]), np.maximum(value + error, axes.get_ylim()[0])
        known = np.isfinite(error) & (value > 0.0)
        axes.fill_between(length, low, high, where=known, color="#3b528b", alpha=0.25, linewidth=0.0, label="its error")
    if threshold is not None:
        axes.plot(length, threshold, color="#d95f02", linestyle="--", label="threshold")
    closed = value <= 0.0
    if closed.any():
        look: dict[str, Any] = {"facecolor": "0.9", "linewidth": 0.0, "zorder": 0.5, "label": "closed, no range"}
        axes.fill_between(length, 0.0, 1.0, where=closed, step="mid", transform=axes.get_xaxis_transform(), **look)
    arrest = crack.values.get("arrest_length", np.nan)
    if length[0] <= arrest <= length[-1]:
        axes.axvline(arrest, color="black", linestyle=":", label=f"arrests at {arrest:.3g} mm")
    axes.legend(ncols=2, **BELOW_LABEL)


def _draw_lives(axes: Axes, crack: BodyCrack) -> None:
    """Draw each life over the length where a crack begins; a line that leaves at the top goes on to a run-out."""
    known = {words: crack.columns[name] for name, words in LIVES.items() if name in crack.columns}
    axes.set(xscale="log", yscale="log", xlim=(crack.lengths[0], _last(crack)), ylabel="life (cycles)")
    if not known:
        axes.text(0.5, 0.5, "no life is known", ha="center", va="center", transform=axes.transAxes)
        return
    shown = crack.lengths <= _last(crack)
    finite = [life[np.isfinite(life) & (life > 0.0) & shown] for life in known.values()]
    if finite := [life for life in finite if len(life)]:  # without the steep end of a propagation
        axes.set_ylim(0.5 * min(np.quantile(life, 0.1) for life in finite), 5.0 * max(life.max() for life in finite))
    endless = False
    for mark, (words, life) in zip(marks(len(known)), known.items(), strict=True):
        look = {"color": mark.color, "linestyle": mark.linestyle}
        label = f"{words}: run-out at all lengths" if np.isposinf(life[~np.isnan(life)]).all() else words
        axes.plot([], [], label=label, **look)
        for length, run, leaves in _finite_runs(crack.lengths, life):
            axes.plot(length, run, **look)
            endless |= bool(leaves)
            for place in (one for one in leaves if crack.lengths[0] < length[one] < _last(crack)):
                axes.plot([length[place]] * 2, [run[place], axes.get_ylim()[1]], **look)
                axes.plot(length[place], 0.95, transform=axes.get_xaxis_transform(), color=mark.color, **UPWARDS)
    handles = axes.get_legend_handles_labels()[0]
    if endless:
        handles.append(Line2D([], [], color="0.3", label="run-out", **UPWARDS))
    axes.legend(handles=[*handles, *_draw_places(axes, crack, known)], ncols=2, **BELOW_LABEL)


def _finite_runs(length: DoubleArray, life: DoubleArray) -> Iterator[tuple[DoubleArray, DoubleArray, list[int]]]:
    """Yield the pieces of a curve that are finite, and at which of their ends (0, -1) the life becomes endless."""
    finite, endless = np.isfinite(life), np.isposinf(life)
    ends = np.flatnonzero(np.diff(finite, prepend=False, append=False))
    for first, stop in zip(ends[::2].tolist(), ends[1::2].tolist(), strict=True):
        leaves = {0: endless[max(first - 1, 0)], -1: endless[min(stop, len(life) - 1)]}
        yield length[first:stop], life[first:stop], [place for place, is_endless in leaves.items() if is_endless]


def _draw_places(axes: Axes, crack: BodyCrack, known: Mapping[str, DoubleArray]) -> list[Any]:
    """Mark the shortest total life and where the curves of initiation and propagation cross; return their key."""
    handles: list[Any] = []
    life, begins = crack.values.get("life", np.nan), crack.values.get("initiation_length", np.nan)
    if np.isfinite(life) and np.isfinite(begins):
        ends = (crack.values.get(f"life_{end}", np.nan) for end in ("low", "high"))
        bar = [[abs(np.clip(end, *axes.get_ylim()) - life)] if not np.isnan(end) else [0.0] for end in ends]
        text = f"shortest: {life:.3g} at {begins:.3g} mm"
        look: dict[str, Any] = {"color": "black", "marker": "o", "linestyle": "", "capsize": 2.0, "clip_on": False}
        handles.append(axes.errorbar([begins], [life], bar, label=text, **look))
    crossing = crack.values.get("crossing_length", np.nan)
    if np.isfinite(crossing) and "initiation" in known:
        height = np.exp(np.interp(np.log(crossing), np.log(crack.lengths), np.log(known["initiation"])))
        handles += axes.plot(
            crossing,
            height,
            color="black",
            marker="x",
            markersize=6.0,
            linestyle="",
            label=f"equal parts at {crossing:.3g} mm",
        )
    return handles
