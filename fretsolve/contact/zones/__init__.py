"""The zones of one increment: edges, areas and extents of the contact and of its stick zone, to a part of a cell.

`area_contact` and `line_contact` measure the zones of an increment. `zone_cells` finds the links between cells that
edges cross, and `edge_law` places the edges on the links. All zones of an increment are measured at once, since the
calls of NumPy take the time.
"""
