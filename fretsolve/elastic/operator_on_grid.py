"""Choose the elastic operator of a grid."""

from __future__ import annotations

import numpy as np

from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.model.grid import Grid, LineGrid
from fretsolve.model.materials import Compliances
from fretsolve.model.required_terms import Terms


def operator_on(
    grid: Grid,
    compliances: Compliances,
    terms: Terms,
    team: ThreadTeam | None = None,
    dtype: type[np.floating] = np.float64,
) -> ElasticOperator:
    """Return the elastic operator on a grid, of strips or of rectangles."""
    if isinstance(grid, LineGrid):
        from fretsolve.elastic.line_operator import LineOperator  # other cases need none of it

        return LineOperator(grid, compliances, terms, team, dtype)
    return ElasticOperator(grid.shape, (grid.dx, grid.dy), compliances, terms, team, dtype)
