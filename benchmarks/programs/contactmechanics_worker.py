"""The base case solved by ContactMechanics: Polonsky and Keer's conjugate gradients on a free half-space."""

from __future__ import annotations

import sys
from importlib.metadata import version

from ContactMechanics import FreeFFTElasticHalfSpace
from ContactMechanics.Systems import NonSmoothContactSystem
from SurfaceTopography import Topography
from task import Answer, normal_contact, read_task, timed


def main() -> None:
    """Solve and answer."""
    task = read_task()
    grid, sizes = (task.points, task.points), (task.size, task.size)
    substrate = FreeFFTElasticHalfSpace(grid, task.contact_modulus, sizes, check_boundaries=True)
    system = NonSmoothContactSystem(substrate, Topography(-task.separation(), sizes))
    seconds, result = timed(
        lambda: system.minimize_proxy(external_force=task.load, pentol=task.tolerance * task.delta_z), task.repeats
    )
    if not result.success:
        sys.exit(f"not converged: {result.message}")
    displacement = substrate.evaluate_disp(-result.jac)  # compression is positive in the result, negative elsewhere
    found = normal_contact(task, result.jac / task.cell**2, displacement)
    Answer(version("ContactMechanics"), seconds, **found, iterations=result.nit, applications=result.nfev).send()


if __name__ == "__main__":
    main()
