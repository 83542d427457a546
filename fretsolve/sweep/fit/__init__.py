"""Find friction, stiffness of the rig and other parameters of a case from a measured loop of force over motion.

In: a case, the loop as CSV, the names of parameters. Out: a `Fit` as a table, a picture and a case file::

    plan = make_fit_plan(FitRequest(Path("case.yaml"), (), Path("loop.csv"), ("friction", "rig.stiffness_x")))
    fit = fit_loop(plan, jobs=1)
    write_fit_csv(Path("loop.fit.csv"), fit)
"""
