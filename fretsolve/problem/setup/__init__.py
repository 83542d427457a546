"""Problem setup: all that is known of a case before it is solved.

In: a `Case`. Out: a `ProblemSetup` with the model, the grid (sized by the loads on demand), the load path and the
closed forms that hold. From it follow the warnings and the estimate of memory and time.

    setup = set_up(load_case("case.yaml")); setup.closed_forms.largest; case_warnings(setup); estimate(setup).memory
"""
