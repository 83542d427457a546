"""What closed forms know of a contact on a rig: loads at the contact that motions of the actuator amount to.

Of a line contact they also know what motions of points at the reference depth amount to, with a rig and without one.

The normal load follows from D = delta_z(P) + C P with Hertz, Boussinesq or Love. A tangential one follows from
D = delta(Q) + C Q along the load path, with Cattaneo and Mindlin, or Lubkin, at constant P between like bodies. Where
the contact slides as a whole, Q stays at its limit, and the contact moves by D - C Q. Nothing is known of a rig whose
modes act on each other.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fretsolve.case.history import ACTUATORS, COMPONENTS
from fretsolve.case.models import Case
from fretsolve.problem.model.increment_grading import SHARES, LoadsAtContact
from fretsolve.problem.model.required_terms import Model
from fretsolve.problem.setup.closed_forms import ClosedForm, ClosedForms, Load, is_tilted
from fretsolve.problem.setup.driven_contact import DrivenContact, DrivenPath
from fretsolve.problem.setup.line_forms import LineClosedForms
from fretsolve.reference.cyclic_loading import SAME, CyclicLoading
from fretsolve.reference.hertz import HertzContact, boussinesq_punch, love_cone
from fretsolve.reference.layered import layered_stick_compliance, onset_compliance
from fretsolve.system.arrays import DoubleArray

Approach = tuple[float, float]
"""The approach under 1 N (mm), and the power of P with which it grows."""


@dataclass(frozen=True)
class RigForms:
    """A contact on a rig along its load path. Stages are counted from 0.

    imposed: the load components before the first stage and at the end of each one. Without a rig it gives by nothing.
    """

    case: Case
    model: Model
    imposed: tuple[Load, ...]

    @cached_property
    def loads(self) -> tuple[Load, ...]:
        """As `imposed`, with loads of the contact in place of the actuator's motions that closed forms turn into them.

        In a line contact they take the place of its own motions too. A contact that slides as a whole has its motion.
        """
        turned = {*ACTUATORS.values(), *(COMPONENTS[3] if self.model.line else ())}
        if not self._is_diagonal or not any(turned & load.keys() for load in self.imposed):
            return self.imposed
        loads = list(self._pressed)
        for index, (path, state) in self._followed.items():
            force, motion, _ = path.names
            if given := turned & loads[index].keys() & set(path.names):
                named = {motion: state.motion} if state.slides else {force: state.force}
                loads[index] = {name: value for name, value in loads[index].items() if name not in given} | named
        return tuple(loads)

    @cached_property
    def driven(self) -> tuple[tuple[str, str, str], dict[int, DrivenContact]] | None:
        """The names of the tangential mode that moves, and the contact by the stage at whose end it is.

        From the last stage without shear on, as long as a closed form holds; None if it never does.
        """
        if self._path is None or not self._followed:
            return None
        return self._path.names, {index - 1: state for index, (_, state) in self._followed.items()}

    @cached_property
    def _followed(self) -> dict[int, tuple[DrivenPath, DrivenContact]]:
        """The way up to a load, and the contact under it, by the place of the load in `imposed`."""
        first, found = self._first_moved, dict[int, tuple[DrivenPath, DrivenContact]]()
        if self._path is None or first is None:
            return found
        path = replace(self._path)
        for index in range(first - 1, len(self.imposed)):
            here, before = self._forms.contacts[index], replace(path)
            if here is None or abs(here.load - path.load) > SAME * here.load:
                break
            if (state := path.follow(self.imposed[index])) is None:
                break
            found[index] = before, state
        return found

    @cached_property
    def pressed(self) -> tuple[DrivenContact | None, ...]:
        """The contact under P at the end of each stage; None without a closed form, or where no rig gives along z."""
        if self._approach is None or not self._is_diagonal or not self._compliance(0):
            return (None,) * (len(self.imposed) - 1)
        scale, power = self._approach
        found = list[DrivenContact | None]()
        for load in self._pressed[1:]:
            force = 0.0 if is_tilted(load) else load.get("P", 0.0)
            approach = scale * force**power
            known = DrivenContact(force, approach, approach + self._compliance(0) * force, False)
            found.append(known if force else None)
        return tuple(found)

    @cached_property
    def reversal(self) -> tuple[tuple[str, str, str], float, float] | None:
        """The names of the tangential mode that moves, and the compliances of rig and contact (mm/N, rad/(N mm)).

        None where the contact is no circle, or where several modes move. The contact sticks, as just after a reversal.
        """
        moved, largest = self._moved_modes, self._forms.largest
        if len(moved) != 1 or not self._is_diagonal:
            return None
        if isinstance(self._forms, LineClosedForms):
            known = None if self._forms.widest is None or moved != (3,) else self._forms.motion(self._forms.widest)
            return None if known is None else (COMPONENTS[3], self._compliance(3), known.sticking)
        if largest is None or not largest.is_circle:
            return None
        mode, a, material = moved[0], largest.contact_radius, self.model.compliances
        if not self.model.has_shear or (mode == 5 and material.layer_shear):
            return None
        sticking = layered_stick_compliance(a, material.tangential, material.layer_shear)
        if mode == 5:
            sticking = 3.0 * material.torsional / (16.0 * a**3)
        return COMPONENTS[mode], self._compliance(mode), sticking

    @cached_property
    def gross_slip(self) -> tuple[float, float] | None:
        """The motions of contact and actuator (mm, rad) where gross slip begins on first loading; None if unknown."""
        if (path := self._path) is not None:
            motion = path.motion(path.shear.limit)
            return motion, motion + path.compliance * path.shear.limit
        model, hertz = self.model, self._forms.largest
        known = self.reversal is not None and not (model.coupled or model.bulk or self.case.friction_varies)
        if not known or hertz is None or not model.compliances.layer_shear:
            return None
        material, limit = model.compliances, model.friction * hertz.load
        onset = onset_compliance(hertz.contact_radius, material.tangential, material.layer_shear)
        motion = 3.0 * limit * onset / (16.0 * hertz.contact_radius)
        return motion, motion + self._compliance(self._moved_modes[0]) * limit

    def values(self) -> Iterator[ClosedForm]:
        """Yield what the driven contact adds to `ClosedForms.values`: force, motion and actuator's motion, as exact."""
        if self.driven is None or self.case.wear is not None:
            return
        names, states = self.driven
        in_plane, B = self.model.terms.in_plane_coupling, self.model.compliances.B
        if B and not self.model.line and (names[0] == "Mz") != in_plane:
            return
        source = "Lubkin" if names[0] == "Mz" else "Cattaneo-Mindlin"
        source = self._forms.shear_source if isinstance(self._forms, LineClosedForms) else source
        for stage, state in states.items():
            if stage >= 0 and state.force:
                found = list(zip(names, (state.force, state.motion, state.actuator), strict=True))
                found = found if self.model.rig is not None else found[:2]
                yield from (ClosedForm(name, stage, value, source) for name, value in found)

    def course(self, stage: int) -> dict[str, DoubleArray]:
        """Return the loads at `SHARES` of a stage, where the actuator's motion does not move them in proportion."""
        before, after = self.loads[stage], self.loads[stage + 1]
        raw, found = self.imposed[stage + 1], dict[str, DoubleArray]()
        if "actuator_z" in raw and self._approach is not None and {"P"} <= before.keys() & after.keys():
            forces = before["P"] + (after["P"] - before["P"]) * np.linspace(0.0, 1.0, 100) ** 3
            scale, power = self._approach
            found["P"] = _by_motion(forces, scale * forces**power + self._compliance(0) * forces)
        if (followed := self._followed.get(stage + 1)) is not None:
            path, _ = followed
            force, motion, actuator = path.names
            if (actuator in raw or motion in raw) and {force} <= before.keys() & after.keys():
                given, forces = path.given(raw), np.linspace(before[force], after[force], 50)
                motions = np.array([path.motion(value) + given * value for value in forces.tolist()])
                found[force] = _by_motion(forces, motions)
        return found

    @property
    def at_contact(self) -> LoadsAtContact:
        """The loads of the contact, and their course in each stage, for the grading of increments."""
        return LoadsAtContact(tuple(map(dict, self.loads)), self.course)

    # The normal load, and rotations that are held.

    @cached_property
    def _pressed(self) -> tuple[Load, ...]:
        """The loads with what presses and holds the contact, in place of the actuator's motions."""
        unmoved = [mode for mode in range(1, 6) if self._stays(mode)]
        return tuple(self._at_contact(load, unmoved) for load in self.imposed)

    def _stays(self, mode: int) -> bool:
        """Return whether a mode is never loaded: nothing turns or shears a single surface in the grid's origin."""
        if any(load.get(name) for load in self.imposed for name in COMPONENTS[mode]):
            return False
        return mode in (3, 4) or (len(self.case.surface) == 1 and self.case.surface[0].center == (0.0, 0.0))

    def _at_contact(self, load: Load, unmoved: Sequence[int]) -> Load:
        held = {COMPONENTS[mode][2]: COMPONENTS[mode][1] for mode in unmoved}
        found = {held.get(name, name): value for name, value in load.items()}
        motion = found.get("actuator_z")
        if motion is None or is_tilted(found):
            return found
        force = self._force_at(motion) if motion > 0.0 else None
        if motion > 0.0 and force is None:
            return found
        others = {name: value for name, value in found.items() if name != "actuator_z"}
        return {"delta_z": motion, **others} if force is None else {"P": force, **others}

    def _force_at(self, motion: float) -> float | None:
        """Return the normal load (N) at a motion of the actuator > 0 (mm); None without a closed form."""
        from scipy.optimize import brentq

        if self._approach is None:
            return None
        scale, power = self._approach
        given = self._compliance(0)
        most = (motion / scale) ** (1.0 / power)
        force = most
        if given:
            most = min(most, motion / given)
            force = float(brentq(lambda P: scale * P**power + given * P - motion, 0.0, most, xtol=1e-15 * most))
        surface = self.case.surface[0]
        by_hertz = surface.kind not in ("punch", "cone")
        return None if by_hertz and self._raw_forms.hertz_under("P", force) is None else force

    @cached_property
    def _approach(self) -> Approach | None:
        """The law of the approach: by Hertz, Boussinesq or Love; None for other surfaces."""
        forms, surface = self._raw_forms, self.case.surface[0]
        if len(self.case.surface) > 1 or self.model.line or self.model.compliances.layer_normal:
            return None
        modulus = self.model.compliances.contact_modulus
        if surface.kind == "punch" and surface.radius is not None and not surface.edge_radius:
            return boussinesq_punch(1.0, surface.radius, modulus).delta_z, 1.0
        if surface.kind == "cone":
            return love_cone(1.0, surface.angle, modulus).delta_z, 0.5
        hertz = forms.hertz_under("P", 1.0)
        return None if hertz is None else (hertz.delta_z, 2.0 / 3.0)

    # The tangential load.

    @cached_property
    def _path(self) -> DrivenPath | None:
        """The way of the contact from the load before the first that shears it on; None without a closed form."""
        first, moved, model = self._first_moved, self._moved_modes, self.model
        if first is None or first == 0 or len(moved) != 1 or not self._is_diagonal or not model.has_shear:
            return None
        if model.coupled or model.bulk is not None or self.case.friction_varies or model.compliances.layer_shear:
            return None
        mode, hertz = moved[0], self._forms.contacts[first - 1]
        if hertz is None or any(map(is_tilted, self._pressed)):
            return None
        if not isinstance(hertz, HertzContact):
            assert isinstance(self._forms, LineClosedForms)
            along = self._forms.motion(hertz) if mode == 3 else None
            return None if along is None else DrivenPath(COMPONENTS[3], along, hertz.load, self._compliance(3))
        if not hertz.is_circle:
            return None
        center = self.case.surface[0].center
        turns = any(COMPONENTS[5][2] in load for load in self._pressed)  # a force off the origin turns the rig
        if center != (0.0, 0.0) and (mode == 5 or turns):
            return None
        direction = {3: (1.0, 0.0), 4: (0.0, 1.0)}.get(mode)
        compliance = model.compliances.torsional if mode == 5 else model.compliances.tangential
        shear = CyclicLoading(hertz, center, model.friction, compliance, direction, ())
        return DrivenPath(COMPONENTS[mode], shear, hertz.load, self._compliance(mode))

    @cached_property
    def _moved_modes(self) -> tuple[int, ...]:
        return tuple(
            mode for mode in (3, 4, 5) if any(load.get(name) for load in self.imposed for name in COMPONENTS[mode])
        )

    @cached_property
    def _first_moved(self) -> int | None:
        names = [name for mode in self._moved_modes for name in COMPONENTS[mode]]
        return next((index for index, load in enumerate(self.imposed) if any(map(load.get, names))), None)

    @cached_property
    def _forms(self) -> ClosedForms:
        """The closed forms of pressing, also before the first stage."""
        return (LineClosedForms if self.model.line else ClosedForms)(self.case, self.model, self._pressed)

    @cached_property
    def _raw_forms(self) -> ClosedForms:
        return ClosedForms(self.case, self.model, self.imposed)

    @cached_property
    def _is_diagonal(self) -> bool:
        rig = self.model.rig
        return rig is None or np.array_equal(rig.compliance, np.diag(np.diag(rig.compliance)))

    def _compliance(self, mode: int) -> float:
        return 0.0 if self.model.rig is None else float(self.model.rig.compliance[mode, mode])


def _by_motion(forces: DoubleArray, motions: DoubleArray) -> DoubleArray:
    """Return the forces at `SHARES` of the way from the first to the last motion, which may fall."""
    shares = (motions - motions[0]) / (motions[-1] - motions[0] or 1.0)
    return np.interp(SHARES, shares, forces)
