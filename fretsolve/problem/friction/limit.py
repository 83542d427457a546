"""The friction limit of each cell as a function of its pressure, the law that fixes it for each increment, and slip.

Friction may change with slip: does slip run away, and over how many cycles does friction stay nearly constant? In an
increment friction is fixed, so there is always one solution. Over many small increments the slip of a contact that
slides as a whole grows by itself once the largest eigenvalue of A diag(w) reaches 1. A is the tangential compliance of
the cells in contact and w the fall of the friction limit per slip. Beyond, the result depends on the increments. On a
rig of compliance C, moved by its actuator, a contact that slides also moves by C times the force it loses: A + C N N^T
dA takes the place of A, with the motions N of the whole contact. A stick zone would hold it.
Warnings tell of friction with which a run ends, or stops repeating a cycle, earlier than one may expect.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from fretsolve.case.dimensions import percent
from fretsolve.case.expression import Expression
from fretsolve.case.keys.friction_spec import FrictionSpec
from fretsolve.case.keys.unrolled_path import Stage
from fretsolve.case.models import Case
from fretsolve.errors import WeakeningError, dotted
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.model.materials import Compliances, Orthotropy
from fretsolve.reference.hertz import HertzContact
from fretsolve.result.state import Fields
from fretsolve.system.arrays import TINY, BoolArray, DoubleArray, FloatArray

MOST_GROWTH = 10.0
"""Cap on mu(p)/mu, which would diverge as p goes to 0."""


@dataclass(frozen=True)
class FrictionLimit:
    """The friction limit b = mu p, or b = min(mu p, shear_limit) with mu growing like p^(exponent - 1).

    coefficient: mu, or mu at the `reference_pressure` (MPa), a number or (nx, ny); shear_limit: in MPa; varied: whether
    it may differ from cell to cell, or from increment to increment.
    """

    coefficient: float | FloatArray
    shear_limit: float = math.inf
    exponent: float = 1.0
    reference_pressure: float = 1.0
    varied: bool = False

    def limit(self, pressure: FloatArray, out: FloatArray | None = None) -> FloatArray:
        """Return the friction limit (MPa) under `pressure` >= 0 (MPa), an array of the same shape."""
        limit = np.multiply(pressure, self.coefficient, out=out)
        if self.exponent != 1.0:
            limit *= self._growth(pressure)[0]
        if self.shear_limit < math.inf:
            np.minimum(limit, self.shear_limit, out=limit)
        return limit

    def slope(self, pressure: FloatArray) -> FloatArray | float:
        """Return the derivative of the friction limit by the pressure, of its shape, or one number for all."""
        slope: FloatArray | float = self.coefficient
        if self.exponent != 1.0:
            growth, limited = self._growth(pressure)
            slope = slope * growth * np.where(limited, 1.0, self.exponent)
        if self.shear_limit < math.inf:
            slope = np.where(self.limit(pressure) < self.shear_limit, slope, 0.0)
        return slope

    def coefficient_at(self, pressure: FloatArray) -> FloatArray | float:
        """Return mu under `pressure` (MPa), without the shear limit; one number where all cells have it."""
        return self.coefficient if self.exponent == 1.0 else self.coefficient * self._growth(pressure)[0]

    def part(self, cells: Any) -> FrictionLimit:
        """Return the friction limit of some cells; cells: an index of fields (nx, ny)."""
        if isinstance(self.coefficient, float):
            return self
        return replace(self, coefficient=self.coefficient[cells])

    def _growth(self, pressure: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return the factor on the coefficient by the pressure, and where it is limited."""
        ratio = np.maximum(pressure, TINY) / self.reference_pressure
        growth = ratio ** (self.exponent - 1.0)
        return np.minimum(growth, MOST_GROWTH), growth > MOST_GROWTH


