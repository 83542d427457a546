"""Warn of friction with which a run ends, or stops repeating a cycle, earlier than its user may expect."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from fretsolve.case.dimensions import percent
from fretsolve.case.keys.friction_spec import FrictionSpec
from fretsolve.case.keys.unrolled_path import Stage
from fretsolve.errors import dotted
from fretsolve.problem.friction.weakening import growth_on_sphere
from fretsolve.problem.model.materials import Orthotropy
from fretsolve.reference.hertz import HertzContact


def friction_warnings(
    spec: FrictionSpec, stages: Sequence[Stage], hertz: HertzContact | None, compliance: float
) -> Iterator[str]:
    """Yield one sentence per warning; hertz: the largest contact; compliance: the tangential one (1/MPa)."""
    if hertz is not None and hertz.is_circle and spec.weakening != "allow":
        yield from _about_weakening(spec, growth_on_sphere(spec, hertz, compliance))
    if spec.initial is not None or len(spec.cycles or ()) > 1:
        yield from _about_periodic_cycles(stages)
    if spec.expression is not None:
        yield from _about_infinite_friction(spec.expression)


def largest_share(spec: FrictionSpec, Qx: float, Qy: float) -> float:
    """Return what friction carries at most of P in the direction of a force, where no closed form says so; else inf."""
    if spec.pair is not None:
        scaled = Orthotropy.of(spec.pair, spec.angle or 0.0).inverse.times(np.array([Qx, Qy]))
        length = math.hypot(*scaled)
        return math.sqrt(spec.pair[0] * spec.pair[1]) * math.hypot(Qx, Qy) / length if length else math.inf
    if spec.initial is not None and spec.final is not None and spec.exponent is None:
        return max(spec.initial, spec.final)
    return math.inf


def _about_weakening(spec: FrictionSpec, growth: float) -> Iterator[str]:
    if growth < 1.0:
        return
    name, unit, value = ("slip", "mm", spec.slip) if spec.slip else ("energy", "mJ/mm^2", spec.energy)
    yield (
        f"friction.{name}: friction falls {growth:.3g} times as fast with slip as the elastic surfaces hold against it,"
        f" which ends the run; {growth * (value or 0.0):.3g} {unit} or more would not, nor weakening: allow"
    )


def _about_infinite_friction(formula: str) -> Iterator[str]:
    from fretsolve.case.expression import Expression  # few cases have one

    middle = np.zeros(1)
    if np.isinf(Expression(formula)(x=middle, y=middle, r=middle)).any():
        yield (
            "friction.expression: the coefficient is infinite at x = y = 0, and the mean over a cell there depends on"
            " the cell's size; bound it, as in min(..., 1)"
        )


def _about_periodic_cycles(stages: Sequence[Stage]) -> Iterator[str]:
    passes = (stage.cycle for stage in stages if stage.cycle is not None)
    cycle = next((one for one in passes if one.until is not None), None)
    if cycle is not None:
        yield (
            f"{dotted((*cycle.key, 'until'))}: friction changes from cycle to cycle, and one that changes by less"
            f" than {percent(cycle.until or 0.0)} counts as periodic before friction has run in; times runs so many"
        )
