"""Engines: where the cases of a sweep run.

In: a manifest and the rows to run. Out: result files, and a `Report` per case as it ends. `worker_pool` starts
processes on this machine, `dask` does so on the workers of a cluster, `slurm` submits a job array whose tasks call
``fretsolve sweep work``::

    reports = list(run_cases(manifest, manifest.unique, jobs=2, stop=stop))
"""