@dataclass(frozen=True)
class FrictionOnGrid:
    """The friction of a case on a grid, from which the limit of each increment follows.

    values: the coefficient (nx, ny), where it varies from place to place; unknown: cells where a map does not give it;
    varied: as in `FrictionLimit`.
    """

    spec: FrictionSpec
    values: FloatArray | None = None
    unknown: BoolArray | None = None
    varied: bool = True

    def limit(self, before: Fields | None = None, coefficient: float | None = None) -> FrictionLimit:
        """Return the friction limit in an increment.

        before: the fields at its start, which friction that runs in depends on; coefficient: of the stage.
        """
        spec = self.spec
        return FrictionLimit(
            self._coefficient(before, coefficient),
            math.inf if spec.shear_limit is None else spec.shear_limit,
            1.0 if spec.exponent is None else spec.exponent,
            1.0 if spec.reference_pressure is None else spec.reference_pressure,
            self.varied,
        )

    def _coefficient(self, before: Fields | None, coefficient: float | None) -> float | FloatArray:
        if self.values is not None:
            return self.values
        spec = self.spec
        if spec.initial is not None and spec.final is not None:
            assert before is not None
            done = before.slip_path / spec.slip if spec.slip else before.work_density / (spec.energy or 1.0)
            return spec.final + (spec.initial - spec.final) * np.exp(-done.astype(np.float64))
        if spec.pair is not None:
            return math.sqrt(spec.pair[0] * spec.pair[1])
        if coefficient is None:
            assert isinstance(spec.coefficient, float)
            return spec.coefficient
        return coefficient

    def require_known(self, contact: BoolArray, grid: Grid, case: Case) -> None:
        """Raise CaseError where a map gives no coefficient for cells in contact, (nx, ny)."""
        if self.unknown is None or not (without := self.unknown & contact).any():
            return
        i, j = np.argwhere(without)[0].tolist()
        raise case.source.problem(
            "the contact reaches places of which the map gives no coefficient, beyond its end or in its holes, as at"
            f" x = {grid.x[i]:.4g} mm, y = {grid.y[j]:.4g} mm; take a map that covers the contact",
            ("friction", "map"),
        )


Tangential = Callable[[DoubleArray, DoubleArray], object]
"""Writes the displacement by a shear traction, both (2, nx, ny), to its second argument."""

CLOSE = 1e-3
"""Change in a power step at which the eigenvalue is known well enough."""

OF_PRESSURE, OF_PRESSURE_SQUARED = 1.300, 1.082
"""Eigenvalue over w0 a S/4 where the fall goes with Hertz's pressure and with its square, w0 in the middle; by
`largest_growth` on 128 x 128 points."""


MOST_CHANGE = 0.05
"""Change of the coefficient over such cycles, over the largest coefficient."""


def fall_per_slip(spec: FrictionSpec, pressure: FloatArray, friction: FrictionLimit) -> DoubleArray | None:
    """Return by how much the friction limit falls per slip (MPa/mm), (nx, ny); None where it does not fall.

    pressure: at the increment's start (MPa); friction: its limit in the increment. The shear limit holds whatever the
    coefficient is.
    """
    if spec.initial is None or spec.final is None or spec.final >= spec.initial:
        return None
    pressure = pressure.astype(np.float64)
    limit, per_coefficient = (
        one.limit(pressure) for one in (friction, replace(friction, coefficient=1.0, shear_limit=math.inf))
    )
    fall = per_coefficient * (friction.coefficient - spec.final)
    fall *= 1.0 / spec.slip if spec.slip else limit / (spec.energy or 1.0)
    return np.where(limit < friction.shear_limit, fall, 0.0)


def largest_growth(fall: DoubleArray, tangential: Tangential, along: DoubleArray | None = None) -> float:
    """Return the largest eigenvalue of A diag(fall), by power steps on its symmetric form; tangential: applies A.

    along: direction of the slip of each cell, (2, nx, ny), of length 1; along x without it.
    """
    root = np.sqrt(fall)
    vector, found = root / max(float(np.linalg.norm(root)), TINY), 0.0
    shear, moved = np.zeros((2, *fall.shape)), np.zeros((2, *fall.shape))
    for _ in range(30):
        if along is None:
            shear[0] = root * vector
            tangential(shear, moved)
            image = root * moved[0]
        else:
            tangential(root * vector * along, moved)
            image = root * np.sum(moved * along, axis=0)
        before, found = found, float(np.vdot(vector, image))
        vector = image / max(float(np.linalg.norm(image)), TINY)
        if abs(found - before) <= CLOSE * found:
            break
    return found


def growth_on_sphere(spec: FrictionSpec, hertz: HertzContact, compliance: float, layer: float = 0.0) -> float:
    """Return the eigenvalue on Hertz's contact of a sphere before any slip; 0 where friction does not fall, or falls
    neither with the pressure nor with its square. compliance: the tangential one (1/MPa); layer: what a layer adds at
    each place (mm/MPa), which counts with the largest fall."""
    if spec.initial is None or spec.final is None or spec.final >= spec.initial:
        return 0.0
    if spec.exponent is not None or (spec.shear_limit or math.inf) < spec.initial * hertz.max_pressure:
        return 0.0
    drop, arm = (spec.initial - spec.final) * hertz.max_pressure, 0.25 * compliance * hertz.contact_radius
    if spec.slip:
        return drop / spec.slip * (OF_PRESSURE * arm + layer)
    return drop / (spec.energy or 1.0) * spec.initial * hertz.max_pressure * (OF_PRESSURE_SQUARED * arm + layer)


