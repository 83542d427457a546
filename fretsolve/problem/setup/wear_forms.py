"""Predict wear before a run by closed forms: depth and volume of a cycle, the scar after all of them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from fretsolve.case.history import OF_RIG
from fretsolve.case.keys.load_path_spec import WearJumps
from fretsolve.case.keys.unrolled_path import CyclePass
from fretsolve.errors import KeyPath
from fretsolve.problem.setup.closed_forms import ClosedForms, Load
from fretsolve.reference.hertz import HertzContact, HertzLine
from fretsolve.reference.layered import onset_compliance
from fretsolve.reference.tangential import CattaneoMindlin, cattaneo_mindlin
from fretsolve.reference.worn_contact import (
    WornByGrossSlip,
    WornLimit,
    partial_slip_wear_time,
    volume_scale,
    worn_by_gross_slip,
    worn_limit_at_displacement,
    worn_limit_at_force,
)

if TYPE_CHECKING:
    from fretsolve.problem.setup.worn_line import WornLineCycle

EXPLICIT_LIMIT = 1.161
"""Depth of a jump over p dx/E* from which an explicit update of the profile is unstable: 2 lam/(dx/E*), lam being the
least eigenvalue of the normal compliance of square cells."""

GROWTH_OF_RATE = 2.5
"""Least factor on the volume at the first rate of partial slip, for the size of the grid: with it, and with sqrt(1 + T)
from T = 5 on, the scar fits in. At c = 0.2 a0 volumes are 1.7, 2.6 and 4.1 times that at T = 3, 10 and 30."""


@dataclass(frozen=True)
class WornCycle:
    """A cycle of a sphere that stands for others, under one tangential component that alternates.

    key: where it stands in the case file; stages: its first and last stage in the first repetition (from 1); hertz:
    Hertz's contact of the sphere; coefficient: worn volume per dissipated energy (mm^3/mJ); amplitude: of the force (N)
    or of the displacement (mm), about mean; forced: whether of the force; load_kept: whether P is imposed,
    else the approach is; coupled: whether pressure and shear change each other, or a layer shears between the bodies,
    which no closed form of a worn limit includes; on_rig: whether a rig takes a part of the motion, which changes as
    the contact wears.
    """

    key: KeyPath
    stages: tuple[int, int]
    jumps: WearJumps
    hertz: HertzContact
    friction: float
    coefficient: float
    contact_modulus: float
    compliance: float
    amplitude: float
    mean: float
    forced: bool
    load_kept: bool
    coupled: bool = False
    on_rig: bool = False

    @cached_property
    def slides(self) -> bool:
        """True if the contact slips as a whole in each half cycle."""
        return self.amplitude >= (self._limit if self.forced else self._sliding.delta_x)

    @cached_property
    def slip(self) -> CattaneoMindlin:
        """Partial slip at the amplitude, at most the amplitude at which the contact begins to slide."""
        if self.slides:
            return self._sliding
        force = self.amplitude
        if not self.forced:
            force = self._limit * (1.0 - (1.0 - self.amplitude / self._sliding.delta_x) ** 1.5)
        return cattaneo_mindlin(self.hertz, self.friction, force, self.compliance)

    @property
    def sliding_distance(self) -> float:
        """Distance (mm) that the whole contact slips in half a cycle."""
        return 2.0 * (self.amplitude - self._sliding.delta_x) if self.slides and not self.forced else 0.0

    @property
    def energy(self) -> float:
        """Energy (mJ) that one of the first cycles dissipates."""
        return self.slip.work_per_cycle + 2.0 * self._limit * self.sliding_distance

    @property
    def volume_per_cycle(self) -> float:
        """Volume (mm^3) that one of the first cycles wears."""
        return self.coefficient * self.energy

    @property
    def depth_per_cycle(self) -> float:
        """Mean depth (mm) that one of the first cycles wears where it slips; 0 where that is below rounding."""
        area = math.pi * (self.hertz.contact_radius**2 - self.slip.stick_radius**2)
        return self.volume_per_cycle / area if area > 0.0 else 0.0

    @property
    def volume_at_first_rate(self) -> float:
        """Volume (mm^3) if all cycles wore as much as the first one."""
        return self.volume_per_cycle * self.jumps.represents

    @property
    def time(self) -> float:
        """T, the number of cycles without units: V/V0 in gross slip, else `partial_slip_wear_time`."""
        if self.slides:
            return self.volume_at_first_rate / volume_scale(self.hertz)
        numbers = self.friction, self.contact_modulus, self.compliance, self.coefficient, self.jumps.represents
        return partial_slip_wear_time(self.hertz, *numbers)

    @cached_property
    def limit(self) -> WornLimit | None:
        """The worn limit of partial slip about no mean; None where no closed form gives it."""
        if self.slides or self.mean or self.coupled or self.on_rig or self.forced != self.load_kept:
            return None
        radius = self.hertz.radii[0]
        if self.forced:
            return worn_limit_at_force(self.hertz.load, self.amplitude, self.friction, radius, self.contact_modulus)
        numbers = self.amplitude, self.friction, radius, self.contact_modulus, self.compliance
        return worn_limit_at_displacement(self.hertz.delta_z, *numbers)

    @cached_property
    def likely_limit(self) -> WornLimit | None:
        """The worn limit of partial slip, estimated by similar bodies under P where no closed form gives it.

        None of gross slip.
        """
        if self.slides or self.limit is not None:
            return self.limit
        force, radius = abs(self.slip.shear_force), self.hertz.radii[0]
        return worn_limit_at_force(self.hertz.load, force, self.friction, radius, self.contact_modulus)

    @cached_property
    def scar(self) -> WornByGrossSlip | None:
        """The scar of gross slip under P after all cycles; None of partial slip."""
        if not self.slides or not self.load_kept or self.volume_at_first_rate <= 0.0:
            return None
        volume, radius = self.volume_at_first_rate, self.hertz.radii[0]
        return worn_by_gross_slip(self.hertz.load, radius, self.contact_modulus, volume)

    @property
    def largest_radius(self) -> float:
        """The largest radius (mm) of the worn contact, estimated for the size of the grid.

        It is (a0^4 + 4 R V/pi)^(1/4), or the radius of the worn limit. A ring may be up to a tenth wider.
        """
        if (end := self.likely_limit) is None:
            return _radius_with(self.hertz, self.volume_at_first_rate)
        growth = max(GROWTH_OF_RATE, math.sqrt(1.0 + self.time))
        reached = _radius_with(self.hertz, growth * self.volume_at_first_rate)
        return min(reached, end.scar_radius)

    @property
    def unworn_radius(self) -> float:
        """The radius of the contact before wear (mm)."""
        return self.hertz.contact_radius

    @property
    def longest_path(self) -> float:
        """Path of slip (mm) in one of the first cycles at the contact's rim, the longest of all."""
        rim = float(self.slip.slip(np.array(self.hertz.contact_radius)))
        return 4.0 * rim + 2.0 * self.sliding_distance

    def explicit_limit(self, cell: float) -> float:
        """Return the cycles per jump up to which an explicit update of the profile is stable; cell: its side (mm)."""
        depth_over_pressure = self.coefficient * self.friction * self.longest_path
        stable = EXPLICIT_LIMIT * cell / self.contact_modulus
        return stable / depth_over_pressure if depth_over_pressure > 0.0 else math.inf

    @property
    def _limit(self) -> float:
        return self.friction * self.hertz.load

    @cached_property
    def _sliding(self) -> CattaneoMindlin:
        return cattaneo_mindlin(self.hertz, self.friction, self._limit, self.compliance)


