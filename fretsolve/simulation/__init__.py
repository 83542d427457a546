"""The loop over the increments of a case.

A case goes in, a certified `State` per increment comes out, from a generator that knows no files::

    for state in run(load_case("case.yaml")):
        print(state.summary.delta_z)

`run_to_file.solve_missing` saves such states in a result file; `error_bars` adds error bars to them from coarse runs.
"""
