"""Find the closed forms that hold for a line contact: Hertz or a rounded punch, and partial slip on them.

The formulas are in `fretsolve.reference.hertz` and `fretsolve.reference.line_slip`.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import cache, cached_property, partial

import numpy as np

from fretsolve.problem.setup.closed_forms import WITH_LAYER, ClosedForm, ClosedForms, Load, is_tilted, spence_ratio
from fretsolve.reference.cyclic_loading import SAME
from fretsolve.reference.hertz import HertzContact, HertzLine, LineContact, RoundedPunch
from fretsolve.reference.line_slip import LineMotion, LinePartialSlip, LineShear
from fretsolve.system.arrays import DoubleArray


@dataclass(frozen=True)
class LineClosedForms(ClosedForms):
    """The closed forms of a line contact along its load path. Stages are counted from 0."""

    @cached_property
    def hertz(self) -> tuple[None, ...]:
        """None at the end of each stage: no contact is round or elliptic."""
        return (None,) * len(self.loads)

    @cached_property
    def punch(self) -> None:
        """None: there is no round punch."""
        return None

    @cached_property
    def contacts(self) -> tuple[LineContact | None, ...]:
        """The contact at the end of each stage; None where it is tilted, pressed by delta_z, or of another shape."""
        find = cache(self._contact_under)
        return tuple(find(load["P"], "My" in load) if self._is_pressed(load) else None for load in self.loads)

    @cached_property
    def widest(self) -> LineContact | None:
        """The contact at the largest load; None where one is not known."""
        pressed = [load.get("P") != 0.0 for load in self.loads]
        if any(here and contact is None for here, contact in zip(pressed, self.contacts, strict=True)):
            return None
        known: list[LineContact] = [contact for contact in self.contacts if contact is not None]
        return max(known, key=lambda contact: contact.load, default=None)

    @property
    def source(self) -> str:
        """The authors of the contact's solution."""
        return "Hertz" if self.case.surface[0].kind == "cylinder" else "Ciavarella, Hills and Monno"

    def _is_pressed(self, load: Load) -> bool:
        return bool(load.get("P")) and not is_tilted(load)

    def _contact_under(self, P: float, in_middle: bool) -> LineContact | None:
        """Return the upright contact under P; in_middle: whether a moment of 0 holds the load in the grid's middle."""
        surface, modulus = self._only_surface, self._modulus
        if surface is None or (in_middle and surface.center[0] != 0.0):
            return None
        if surface.kind == "cylinder" and surface.radius > 0.0:
            return HertzLine(P, surface.radius, modulus)
        if surface.kind == "punch" and surface.edge_radius and surface.half_width:
            return RoundedPunch(P, surface.half_width, surface.edge_radius, modulus)
        return None

    @cached_property
    def _load_path(self) -> DoubleArray:
        """P, Qx, Qy (N/mm) and the mismatch along x before the first stage and at the end of each, (4, stages + 1)."""
        bulk, nan = self.model.bulk, math.nan
        ends = [
            (*(load.get(name, nan) for name in ("P", "Qx", "Qy")), 0.0 if bulk is None else bulk.mismatch(load)[0])
            for load in self.loads
        ]
        return np.array([(0.0,) * 4, *ends]).T.copy()

    def _varied_gross_slip(
        self, hertz: HertzContact | None, coefficient: float | None, P: float
    ) -> tuple[float, float, float | None]:
        contact = next((one for one in self.contacts if one is not None and one.load == P), None)
        force = None if contact is None else self._friction_on_contact(coefficient).line_gross_slip_force(contact)
        return math.inf if force is None else force, math.inf, None

    def contact_width(self, endless: float) -> float | None:
        """Return the width (mm) of the largest contact; of a sharp punch its face."""
        surface = self._only_surface
        if self.widest is not None:
            return 2.0 * self.widest.half_width
        if surface is not None and surface.kind == "punch" and not surface.edge_radius:
            return 2.0 * (surface.half_width or 0.0)
        return None

    def partial_slip(self, stage: int) -> LineShear | None:
        """Return the partial slip after `stage`; None where there is none or no closed form.

        There is none where shear acts on the pressure, under Qx and Qy together, where P changes under shear, where a
        motion is imposed, or where bulk stress is not in proportion to Qx or so large that a slip zone shrinks on the
        way.
        """
        contact = self.contacts[stage]
        if contact is None or not self.model.has_shear or self.model.coupled or self.friction_varies:
            return None
        if self.model.compliances.layer_shear:
            return None
        P, Qx, Qy, mismatch = self._load_path[:, : stage + 2]
        if np.isnan([Qx, Qy]).any():
            return None
        limit, material = self.model.friction * contact.load, self.model.compliances
        strain = self.model.friction * contact.max_pressure * material.A
        forces = np.array([Qx, Qy]) / limit
        sizes = [np.abs(one).max() for one in (*forces, mismatch / strain)]
        moved = np.flatnonzero(np.max([*np.abs(forces), np.abs(mismatch / strain)], axis=0) > SAME)
        if min(sizes[:2]) > SAME or min(sizes[1:]) > SAME or sizes[0] >= 1.0 or sizes[1] >= 1.0:
            return None
        if len(moved) and not np.ptp(P[max(moved[0] - 1, 0) :]) <= SAME * contact.load:
            return None
        friction = self.model.friction
        if sizes[2] <= SAME:
            axis = int(sizes[1] > SAME)
            compliance = material.A + axis * material.B
            on_loading = partial(_on_loading, contact, friction, compliance, (1.0, 0.0))
            return LineShear(tuple((Qx, Qy)[axis].tolist()), contact, axis, on_loading)
        # Qx and the mismatch in one proportion, or the mismatch alone
        largest = int(np.abs(mismatch).argmax())
        if not isinstance(contact, HertzLine):
            return None
        if np.abs(forces[0] * mismatch[largest] - forces[0][largest] * mismatch).max() > SAME * abs(mismatch[largest]):
            return None
        alone = sizes[0] <= SAME
        per_path = (0.0, 1.0) if alone else (1.0, float(mismatch[largest] / Qx[largest]))
        on_loading = partial(_on_loading, contact, friction, material.A, per_path)
        shear = LineShear(tuple((mismatch if alone else Qx).tolist()), contact, 0, on_loading)
        if not shear.is_reached or not (alone or shear.slips_one_way or len(shear.branches) == 1):
            return None
        return shear

    def motion(self, contact: LineContact) -> LineMotion | None:
        """Return how points at the reference depth move with Qx between like bodies; None without such a depth."""
        depth, model = self.case.reference_depth, self.model
        if depth is None or not model.friction or model.coupled or model.bulk is not None or self.friction_varies:
            return None
        if model.compliances.layer_shear or not model.compliances.A:
            return None
        pair = model.compliances
        deep = depth * math.exp(0.5 * (pair.A + pair.B) / pair.A)
        return LineMotion(contact, model.friction, pair.A, deep)

    @cached_property
    def shaken_down(self) -> LinePartialSlip | None:
        """Force and bulk stress by half of what the last two stages change, once they repeat; None if it is not known.

        The shear traction that stays behind takes up their mean values.
        """
        bulk, contact = self.model.bulk, self.contacts[-1]
        if bulk is None or len(self.loads) < 2 or not isinstance(contact, HertzLine) or self.model.coupled:
            return None
        if self.friction_varies or self.model.compliances.layer_shear:
            return None
        ends = self.loads[-2:]
        P, Qx, Qy = (np.array([load.get(name, np.nan) for load in ends]) for name in ("P", "Qx", "Qy"))
        mismatch = [bulk.mismatch(load)[0] for load in ends]
        force, limit = 0.5 * float(Qx[1] - Qx[0]), self.model.friction * contact.load
        if not (np.ptp(P) <= SAME * contact.load and np.abs(Qy).max() <= SAME * limit and SAME * limit < abs(force)):
            return None
        if np.abs(Qx).max() >= limit:
            return None
        strain = 0.5 * float(mismatch[1] - mismatch[0])
        found = LinePartialSlip(contact, self.model.friction, force, self.model.compliances.A, strain)
        return found if not found.reverses and found.is_reached_in_proportion else None

    def values(self, wanted: Collection[int] | None = None) -> Iterator[ClosedForm]:
        """Yield the exact values at the ends of the stages; wanted: as for `ClosedForms`."""
        if self.model.terms.normal_tangential_coupling or self.case.wear is not None:
            return  # wear changes the shape of the surfaces
        for stage, contact in enumerate(self.contacts):
            if contact is None or (wanted is not None and stage not in wanted):
                continue
            a = contact.half_width
            found = {"max_pressure": contact.max_pressure, "contact_radius": a, "contact_area": 2.0 * a}
            yield from (ClosedForm(name, stage, value, self.source) for name, value in found.items())
            shear = self.partial_slip(stage)
            if shear is None or not any(shear.path):
                continue
            c, work = shear.stick_half_width, shear.dissipated_energy()
            found = {"stick_radius": c, "stick_area": 2.0 * c}
            if self.model.bulk is not None:
                found["stick_center_x"] = self.case.surface[0].center[0] + shear.stick_center
            found |= {} if work is None else {"work_total": work}
            yield from (ClosedForm(name, stage, value, self.shear_source) for name, value in found.items())

    @property
    def shear_source(self) -> str:
        """The authors of the solution for partial slip."""
        if self.model.bulk is not None:
            return "Hills-Nowell"
        return "Cattaneo-Mindlin" if self.case.surface[0].kind == "cylinder" else "Ciavarella-Jaeger"

    @property
    def why_not_mindlin(self) -> str:
        """Empty without a layer: in a line contact shear along x does not move the surfaces along y."""
        return WITH_LAYER if self.model.compliances.layer_shear else ""

    @cached_property
    def smallest_stick(self) -> ClosedForm | None:
        """The smallest half-width (mm) of the stick zone on the path; None where no closed form gives it."""
        if not self.model.has_shear or self.model.compliances.layer_shear:
            return None
        if self.model.moved:
            if (whole := self.partial_slip(len(self.loads) - 1)) is None:
                return None
            # One partial slip costs as much as the path before it, so the largest loads are tried first.
            sizes = np.abs(whole.path[1:])
            stages = [stage for stage in np.argsort(-sizes, kind="stable").tolist() if sizes[stage]]
            known = ((one, stage) for stage in stages if (one := self.partial_slip(stage)) is not None)
            shear, stage = next(known, (whole, -1))
            if stage < 0:
                return None
            largest = shear.on_loading(abs(shear.path[-1]))
            if not largest.is_known:
                return None
            return ClosedForm("stick_radius", stage, largest.stick_half_width, self.shear_source)
        if not isinstance(self.widest, HertzLine) or not self.model.coupled or self.friction_varies:
            return None
        radius = spence_ratio(self.model) * self.widest.half_width
        return ClosedForm("stick_radius", self.contacts.index(self.widest), radius, "Spence, one-way")


def _on_loading(
    contact: LineContact, friction: float, compliance: float, per_path: tuple[float, float], value: float
) -> LinePartialSlip:
    """Return the solution on first loading; per_path: force and mismatch per value of the path."""
    return LinePartialSlip(contact, friction, per_path[0] * value, compliance, per_path[1] * value)
