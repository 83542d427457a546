"""Choose the elastic operator of a grid."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.model.grid import Grid, HalfGrid, LineGrid
from fretsolve.model.materials import Compliances
from fretsolve.model.required_terms import Terms

if TYPE_CHECKING:
    from fretsolve.model.materials import Orthotropy


def operator_on(
    grid: Grid,
    compliances: Compliances,
    terms: Terms,
    team: ThreadTeam | None = None,
    dtype: type[np.floating] = np.float64,
    orthotropy: Orthotropy | None = None,
    whole: ElasticOperator | None = None,
) -> ElasticOperator:
    """Return the elastic operator on a grid, of strips, of rectangles, or of rectangles and their mirror images.

    orthotropy: scales shear and slip; whole: as for `ElasticOperator`.
    """
    if isinstance(grid, LineGrid):
        from fretsolve.elastic.line_operator import LineOperator  # other cases need none of it

        return LineOperator(grid, compliances, terms, team, dtype)
    if orthotropy is not None:
        from fretsolve.elastic.orthotropic_operator import OrthotropicOperator

        return OrthotropicOperator(orthotropy, grid.shape, (grid.dx, grid.dy), compliances, terms, team, dtype)
    if isinstance(grid, HalfGrid):
        from fretsolve.elastic.mirrored.operator import MirroredOperator

        return MirroredOperator(grid.shape, (grid.dx, grid.dy), compliances, terms, team, dtype, whole=whole)
    return ElasticOperator(grid.shape, (grid.dx, grid.dy), compliances, terms, team, dtype, whole=whole)
