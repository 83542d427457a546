"""Studies: a sweep over ``--vary`` whose results are compared with a reference and weighed against their cost.

In: a case and the varied keys. Out: one result per case, and an `Assessment` as a table, files and a picture::

    plan = make_study_plan(StudyRequest(Path("case.yaml"), (), ["grid.points=32,64"], (), "finest"), Path("case.study"))
    reports = list(run_serially(plan.cases, stop))
    study = assess(plan, [read_outcome(case.out, plan.quantities) for case in plan.cases])
    write_study_csv(Path("study.csv"), study)
"""
