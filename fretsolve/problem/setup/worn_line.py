"""Predict the wear of a cylinder's line contact in gross slip before a run, by closed forms."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

from fretsolve.case.keys.load_path_spec import WearJumps
from fretsolve.case.keys.unrolled_path import CyclePass
from fretsolve.errors import KeyPath
from fretsolve.problem.setup.closed_forms import ClosedForms
from fretsolve.problem.setup.line_forms import LineClosedForms
from fretsolve.reference.hertz import HertzLine
from fretsolve.reference.line_slip import LineMotion
from fretsolve.reference.worn_contact import CylinderWornByGrossSlip

EXPLICIT_LIMIT = 1.485
"""As in `wear_forms`, for strips: 16 G/pi^2 with Catalan's constant G, from the displacement under strips of
alternating signs."""


@dataclass(frozen=True)
class WornLineCycle:
    """A cycle of a cylinder's line contact that stands for others, in gross slip between imposed motions, under P.

    Fields and properties mean the same as in `WornCycle`, per mm of the line; depth: as of `CylinderWornByGrossSlip`.
    """

    key: KeyPath
    stages: tuple[int, int]
    jumps: WearJumps
    motion: LineMotion
    contact: HertzLine
    coefficient: float
    amplitude: float
    depth: float
    slides: ClassVar[bool] = True
    load_kept: ClassVar[bool] = True
    limit: ClassVar[None] = None

    @property
    def unworn_radius(self) -> float:
        """The half-width of the contact before wear (mm)."""
        return self.contact.half_width

    @property
    def sliding_distance(self) -> float:
        """Distance (mm) that the whole contact slips in half a cycle."""
        return 2.0 * (self.amplitude - self.motion.on_loading(self.motion.limit))

    @property
    def energy(self) -> float:
        """Energy (mJ/mm) that one of the first cycles dissipates."""
        return self.motion.work_of_gross_slip + 2.0 * self.motion.limit * self.sliding_distance

    @property
    def volume_per_cycle(self) -> float:
        """Volume (mm^3/mm) that one of the first cycles wears."""
        return self.coefficient * self.energy

    @property
    def depth_per_cycle(self) -> float:
        """Mean depth (mm) that one of the first cycles wears."""
        return 0.5 * self.volume_per_cycle / self.contact.half_width

    @property
    def volume_at_first_rate(self) -> float:
        """Volume (mm^3/mm) if all cycles wore as much as the first one."""
        return self.volume_per_cycle * self.jumps.represents

    @property
    def time(self) -> float:
        """V/V0, with V0 = 2 a0^3/3R of the cylinder's cap within its half-width before wear."""
        return self.volume_at_first_rate * 1.5 * self.contact.radius / self.contact.half_width**3

    @cached_property
    def scar(self) -> CylinderWornByGrossSlip | None:
        """The scar after all cycles; None where nothing is worn."""
        volume = self.volume_at_first_rate
        return CylinderWornByGrossSlip(self.contact, volume, self.depth) if volume > 0.0 else None

    @property
    def largest_radius(self) -> float:
        """The largest half-width (mm) of the worn contact, estimated for the size of the grid.

        The contact slips farther as it grows wider, since it gives way less: by its motion up to gross slip at most.
        """
        slips = self.amplitude / (0.5 * self.sliding_distance)
        volume = slips * self.volume_at_first_rate
        return CylinderWornByGrossSlip(self.contact, volume, self.depth).scar_radius if volume > 0.0 else 0.0

    def explicit_limit(self, cell: float) -> float:
        """Return the cycles per jump up to which an explicit update of the profile is stable; cell: its side (mm)."""
        rim = self.motion.compliance * self.motion.limit / math.pi  # slip there at the onset of gross slip
        path = 4.0 * rim + 2.0 * self.sliding_distance
        stable = EXPLICIT_LIMIT * cell / self.contact.contact_modulus
        return stable / (self.coefficient * self.motion.friction * path) if self.coefficient else math.inf


def worn_line_cycle(
    forms: ClosedForms,
    cycle: CyclePass,
    stages: tuple[int, int],
    contact: HertzLine,
    coefficient: float,
    amplitude: float,
) -> WornLineCycle | None:
    """Return a cycle of imposed motions along x; None where it is partial slip, or no closed form gives the motion.

    stages, coefficient, amplitude: as of `WornCycle`, which is of a sphere.
    """
    assert isinstance(forms, LineClosedForms) and cycle.jumps is not None
    motion, pair = forms.motion(contact), forms.model.compliances
    if motion is None or amplitude <= motion.on_loading(motion.limit):
        return None
    depth = motion.depth * math.exp(-(pair.A + pair.B) / pair.A)
    return WornLineCycle(cycle.key, stages, cycle.jumps, motion, contact, coefficient, amplitude, depth)
