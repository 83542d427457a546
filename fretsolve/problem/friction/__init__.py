"""Friction: over the contact, with the pressure, with slip, from stage to stage.

In come the friction of a case, a grid, and the fields at the start of an increment; out comes a `FrictionLimit`, from
which the solvers get the friction limit of each cell under its pressure. For example::

    friction = setup.friction_on_grid()
    limit = friction.limit(fields).limit(pressure)
"""
