"""The model that a case describes: materials, required terms, grid, surface and load path.

In: a `Case`. Out: what the solvers need of the case, such as the `Model`, the undeformed separation on a `Grid`, and
the `LoadPath` cut into increments. For example::

    model = derive_model(case)
    path = LoadPath(case.stages(), model)
"""
