"""One increment of the load path: solved by staggered iteration on the active region, certified on all of its grid.

In: what is imposed (`Increment`) and the state at its start (`InitialState`). Out: `Solved`, with the tractions, gap,
slip, zones, certificate and cost; or a `NoSolutionError` that says why there is none. For example::

    solver = IncrementSolver(grid, separation, model, tolerance=1e-6, max_iterations=1000)
    solved = solver.solve(increment, InitialState(pressure, shear, displacement, rigid, friction))
"""
