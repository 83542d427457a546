"""Increments of a case that are mirror images of themselves about y = 0, and so are solved on one half of the grid."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fretsolve.errors import CaseError, FileError
from fretsolve.model.surface import is_mirrored, separation

if TYPE_CHECKING:
    from fretsolve.setup.problem_setup import ProblemSetup

TURNED = {"Mx", "phi_x", "Qy", "delta_y", "Mz", "phi_z", "bulk_1_xy", "bulk_2_xy"}
"""Loads and motions that a mirror image turns round."""

SAMPLED_ROWS = 5
"""Rows of the grid from which `expected_mirrored_increments` takes that the surfaces are mirror images."""


def may_be_mirrored(setup: ProblemSetup) -> bool:
    """Return whether increments of the model may be solved on one half of a grid."""
    return not setup.model.line and setup.model.orthotropy is None and setup.wear is None


def expected_mirrored_increments(setup: ProblemSetup) -> int:
    """Return how many increments are mirror images, from the first one on, at least; as some rows of the grid tell."""
    grid = setup.grid
    if not may_be_mirrored(setup):
        return 0
    rows = np.unique(np.linspace(0, grid.nx - 1, SAMPLED_ROWS).astype(int))
    try:
        if not is_mirrored(grid, separation(setup.case.surface, grid.x[rows], grid.y)):
            return 0
        field = None if setup.friction is None else setup.friction.field
        if field is not None and not is_mirrored(grid, field.at(grid.x[rows], grid.y)):
            return 0
    except (CaseError, FileError):  # a height map that the run refuses with its place in the case
        return 0
    count = 0
    for stage, increments in zip(setup.case.stages(), setup.load_path.counts, strict=True):
        if any(value for name, value in stage.targets if name in TURNED):
            break
        count += increments
    return count


def expected_share_of_cells(setup: ProblemSetup) -> float:
    """Return the part of the grid on which increments are solved, a mean over all of them: from one half to 1."""
    return 1.0 - 0.5 * expected_mirrored_increments(setup) / max(setup.load_path.increments, 1)
