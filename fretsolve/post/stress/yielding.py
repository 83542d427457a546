"""Say where a body cannot bear its stresses elastically: by bounds from the history, or by computed stresses.

The bounds cost nothing. Whatever else acts, the von Mises stress at the surface is at least sqrt(3) times the shear
traction, since 3 J2 >= 3 (sxz^2 + syz^2); far from the contact it is the von Mises stress of the bulk stress. Of the
pressure no such bound exists: a wide, even pressure presses a body from all sides alike. But a pressure that falls off
beside its largest value shears the body below that place, about as much as Hertz's pressure does.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fretsolve.case.history import BULK
from fretsolve.post.stress.invariants import von_mises
from fretsolve.reference.yielding import YieldOnset, yield_onset
from fretsolve.result import Result

if TYPE_CHECKING:
    from fretsolve.post.stress.peaks import Key, Peak
    from fretsolve.post.stress.request import StressRequest

ELASTIC = "the solution is elastic"

MORE = 1.05
"""A largest pressure over the largest pressure of the closed form above which the closed form did not foresee it."""


def yield_stresses(result: Result) -> dict[int, float]:
    """Return the yield stress (MPa) of each elastic body that gives one."""
    bodies = enumerate(result.effective_case.get("bodies", ()), start=1)
    return {
        number: body["yield_stress"] for number, body in bodies if isinstance(body, dict) and "yield_stress" in body
    }


def yield_lines(result: Result, foreseen: Mapping[int, float] | None = None) -> dict[int, str]:
    """Return for each body that yields by the history alone a line that says so; certain bounds come first.

    foreseen: largest pressures (MPa) of which it has been told that the body yields below them.
    """
    found = {}
    for body, limit in yield_stresses(result).items() if result.increments else ():
        certain = max(_of_shear(result, limit), _of_bulk(result, body, limit))[1]
        about = _of_pressure(result, body, limit, (foreseen or {}).get(body, 0.0))
        if certain:
            found[body] = f"body {body} yields {certain}{about and '; and '}{about}; {ELASTIC}"
        elif about:
            found[body] = f"body {body} yields {about}; {ELASTIC}"
    return found


def _of_shear(result: Result, limit: float) -> tuple[float, str]:
    """Return the least von Mises stress under the largest shear traction over the yield stress, words if above 1."""
    step = int(result.history["max_shear"].argmax())
    least = math.sqrt(3.0) * float(result.history["max_shear"][step])
    if least <= limit:
        return least / limit, ""
    return least / limit, (
        f"at the surface: the von Mises stress is at least {least:.4g} MPa{_place(result, 'shear', step)} in increment"
        f" {step}, sqrt(3) times the shear traction there, {_times(least / limit)} the yield stress {limit:g} MPa"
    )


def _of_bulk(result: Result, body: int, limit: float) -> tuple[float, str]:
    """Return the von Mises stress of the bulk stress over the yield stress, words if above 1."""
    xx, yy, xy = (np.asarray(result.history.get(name, 0.0), np.float64) for name in BULK[body])
    if _is_line(result):
        yy = result.effective_case["bodies"][body - 1]["poisson_ratio"] * xx
    stress = np.broadcast_arrays(xx, yy, 0.0, xy, 0.0, 0.0)
    mises = np.atleast_1d(von_mises(np.stack(stress)))
    step = int(mises.argmax())
    ratio = float(mises[step]) / limit
    if ratio <= 1.0:
        return ratio, ""
    return ratio, (
        f"by its bulk stress alone: the von Mises stress is {mises[step]:.4g} MPa in increment {step}, {_times(ratio)}"
        f" the yield stress {limit:g} MPa"
    )


def _of_pressure(result: Result, body: int, limit: float, foreseen: float) -> str:
    """Return words on a largest pressure below which the body yields, were it Hertz's; empty if it does not."""
    step = int(result.history["max_pressure"].argmax())
    onset, largest = _onset(result, body, step), float(result.history["max_pressure"][step])
    bearable = onset.pressure * limit
    if largest <= max(bearable, MORE * foreseen):
        return ""
    where, depth = "at", ""
    if onset.depth > 0.0:
        where, depth = "below", f", at a depth of {onset.depth:.3g} times half the width of the contact there"
    return (
        f"{where} the surface, if pressure falls off about as Hertz's does: {largest:.4g} MPa"
        f"{_place(result, 'pressure', step)} in increment {step} is {_times(largest / bearable)} the {bearable:.4g} MPa"
        f" ({onset.pressure:.4g} times the yield stress {limit:g} MPa) from where Hertz's pressure yields a body{depth}"
    )


def _onset(result: Result, body: int, step: int) -> YieldOnset:
    """Return the onset of yield below a contact of the widths of an increment; spots count as round."""
    history = result.history
    ratio = 0.0
    if not _is_line(result):
        widths = sorted(float(history[f"contact_half_width_{axis}"][step]) for axis in "xy")
        single = "spots" not in history or int(history["spots"][step]) <= 1
        ratio = widths[0] / widths[1] if single and widths[1] > 0.0 else 1.0
    return yield_onset(result.effective_case["bodies"][body - 1]["poisson_ratio"], ratio)


def _is_line(result: Result) -> bool:
    return bool(result.effective_case.get("plane") == "strain")


def _place(result: Result, name: str, step: int) -> str:
    """Return where a field is largest in an increment, empty where it is not stored."""
    if step not in result.steps or not {name, f"{name}_x"} & set(result.fields):
        return ""
    field = result.field(name, step)
    size = np.hypot(*field) if name == "shear" else field
    i, j = np.unravel_index(int(size.argmax()), size.shape)
    return at_place(float(result.x[i]), None if _is_line(result) else float(result.y[j]))


def at_place(x: float, y: float | None) -> str:
    """Return a place (mm) in words, of a line without y."""
    return f" at x = {x:.4g} mm" if y is None else f" at x = {x:.4g}, y = {y:.4g} mm"


def _times(ratio: float) -> str:
    """Return a ratio above 1 in words, never as 1."""
    return f"{max(ratio, 1.0):.3g} times" if ratio >= 1.005 else f"{ratio:.6g} times"


def computed_lines(result: Result, request: StressRequest, peaks: Mapping[Key, Sequence[Peak]]) -> dict[int, str]:
    """Return for each body whose computed von Mises stress exceeds its yield stress, or may, a line that says so."""
    return dict(_computed_lines(result, request, peaks))


def _computed_lines(
    result: Result, request: StressRequest, peaks: Mapping[Key, Sequence[Peak]]
) -> Iterator[tuple[int, str]]:
    limits: dict[int, Any] = yield_stresses(result)
    for body in request.bodies:
        if body not in limits:
            continue
        found, limit = peaks[body, "mises"], limits[body]
        index = max(range(len(found)), key=lambda one: found[one].value)
        peak = found[index]
        place = at_place(peak.x, None if _is_line(result) else peak.y)
        place += f", depth {peak.depth:.4g} mm, increment {request.steps[index]}"
        if peak.unbounded:
            yield body, f"body {body} yields at a sharp edge or tip,{place}, where stress has no bound; {ELASTIC}"
        elif peak.value + peak.error > limit:
            error = f"{peak.error:.2g}" if peak.error < 100.0 else f"{peak.error:.0f}"
            verb = "yields" if peak.value - peak.error > limit else "may yield"
            yield (
                body,
                (
                    f"body {body} {verb}: the von Mises stress is {peak.value:.4g} ± {error} MPa{place},"
                    f" {peak.value / limit:.3g} times the yield stress {limit:g} MPa; {ELASTIC}"
                ),
            )
