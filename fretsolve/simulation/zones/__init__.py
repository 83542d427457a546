"""The zones of one increment: edges, areas and extents of the contact and of its stick zone, to a part of a cell.

`area_contact` and `line_contact` solve an increment and measure its zones by the other modules. With compiled kernels,
`compiled_sizes` replaces the edges of an area.
"""
