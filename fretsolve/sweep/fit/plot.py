"""The picture of a fit: the measured loop with the loop of the case, and their difference below."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from fretsolve.case.dimensions import percent, smaller_unit
from fretsolve.post.plots.canvas import canvas, one_line
from fretsolve.sweep.fit.least_squares import Fit
from fretsolve.sweep.fit.model_loop import FORCE

MEASURED: dict[str, Any] = {"color": "0.45", "marker": ".", "linestyle": "", "markersize": 3.0}
"""Options of the measured points."""


def fit_picture(fit: Fit, title: str, detail: str) -> Figure:
    """Draw the measured force without offset and drift over the motion, the loop of the case, and the residual."""
    plan, loop = fit.plan, fit.plan.loop
    motion = plan.models[-1].motion
    unit, factor = smaller_unit(plan.case.dimensions[motion].unit, float(np.abs(loop.motion).max()))
    force = plan.case.dimensions[FORCE].unit
    with canvas(None, 2, (4.5, 2.0), columns=1, share="x", heights=(3.0, 1.4)) as drawn:
        above, below = drawn.axes
        above.plot(factor * loop.motion, loop.force - fit.drift, label="measured", **MEASURED)
        moved, computed = fit.branches.curves(200)
        above.plot(factor * moved, computed, label="fitted", color="black")
        above.set_ylabel(f"{FORCE} ({force})")
        above.legend(loc="upper left")
        below.plot(factor * loop.motion, fit.residual, **MEASURED)
        below.axhline(0.0, linewidth=0.8, color="black")
        below.set(xlabel=f"{motion} ({unit})", ylabel=f"residual ({force})")
        below.set_title(f"residual {percent(fit.rms / loop.range)} of the range")
        drawn.heading(one_line(title), detail)
    return drawn.figure