AnyWornCycle: TypeAlias = "WornCycle | WornLineCycle"


def _radius_with(unworn: HertzContact, volume: float) -> float:
    """Return (a0^4 + 4 R V/pi)^(1/4)."""
    fourth = unworn.contact_radius**4 + 4.0 * unworn.radii[0] * volume / math.pi
    return math.sqrt(math.sqrt(fourth))


def worn_cycles(forms: ClosedForms) -> tuple[AnyWornCycle, ...]:
    """Return the cycles of a case that stand for others and have closed forms."""
    return tuple(cycle for one in _first_repetitions(forms) if (cycle := _worn_cycle(forms, *one)) is not None)


def worn_radius(forms: ClosedForms) -> float:
    """Return a radius (mm) that the worn contact does not exceed, or half a width; 0 where closed forms do not tell."""
    found = worn_cycles(forms)
    cycles = [cycle for cycle in found if isinstance(cycle, WornCycle)]
    sliding = sum(cycle.volume_at_first_rate for cycle in cycles if cycle.slides)
    reached = [cycle.largest_radius for cycle in found]
    if sliding > 0.0:
        hertz = max((cycle.hertz for cycle in cycles), key=lambda one: one.load)
        reached.append(_radius_with(hertz, sliding))
    return max(reached, default=0.0)


