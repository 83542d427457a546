"""The fields of a state, from the solution of its increment and the fields before it."""

from __future__ import annotations

from functools import partial

import numpy as np

from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.increment.increment import Solved
from fretsolve.result.state import Fields, Zone, nothing
from fretsolve.setup.problem_setup import ProblemSetup
from fretsolve.simulation.slip_and_work import limit_to_contact, mean_pressure
from fretsolve.system.arrays import FloatArray, vector_lengths


def unloaded(separation: FloatArray) -> tuple[Fields, FloatArray]:
    """Return fields and displacement before the first increment: the surfaces touch at their nearest points."""
    nearest = np.min(separation, where=np.isfinite(separation), initial=np.inf)
    gap = separation - (nearest if np.isfinite(nearest) else 0.0)
    scalar, vector = nothing(separation.shape), nothing((2, *separation.shape))
    return Fields(scalar, vector, vector, scalar, scalar, np.zeros(separation.shape, np.uint8), gap), vector


def fields_of(
    solved: Solved, before: Fields, setup: ProblemSetup, team: ThreadTeam
) -> tuple[Fields, FloatArray, float]:
    """Return fields and displacement after an increment, and the energy dissipated in it; team: shares a large grid."""
    slip_path, work_density, work = nothing(setup.grid.shape), nothing(setup.grid.shape), 0.0
    if setup.model.may_slip:
        slip_path, work_density, work = _accumulate(solved, before, setup, team)
    kept = partial(_kept, precision=precision_of(setup))
    friction, limit = _friction_fields(solved, setup)
    fields = Fields(
        pressure=kept(solved.pressure),
        shear=kept(solved.shear),
        slip=kept(solved.slip),
        slip_path=kept(slip_path),
        work_density=kept(work_density),
        zone=solved.zone,
        gap=kept(solved.gap),
        friction=None if friction is None else kept(friction),
        shear_bound=None if limit is None else kept(limit),
    )
    displacement = kept(solved.displacement)
    displacement.flags.writeable = False
    return read_only(fields), displacement, work


def read_only(fields: Fields) -> Fields:
    """Return the fields as arrays that cannot be written to: the next increment starts from these very arrays."""
    for array in vars(fields).values():
        if array is not None:
            array.flags.writeable = False
    return fields


def _friction_fields(solved: Solved, setup: ProblemSetup) -> tuple[FloatArray | None, FloatArray | None]:
    """Return the coefficient of friction and the friction limit (MPa), (nx, ny); None for what is not stored."""
    stored, coefficient, limit = setup.case.output.fields, None, None
    if "friction" in stored:
        coefficient = np.array(np.broadcast_to(solved.friction.coefficient_at(solved.pressure), setup.grid.shape))
    if "shear_bound" in stored:
        limit = solved.friction_limit
    return coefficient, limit


def precision_of(setup: ProblemSetup) -> type[np.floating]:
    """Return the precision of the elastic operator and of the fields of the states."""
    return np.float32 if setup.case.solver.precision == "single" else np.float64


def _kept(field: FloatArray, precision: type[np.floating]) -> FloatArray:
    """Return `field` in the precision of the states; `nothing` stays `nothing`."""
    if not any(field.strides):
        return np.broadcast_to(precision(0.0), field.shape)
    return field.astype(precision, copy=False)


def _accumulate(
    solved: Solved, before: Fields, setup: ProblemSetup, team: ThreadTeam
) -> tuple[FloatArray, FloatArray, float]:
    """Return the slip path and the dissipated energy per area since the start, and the increment's dissipated energy.

    Turns the slip of the increment in `solved` into the slip since the start, in place.
    """
    slip, friction = solved.slip, solved.friction
    modulus, orthotropy = setup.model.compliances.contact_modulus, setup.model.orthotropy
    parted = limit_to_contact(slip, before, solved, setup.grid, modulus)
    slip_path, work_density = np.empty(parted.shape), np.empty(parted.shape)

    def accumulate(rows: slice) -> float:
        """Fill some rows, and return the sum of their energy per area in the increment."""
        moved, mean = slip[:, rows], mean_pressure(before.pressure[rows], solved.pressure[rows])
        length = vector_lengths(moved)
        energy = friction.part(rows).limit(mean)
        energy *= length if orthotropy is None else vector_lengths(orthotropy.times(moved))
        # The slip of a sticking cell is the certificate's residual, not slip.
        energy *= (solved.zone[rows] == Zone.SLIP) | parted[rows]
        np.add(length, before.slip_path[rows], out=slip_path[rows])
        np.add(energy, before.work_density[rows], out=work_density[rows])
        moved += before.slip[:, rows]
        return float(energy.sum())

    work = sum(team.of_rows(parted.shape, accumulate)) * setup.grid.cell_area
    return slip_path, work_density, work
