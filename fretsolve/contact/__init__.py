"""Contact with friction: a start and what is imposed come in, certified tractions and zones go out.

`increment` solves and certifies one increment by the `solvers`, whose passes over all cells are the `kernels`; `zones`
measures the contact and the stick zone. One call is ``IncrementSolver(grid, separation, model, ...).solve(increment,
start)``.
"""
