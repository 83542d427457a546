"""Cases whose results are drawn, and what stands on a figure."""

from __future__ import annotations

import json

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretsolve.result import Result


def panels(figure: Figure) -> list[Axes]:
    """The axes with something on them, without colour bars."""
    return [axes for axes in figure.axes if axes.axison]


def legend_texts(axes: Axes) -> list[str]:
    legend = axes.get_legend()
    return [text.get_text() for text in legend.get_texts()] if legend is not None else []


def figure_texts(figure: Figure) -> list[str]:
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def heading(figure: Figure) -> str:
    return figure.get_suptitle()


def image_of(axes: Axes) -> np.ndarray:
    return axes.images[-1].get_array()


def with_path(result: Result, case: dict[str, object], loads: list[float]) -> Result:
    """`result` with a history of one increment a stage, of the loads Qx."""
    count = len(loads)
    result.attributes = {**result.attributes, "effective_case": json.dumps(case)}
    result.history = {name: np.resize(column, count) for name, column in result.history.items()}
    result.history |= {
        "Qx": np.array(loads),
        "delta_x": 1e-5 * np.array(loads),
        "stage": np.arange(1, count + 1),
        "step": np.arange(count),
        "work_total": 1e-3 * np.arange(count),
    }
    return result
