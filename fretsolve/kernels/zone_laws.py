"""Constants of the laws that place the edges of contact and stick zone inside the cells.

`fretsolve.simulation.zones.edge_shares` explains the laws, and `fretsolve.kernels.zones_numba` has them compiled.
"""

from __future__ import annotations

LEVER, LEVER_ALONG, LEVER_SLANTING, LEVER_MOST = 0.9, 0.58, 0.5, 0.94
"""The lever of a front at an angle t to the cells is LEVER_ALONG + LEVER_SLANTING sin 2t, but no more than LEVER_MOST;
LEVER is used while the angle is unknown."""

INSET = 0.104
"""Inset in cells for the lever LEVER, the same in all directions. Another lever moves the share by a sixth of the
logarithm of their ratio, averaged over the front's places within a cell, which the inset corrects."""

STEEPEST = 2.0
"""Limit of lever E* g over h times the largest pressure behind the front. Smooth fronts have at most 1.6, sharp edges
far more."""

RATIO, RATIO_INSET, TRUST = 0.4245, 0.05, 0.16
"""By the reserve alone the share is r/(1 - RATIO r) less about RATIO_INSET, with r the reserve in the last cell over
that in the one behind. It holds to 2e-4 on a front along the cells (without the inset), to 0.1 on others. It begins to
replace the share by the slip if that is larger by TRUST, and has replaced it at twice that."""

LIKE_A_ROOT = 0.65
"""Farther in, r is at least 0.7 behind a front that has moved into the stick zone, or 0.61 if the front is about to
reach a cell."""

STEEP = 0.72
"""Behind the front of a stick zone that has grown over some increments, r is at most 0.55. One cell farther in it is at
most 0.65, and at least 0.78 behind other fronts."""

GAINED, GAINED_BEYOND = 1.5, 0.12
"""Behind the front of a growing stick zone the reserve goes like s^GAINED, since a singular rate of the shear traction
would exceed the friction limit. So r gives the front's place, which on the discrete grid is GAINED_BEYOND of a link
farther out. For spheres pressed on a dissimilar body, for which Spence's theory is exact, this holds to 0.02 of h on
average, and within 0.03 of that from place to place. In increments smaller than a cell, the slip shows only which cell
the front has reached."""

AT_THE_LIMIT, UNLIKE = 1e-5, 0.1
"""Reserve over the friction limit up to which a sticking cell is at the limit. Then the slip past the front, which goes
like s^(3/2) where the front has moved by some cells, gives its place: on a front along the cells to 0.08 of h. The
cells are counted where the slip of the third cell is farther from that law than the latter part of it."""

HARDLY, OF_THE_WHOLE = 0.02, 0.4
"""The slip past a front since the first load belongs to the reserve, rather than that in the increment, if the inner
cell has not slipped (by HARDLY of the outer one's increment at most), and the slip since then is at least OF_THE_WHOLE
of that in the increment. All of it is half of the increment's where a load has been reversed to its opposite: the
increment's slip has doubled, and the reserve has not, since the first load left a kink in the shear traction at the
same front. By the increment's slip, a stick zone would mostly be smaller by 0.05 to 0.18 of h there. In increments that
move the front by less than a cell, the slip since the first load is all that there is past it."""
