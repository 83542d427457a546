"""Truth by refinement: the run of a fine problem, and what half of its increments say of the error left in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import fretsolve
from fretsolve.model.edges import rounding
from fretsolve.result.state import CORRECTED
from fretsolve.setup.problem_setup import ProblemSetup
from fretsolve.simulation.error_bars.coarse_runs import FIRST_ORDER

Row = Mapping[str, float]

CELLS_ON_EDGE = 4.0
"""Cells of a fine run on the radius of an edge, at least, for its largest pressure to be a truth."""


def corrected_run(setup: ProblemSetup) -> list[Row]:
    """Return the values of each increment; where the slip depends on the path, 2 Q_m - Q_(m/2) for what is corrected.

    The energy of the first stage is corrected by its own order. The first, the third and so on of the increments keep
    their values as run; all do if a stage has an odd number.
    """
    rows: list[Row] = [vars(state.summary) for state in fretsolve.run(setup)]
    counts = setup.load_path.counts
    if not setup.load_path.path_dependent or any(count % 2 for count in counts):
        return rows
    half = replace(setup, load_path=setup.load_path.with_counts(tuple(count // 2 for count in counts)))
    coarse = [vars(state.summary) for state in fretsolve.run(half)]
    energy = 0.0  # that the first stage has too much, by its order rather than by the first
    for place, row in enumerate(coarse):
        fine = 2 * place + 1  # all stages are halved
        if fine < counts[0]:
            energy = (rows[fine]["work_total"] - row["work_total"]) * (1.0 / (2.0**FIRST_ORDER - 1.0) - 1.0)
        corrected = {name: 2.0 * rows[fine][name] - row[name] for name in CORRECTED}
        rows[fine] = {**rows[fine], **corrected, "work_total": corrected["work_total"] + energy}
    return rows


def knows_peak(fine: ProblemSetup) -> bool:
    """Return whether the largest pressure of a fine run is one: no tip, sharp edge or rounding of few of its cells."""
    surfaces, side = fine.case.surface, max(fine.grid.dx, fine.grid.dy)
    radii = [0.0 if surface.kind == "cone" else rounding(surface) for surface in surfaces]
    return all(radius is None or radius >= CELLS_ON_EDGE * side for radius in radii)