def _first_repetitions(forms: ClosedForms) -> Iterator[tuple[CyclePass, int, int]]:
    """Yield the first repetition of each cycle that stands for others, with its first and last stage (from 0)."""
    seen = set[object]()
    stages = forms.case.stages()
    for index, stage in enumerate(stages):
        cycle = stage.cycle
        if cycle is None or cycle.jumps is None or cycle.key in seen:
            continue
        seen.add(cycle.key)
        last = index
        while last + 1 < len(stages) and stages[last + 1].cycle == cycle:
            last += 1
        yield cycle, index, last


def _worn_cycle(forms: ClosedForms, cycle: CyclePass, first: int, last: int) -> AnyWornCycle | None:
    """Return a cycle; None unless a sphere is pressed alike, upright, and one component moves it to and fro.

    Of a line it is gross slip of a cylinder between imposed motions.
    """
    case, model, wear, pair = forms.case, forms.model, forms.case.wear, forms.model.compliances
    if wear is None or wear.exponent is not None or cycle.jumps is None:
        return None
    if case.friction_varies or case.friction.pair is not None or model.bulk is not None:
        return None
    # the stage before the cycle is at the loads with which it ends
    contacts = forms.contacts[max(first - 1, 0) : last + 1]
    hertz = contacts[-1]
    if not first or hertz is None or any(one != hertz for one in contacts):
        return None
    loads = forms.loads[first - 1 : last + 1]
    moved = _alternating(loads)
    if moved is None:
        return None
    name, least, most = moved
    coefficient = wear.alpha if wear.alpha is not None else (wear.k or 0.0) / model.friction
    if model.line:
        from fretsolve.problem.setup.worn_line import worn_line_cycle  # other cases do not need it

        if name != "delta_x" or not isinstance(hertz, HertzLine):
            return None
        return worn_line_cycle(forms, cycle, (first + 1, last + 1), hertz, coefficient, 0.5 * (most - least))
    if not isinstance(hertz, HertzContact) or not hertz.is_circle:
        return None
    targets = (target for stage in case.stages() for target in stage.targets)
    moved_by_rig = {name for name, value in targets if name in OF_RIG and value}
    return WornCycle(
        key=cycle.key,
        stages=(first + 1, last + 1),
        jumps=cycle.jumps,
        hertz=hertz,
        friction=model.friction,
        coefficient=coefficient,
        contact_modulus=model.compliances.contact_modulus,
        compliance=onset_compliance(hertz.contact_radius, pair.tangential, pair.layer_shear),
        amplitude=0.5 * (most - least),
        mean=0.5 * (most + least),
        forced=name[0] == "Q",
        load_kept="P" in loads[-1] and "actuator_z" not in moved_by_rig,
        coupled=model.coupled or bool(pair.layer_shear),
        on_rig=bool(moved_by_rig),
    )


def _alternating(loads: tuple[Load, ...]) -> tuple[str, float, float] | None:
    """Return the only tangential component that changes, with its least and largest value; None for several."""
    found = []
    for name in ("Qx", "Qy", "Mz", "delta_x", "delta_y", "phi_z"):
        values = [load[name] for load in loads if name in load]
        if any(values):
            found.append((name, min(values), max(values)))
    if len(found) != 1 or found[0][0] in ("Mz", "phi_z") or found[0][1] == found[0][2]:
        return None
    return found[0]
