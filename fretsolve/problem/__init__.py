"""What is to be solved: a case comes in; model, grid, surfaces, friction, load path and warnings go out.

One call is ``set_up(case)`` of `fretsolve.simulation.problem_setup`, which returns a `ProblemSetup`.
"""
