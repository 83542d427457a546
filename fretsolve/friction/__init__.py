"""Friction that varies: over the contact, with the pressure, with slip, from stage to stage.

In come the friction of a case, a grid, and the fields at the start of an increment; out comes a `FrictionBound`, by
which the solvers get the friction limit of each cell from its pressure. For example::

    law = varied_friction(case)
    bound = law.on(grid).bound(fields)
    limit = bound.limit(pressure)
"""
