"""Cases whose results are drawn, and what stands on a figure."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure


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
