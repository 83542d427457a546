"""Stress in an elastic half-space under tractions on rectangular cells, as functions of arrays.

In come tractions, out come the six components of stress at a depth or at a point. For example::

    stress = point_influence(grid, (x, y, depth), nu, body=2).stress({"p": pressure, "qx": qx, "qy": qy})
"""
