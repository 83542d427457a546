"""Studies: a sweep over ``--vary`` whose runs are compared with a reference and weighed against their cost.

In: a case and the varied keys. Out: one result per run, and an `Assessment` as a table, files and a picture::

    plan = make_plan(Path("case.yaml"), (), ["grid.points=32,64"], (), "finest", Path("case.study"))
    study = assess(plan, list(make_runs(plan.trials, plan.quantities, stop, show)))
    write_csv(Path("study.csv"), study)
"""