def require_stable(spec: FrictionSpec, pressure: FloatArray, friction: FrictionLimit, tangential: Tangential) -> None:
    """Raise WeakeningError where friction falls so fast that slip may run away, unless the case allows it.

    pressure, friction: as for `fall_per_slip`; tangential: as for `largest_growth`.
    """
    fall = None if spec.weakening == "allow" else fall_per_slip(spec, pressure, friction)
    if fall is None or not fall.any():
        return
    growth = largest_growth(fall, tangential)
    if growth >= 1.0:
        over = "slip" if spec.slip else "energy"
        raise WeakeningError(
            f"friction falls too fast with slip: the fall of the friction limit is {growth:.3g} times what the elastic"
            f" surfaces hold against it, so that slip runs away and depends on the increments; a larger friction.{over}"
            " is needed, or weakening: allow"
        )


def require_stable_on_rig(
    spec: FrictionSpec,
    pressure: FloatArray,
    friction: FrictionLimit,
    on_rig: Tangential,
    shear: FloatArray,
    motions: Sequence[str],
) -> None:
    """Raise WeakeningError where the friction of a contact that slides as a whole falls faster than its rig unloads.

    The actuator moves contact and rig. pressure, friction: as for `fall_per_slip`; on_rig: applies A + C N N^T dA;
    shear: (2, nx, ny), which opposes the slip; motions: of the contact, that the actuator of a rig moves.
    """
    fall = None if spec.weakening == "allow" else fall_per_slip(spec, pressure, friction)
    if fall is None or not fall.any():
        return
    shear = shear.astype(np.float64)
    growth = largest_growth(fall, on_rig, shear / np.maximum(np.hypot(*shear), TINY))
    if growth >= 1.0:
        over = "slip" if spec.slip else "energy"
        unload = "contact and rig unload" if motions else "the contact unloads"
        stiffer = f"a stiffer rig, {' and '.join(motions)} imposed on the contact itself, " if motions else ""
        raise WeakeningError(
            f"friction falls {growth:.3g} times as fast with slip as {unload}, so that the contact, which slides as a"
            f" whole, jumps; {stiffer}a larger friction.{over}, or weakening: allow is needed"
        )


def cycles_of_little_change(
    spec: FrictionSpec, cycles: float, fields: Fields, energy: FloatArray, path: FloatArray
) -> float:
    """Return the number of cycles, at least 1, over which no cell's coefficient changes much; infinite for any.

    A cell that dissipates half as much as the one that dissipates most may change twice as much.

    cycles, fields: at the end of the last cycle; energy: dissipated per area (mJ/mm^2), path: of slip (mm) in it.
    """
    if spec.initial is not None and spec.final is not None:
        largest, drop = max(spec.initial, spec.final), abs(spec.final - spec.initial)
        scale = spec.slip or spec.energy or 1.0
        so_far, more = (fields.slip_path, path) if spec.slip else (fields.work_density, energy)
        # a cell counts by what it dissipates: some cells have always just come into contact
        weight = energy / max(float(energy.max()), sys.float_info.min)
        in_a_cycle = float((weight * drop * np.exp(-so_far / scale) * more / scale).max())
        return max(1.0, MOST_CHANGE * largest / in_a_cycle) if in_a_cycle > 0.0 else math.inf
    for (before, low), (after, high) in pairwise(spec.cycles or ()):
        if cycles < before:
            return max(1.0, before - cycles)
        if cycles < after and low != high:
            in_a_cycle = abs(high - low) / (after - before)
            return max(1.0, min(after - cycles, MOST_CHANGE * max(low, high) / in_a_cycle))
        if cycles < after:
            return max(1.0, after - cycles)
    return math.inf


def friction_warnings(
    spec: FrictionSpec, stages: Sequence[Stage], hertz: HertzContact | None, material: Compliances
) -> Iterator[str]:
    """Yield one sentence per warning; hertz: the largest contact."""
    if hertz is not None and hertz.is_circle and spec.weakening != "allow":
        yield from _about_weakening(spec, growth_on_sphere(spec, hertz, material.tangential, material.layer_shear))
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
