"""What closed forms let one expect of a case before it is run: where everything slides, and how much will stick."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fretsolve.case.load_components import TANGENTIAL
from fretsolve.reference.closed_forms import HertzContact, lubkin, mindlin_displacement, spence_stick_ratio

if TYPE_CHECKING:
    from fretsolve.setup.hertz import Hertz
    from fretsolve.setup.problem_setup import ProblemSetup


@dataclass(frozen=True)
class Slide:
    """A tangential load beyond what friction carries, at the end of `stage` (from 0): both in N or N mm.

    component: of the case file, the larger one where there are two; limit: mu P in words.
    """

    stage: int
    component: str
    load: float
    carried: float
    limit: str


@dataclass(frozen=True)
class Stick:
    """The smallest stick radius (mm) of the path, at the end of `stage` (from 0), and whose theory says so."""

    stage: int
    radius: float
    authors: str

    def cells_across(self, cell: float) -> float:
        """Cells of side `cell` (mm) along the diameter."""
        return 2.0 * self.radius / cell


def first_slide(setup: ProblemSetup, contacts: Sequence[Hertz | None]) -> Slide | None:
    """The first stage at whose end a tangential force or a torque alone exceeds what friction carries."""
    friction = setup.model.friction
    for stage, (load, hertz) in enumerate(zip(setup.load_path.imposed, contacts, strict=True)):
        pressed = load.get("P", hertz.load if hertz is not None else None)
        force = math.hypot(load.get("Qx", 0.0), load.get("Qy", 0.0))
        if pressed is not None and force > 0.0 and force >= friction * pressed:
            component = max(("Qx", "Qy"), key=lambda name: abs(load.get(name, 0.0)))
            return Slide(stage, component, force, friction * pressed, "mu P")
        torque = hertz.torque(friction) if hertz is not None else None
        if torque is not None and abs(load.get("Mz", 0.0)) > torque:
            return Slide(stage, "Mz", abs(load["Mz"]), torque, "3 pi mu P a/16")
    return None


def sliding_displacement(setup: ProblemSetup, circle: HertzContact) -> float | None:
    """The rigid displacement (mm) at which a circular contact begins to slide as a whole, by Cattaneo and Mindlin.

    None where shear changes the pressure, or where there is no friction.
    """
    friction = setup.model.friction
    if not friction or setup.model.coupled:
        return None
    return mindlin_displacement(circle, friction, friction * circle.load, setup.model.compliances.tangential)


def smallest_stick(setup: ProblemSetup, contacts: Sequence[Hertz | None]) -> Stick | None:
    """The smallest stick zone that the path leaves, where a closed form tells; None elsewhere.

    Spence: a sphere pressed on a body that differs, without tangential load. Cattaneo and Mindlin, or Lubkin: a sphere
    under Qx, Qy or Mz alone at constant P, bodies alike; a load that goes to and fro leaves no smaller one.
    """
    circles = [hertz.circle if hertz is not None else None for hertz in contacts]
    if not setup.model.has_shear or not setup.model.friction:
        return None
    moved = {name for load in setup.load_path.imposed for name, value in load.items() if value} & TANGENTIAL
    if not moved:
        return _spence(setup, circles)
    if setup.model.coupled or len(moved) > 1 or _press_changes(setup):
        return None
    (name,) = moved
    if name not in ("Qx", "Qy", "Mz"):
        return None
    path = [abs(load.get(name, 0.0)) for load in setup.load_path.imposed]
    stage = path.index(max(path))
    circle = circles[stage]
    return None if circle is None else _under(setup, circle, name, path[stage], stage)


def _under(setup: ProblemSetup, circle: HertzContact, name: str, load: float, stage: int) -> Stick | None:
    """Under one load below full slip."""
    friction = setup.model.friction
    if name == "Mz":
        try:
            solution = lubkin(circle, friction, load, setup.model.compliances.torsional)
        except ValueError:  # everything slips
            return None
        return Stick(stage, solution.stick_radius, "Lubkin")
    share = load / (friction * circle.load)
    return Stick(stage, circle.contact_radius * math.cbrt(1.0 - share), "Cattaneo, Mindlin") if share < 1.0 else None


def _spence(setup: ProblemSetup, circles: Sequence[HertzContact | None]) -> Stick | None:
    pressed = [(circle.contact_radius, stage) for stage, circle in enumerate(circles) if circle is not None]
    if not setup.model.coupled or not pressed:
        return None
    radius, stage = max(pressed)
    ratio = spence_stick_ratio(setup.model.friction, setup.model.compliances.dundurs_constant)
    return Stick(stage, ratio * radius, "Spence")


def _press_changes(setup: ProblemSetup) -> bool:
    """Whether P changes while or after the contact is sheared."""
    loads = setup.load_path.imposed
    first = next(_sheared(loads))
    normal = [(load.get("P"), load.get("delta_z")) for load in loads[max(first - 1, 0) :]]
    return first == 0 or len(set(normal)) > 1


def _sheared(loads: Sequence[dict[str, float]]) -> Iterator[int]:
    """The stages that end with a tangential load or displacement."""
    return (stage for stage, load in enumerate(loads) if any(load.get(name) for name in TANGENTIAL))
