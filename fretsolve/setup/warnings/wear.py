"""Warn of wear without cycles that wear, of slip that is long for the contact, and of a scar beyond the grid."""

from __future__ import annotations

from collections.abc import Iterator

from fretsolve.case.dimensions import percent
from fretsolve.setup.contact_size import AREA_MARGIN, worn_reach
from fretsolve.setup.problem_setup import ProblemSetup


def about_wear(setup: ProblemSetup) -> Iterator[str]:
    """Warn of wear without cycles that wear, of slip that is long for the contact, and of a scar beyond the grid."""
    if setup.case.wear is None:
        return
    from fretsolve.setup.closed_forms.wear_forms import SLIP_PER_RADIUS, worn_cycles  # few cases have wear

    if not any(stage.cycle is not None and stage.cycle.jumps is not None for stage in setup.case.stages()):
        yield (
            "wear: no cycle represents others, so that worn depth is counted and the surfaces keep their shape;"
            " represents in place of times changes them"
        )
        return
    cycles, grid = worn_cycles(setup.closed_forms), setup.grid
    for cycle in cycles:
        if cycle.sliding_distance > SLIP_PER_RADIUS * cycle.hertz.contact_radius:
            yield (
                f"wear: half a cycle slips {cycle.sliding_distance:.3g} mm,"
                f" {percent(cycle.sliding_distance / cycle.hertz.contact_radius)} of the contact radius, but worn"
                f" profiles keep their places on the grid; {percent(SLIP_PER_RADIUS)} or less are needed"
            )
            break
    if setup.case.grid.size is None:
        if not cycles:
            yield "grid.size: auto does not know how far wear widens this contact; a size that leaves room is needed"
        return
    reach = worn_reach(setup.closed_forms)
    if reach > 0.5 * min(grid.size) - 1.5 * max(grid.dx, grid.dy):
        yield (
            f"grid.size: the worn contact may reach {reach:.3g} mm from the grid's middle, to its edge or beyond;"
            f" {2.0 * AREA_MARGIN * reach:.3g} mm would leave room"
        )
