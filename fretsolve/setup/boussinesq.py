"""What Boussinesq's theory says of a case, where it applies: a single flat round punch, sharp and not tilted."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fretsolve.reference.closed_forms import FlatPunch, boussinesq_punch

if TYPE_CHECKING:
    from fretsolve.setup.problem_setup import ProblemSetup


def punch_contact(setup: ProblemSetup) -> FlatPunch | None:
    """The punch where it is pressed hardest, by P or delta_z; None where the theory does not apply or nothing presses.

    Frictionless; without an edge radius, since a rounded edge carries less than its outline.
    """
    surface, loads = setup.case.surface[0], setup.load_path.imposed
    if len(setup.case.surface) > 1 or surface.kind != "punch" or surface.radius is None or surface.edge_radius:
        return None
    if any(load.get(name) for load in loads for name in ("Mx", "My", "phi_x", "phi_y")):
        return None
    radius, modulus = surface.radius, setup.model.compliances.contact_modulus
    stiffness = 1.0 / boussinesq_punch(1.0, radius, modulus).delta_z
    pressed = max(load["P"] if "P" in load else stiffness * load.get("delta_z", 0.0) for load in loads)
    return boussinesq_punch(pressed, radius, modulus) if pressed > 0.0 else None
