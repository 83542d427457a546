"""Solvers of the contact problem on one grid, for one increment.

In: an `ElasticOperator`, what is imposed (`LoadControl`), and a first estimate of pressure or shear. Out: the estimate,
solved in place, and a `SolverResult`. `NormalSolver` and `TangentialSolver` solve one problem at the other's traction,
`CoupledNewton` solves both at once, and `load_factor` finds the load of gross slip. For example::

    result = NormalSolver(operator, grid).solve(separation, control, pressure, 1e-6, 1000, np.zeros(3))
"""
