"""Sweeps: one case at many points of its keys.

In: a sweep file (`sweep_file`) and the case it names. Out: a folder with the manifest, one result per case, and a
table of all of them. The engines share nothing but these files::

    plan = make_sweep_plan(Path("map.yaml"), Path("map.sweep"))
    write_manifest(plan.manifest)
    reports = list(run_cases(plan.manifest, plan.manifest.unique, jobs=2, stop=stop))
    table = collect(plan.manifest)
"""

MOST_CASES = 1_000_000
