"""The two elastic half-spaces: displacements of their surfaces from tractions on a grid.

In: a grid of cells, the compliances of the bodies, and the terms to keep. Out: an `ElasticOperator`, which turns
tractions (MPa) into displacements (mm), with its preconditioner and incremental updates. For example::

    ElasticOperator(grid.shape, (grid.dx, grid.dy), model.compliances, model.terms).normal(pressure, uz)
"""
