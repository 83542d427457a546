"""Warn before a run of Hertz contacts in which a body yields, below the surface or by friction."""

from __future__ import annotations

import math
from collections.abc import Iterator

from fretsolve.case.dimensions import in_small_unit
from fretsolve.case.keys.unrolled_path import stage_friction
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.reference.hertz import HertzLine, LineContact
from fretsolve.reference.yielding import yield_onset


def about_yield(setup: ProblemSetup) -> Iterator[str]:
    """Warn of a Hertz contact in which a body yields below the surface, or may yield at the surface by friction."""
    found = _hertz_pressure(setup)
    if found is None:
        return
    pressure, width, ratio = found
    shear, about = _largest_shear(setup, pressure), "about " if 0.0 < ratio < 1.0 else ""
    for number, body in enumerate(setup.case.bodies):
        if body == "rigid" or (limit := body.yield_stress) is None:
            continue
        onset, texts = yield_onset(body.poisson_ratio, ratio), []
        if pressure > onset.pressure * limit:
            depth = in_small_unit(onset.depth * width, 3)
            where = f"below the surface, at a depth of {depth}" if onset.depth > 0.0 else "at the surface"
            texts.append(
                f"p0 = {pressure:.4g} MPa is above {about}{onset.pressure:.4g} times the yield stress,"
                f" {onset.pressure * limit:.4g} MPa, from where body {number + 1} yields {where}"
            )
        if math.sqrt(3.0) * shear > limit:
            texts.append(
                f"friction carries up to {shear:.4g} MPa of shear, and body {number + 1} bears"
                f" {limit / math.sqrt(3.0):.4g} MPa, the yield stress over sqrt(3): it may yield at the surface"
            )
        if texts:
            yield f"bodies.{number}.yield_stress: {'; '.join(texts)}; the solution is elastic"


def foreseen_yield(setup: ProblemSetup) -> dict[int, float]:
    """Return Hertz's largest pressure (MPa) for each body (1, 2) that yields below, as `case_warnings` tells."""
    if (found := _hertz_pressure(setup)) is None:
        return {}
    pressure, _, ratio = found
    return {
        number: pressure
        for number, body in enumerate(setup.case.bodies, start=1)
        if body != "rigid" and body.yield_stress is not None
        if pressure > yield_onset(body.poisson_ratio, ratio).pressure * body.yield_stress
    }


def _hertz_pressure(setup: ProblemSetup) -> tuple[float, float, float] | None:
    """Return p0 (MPa) of Hertz's largest contact, its shorter semi-axis (mm), and this over the longer one."""
    if all(body == "rigid" or body.yield_stress is None for body in setup.case.bodies):
        return None
    if (hertz := setup.closed_forms.largest) is not None:
        return hertz.max_pressure, min(hertz.semi_axes), min(hertz.semi_axes) / max(hertz.semi_axes)
    line = line_contact(setup)
    return (line.max_pressure, line.half_width, 0.0) if isinstance(line, HertzLine) else None


def _largest_shear(setup: ProblemSetup, pressure: float) -> float:
    """Return the most shear (MPa) that friction of known coefficients carries under a pressure; 0 without shear."""
    friction = setup.case.friction
    if not setup.model.has_shear or friction.exponent is not None:
        return 0.0
    known = (friction.coefficient, *(friction.pair or ()), friction.initial, friction.final)
    known += (*stage_friction(setup.case.load_path), *(value for _, value in friction.cycles or ()))
    coefficients = [one for one in known if isinstance(one, float)]
    return min(pressure * max(coefficients, default=0.0), friction.shear_limit or math.inf)


def line_contact(setup: ProblemSetup) -> LineContact | None:
    """Return the widest contact of a line, or Hertz's contact of a straight cylinder on an area; None without one."""
    return setup.closed_forms.widest or cylinder_contact(setup)


def cylinder_contact(setup: ProblemSetup) -> HertzLine | None:
    """Return Hertz's line contact of a straight cylinder on an area; one without ends ends with the grid."""
    surface, grid = setup.case.surface[0], setup.grid
    if setup.model.line:
        return None
    endless = None
    if surface.kind == "cylinder" and surface.length is None and setup.case.grid.size is not None:
        along = (abs(math.cos(surface.axis)), abs(math.sin(surface.axis)))
        endless = min(side / part for side, part in zip(grid.size, along, strict=True) if part > 1e-9)
    return setup.closed_forms.cylinder(endless)
