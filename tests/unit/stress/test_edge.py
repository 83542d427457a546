"""Where the largest stress at the edge is looked for, and what it is extrapolated by."""

import numpy as np

from fretsolve.stress.edge import rises


def test_a_trailing_edge_rises_and_a_leading_one_does_not():
    """Columns: tension that grows with smaller cells, compression that grows, tension whose other parts change more."""
    values = np.array([[100.0, 0.0, 100.0], [0.0, -90.0, 0.0], [0.0, -300.0, 0.0]])
    change = np.array([[20.0, 40.0, 1.0], [5.0, -20.0, 0.0], [0.0, -60.0, 30.0]])
    np.testing.assert_allclose(rises(values, change), [20.0, 0.0, 0.0])
