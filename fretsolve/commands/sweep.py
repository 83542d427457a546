"""``fretsolve sweep``: run a case at many points, on this machine or on a cluster, and collect the results."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from fretsolve.commands.plot import picture_format, require_matplotlib, write_picture
from fretsolve.commands.progress import key_value_line
from fretsolve.errors import CaseError, NoSolutionError, PictureError
from fretsolve.sweep.case_run import Report
from fretsolve.sweep.engines.slurm import requeue, submit
from fretsolve.sweep.manifest import Manifest, ManifestRow, index_list, read_manifest, require_own, write_manifest
from fretsolve.sweep.plan import SweepPlan, make_plan
from fretsolve.sweep.quantity import NAMES, read_quantity
from fretsolve.sweep.status import CaseState, counts, is_taken, missing, state_of, states
from fretsolve.sweep.table import collect, writer_of
from fretsolve.system.environment import processors
from fretsolve.system.files import require_free
from fretsolve.system.signals import EXIT_STOPPED, StopRequest

MOST_REASONS = 20
"""Lines on cases that have no result or no solution."""

RUNNING_CONDITION = "running-condition"

CSV_NAME, HDF5_NAME = "table.csv", "table.h5"

SLURM, DASK = "slurm", "dask:"


@dataclass(frozen=True)
class SweepOrder:
    """What the command line asks for. out: a folder, None for the file's name with .sweep; jobs: None for all cores."""

    sweep: Path
    out: Path | None
    jobs: int | None
    engine: str
    quiet: bool

    @property
    def folder(self) -> Path:
        """The folder of manifest, results and tables."""
        return self.out or self.sweep.with_suffix(".sweep")


def run_sweep(order: SweepOrder, stop: StopRequest) -> int:
    """Check the sweep, write its manifest and run what is missing. Returns the exit code."""
    require_own(order.folder, order.sweep)
    plan = make_plan(order.sweep, order.folder)
    stop.idle = False
    write_manifest(plan.manifest)
    todo = missing(plan.manifest)
    _introduce(order, plan, todo)
    reports: list[Report] = []
    if todo and order.engine == SLURM:
        told = submit(plan, todo, order.jobs)
        if not order.quiet:
            print(told, flush=True)
        return 0
    if todo:
        reports += _shown(_run(order, plan.manifest, todo, stop), len(todo), plan.manifest, quiet=order.quiet)
    return _conclude(order, plan.manifest, reports, stop)


def _run(order: SweepOrder, manifest: Manifest, todo: Sequence[ManifestRow], stop: StopRequest) -> Iterator[Report]:
    from fretsolve.sweep.engines.worker_pool import in_rounds, run_cases

    if order.engine.startswith(DASK):
        from fretsolve.sweep.engines.dask import run_on_dask

        return run_on_dask(manifest, todo, order.engine.removeprefix(DASK), stop, _warn)
    jobs = order.jobs or max(1, processors() // manifest.threads)

    def run(left: list[ManifestRow]) -> Iterator[Report]:
        return run_cases(manifest, (row for row in left if not is_taken(manifest, row)), jobs, stop)

    return in_rounds(manifest, todo, stop, _warn, run)


def work(folder: Path, indices: Sequence[int], stop: StopRequest, *, requeued: bool = False) -> int:
    """Run those of the cases `indices` that have no result, one after another; for job scripts of any scheduler.

    requeued: have Slurm run this task again if a signal stops it, unless it has saved nothing.
    """
    from fretsolve.sweep.engines.worker_pool import run_cases

    manifest = read_manifest(folder)
    rows = [manifest.rows[index] for index in indices if index < len(manifest.rows)]
    if not rows:
        last = len(manifest.rows) - 1
        raise CaseError(f"--cases {index_list(indices)}: there are the cases 0 to {last}", (), folder)
    todo = missing(manifest, {row.id: row for row in rows}.values())
    before = _progress(manifest, todo)
    reports = list(_shown(run_cases(manifest, todo, 1, stop), len(todo), manifest))
    if not stop.requested or not missing(manifest, todo):
        return worst(reports)
    if requeued and _progress(manifest, todo) == before:
        print("no increment was saved before the signal: not requeued; more time is needed", file=sys.stderr)
    elif requeued:
        requeue()
    return EXIT_STOPPED


def _progress(manifest: Manifest, rows: Sequence[ManifestRow]) -> list[tuple[bool, int]]:
    """Return what there is of each case: whether it has a result, and how many increments are saved."""
    return [(state.has_result, state.increments) for state in (state_of(manifest, row) for row in rows)]


def worst(reports: Iterable[Report]) -> int:
    """Return the exit code of several cases: 0 if each has a result or is run elsewhere, else that of the worst."""
    return _worst_code(report.code for report in reports if not report.has_result and not report.busy)


def _worst_code(found: Iterable[int]) -> int:
    codes = set(found)
    return max(codes - {EXIT_STOPPED}, default=EXIT_STOPPED) if codes else 0


def status(folder: Path) -> int:
    """Print how far a sweep is."""
    manifest = read_manifest(folder)
    found = list(states(manifest))
    print(f"{manifest.title}: {_counted(found)}")
    ended = sorted(
        (one for one in found if one.status in ("error", "no solution")), key=lambda one: one.status != "error"
    )
    for one in ended[:MOST_REASONS]:
        print(f"{one.row.index}: {one.row.words}: {one.status} (exit code {one.exit_code}): {one.reason}")
    if len(ended) > MOST_REASONS:
        print(f"and {len(ended) - MOST_REASONS} more such cases; sweep collect has the reasons of all")
    left = [one.row.index for one in found if not one.has_result and one.status != "running"]
    if left:
        print(f"missing: --array={index_list(left)}")
    return 0


def _counted(found: Sequence[CaseState]) -> str:
    parts = ", ".join(f"{number} {name}" for name, number in counts(found).items())
    return f"{len(found)} case{'s' if len(found) > 1 else ''}: {parts}"


def _introduce(order: SweepOrder, plan: SweepPlan, todo: Sequence[ManifestRow]) -> None:
    manifest = plan.manifest
    for text in plan.warnings:
        _warn(f"{order.sweep}: warning: {text}")
    if order.quiet:
        return
    count, unique = len(manifest.rows), len(manifest.unique)
    equal = f", {unique} of them different" if unique < count else ""
    there = f", {unique - len(todo)} done already" if len(todo) < unique else ""
    print(manifest.title)
    print(f"results: {order.folder}")
    print(f"{count} case{'s' if count > 1 else ''} of {', '.join(manifest.keys)}{equal}{there}", flush=True)


def _warn(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def _shown(reports: Iterable[Report], count: int, manifest: Manifest, *, quiet: bool = False) -> Iterable[Report]:
    """Print each report as it comes, as a line of ``key=value``, and what is wrong with it; quiet: only the latter."""
    for number, report in enumerate(reports, start=1):
        if not quiet:
            key_value_line(
                case=report.index,
                run=number,
                runs=count,
                exit_code=report.code,
                increments=report.increments,
                wall_time=f"{report.seconds:.3g}",
            )
        if report.reason and not report.has_result:
            _warn(f"case {report.index}: {manifest.rows[report.index].words}: {report.reason}")
        yield report


def _conclude(order: SweepOrder, manifest: Manifest, reports: Sequence[Report], stop: StopRequest) -> int:
    """Print how the sweep ended, by `reports` or else by the files.

    Returns 0 if every case has a result, else the code of the worst. Raises NoSolutionError if no case has a solution.
    """
    found = list(states(manifest, reports))
    for one in found:
        if one.status == "error" and manifest.result(one.row).exists():
            _warn(f"case {one.row.index}: {one.reason}; remove it to run the case again")
    if not order.quiet:
        print(_counted(found), flush=True)
        if missing(manifest):
            _warn("the same command goes on with what is missing")
    code = _worst_code(one.exit_code or EXIT_STOPPED for one in found if not one.has_result)
    if code:
        return EXIT_STOPPED if stop.requested else code
    if all(one.status == "no solution" for one in found):
        error = NoSolutionError(f"none of the cases has a solution: {found[0].reason}")
        error.file = order.sweep
        raise error
    return 0


def collect_sweep(folder: Path, out: Path | None, quantities: Sequence[str], *, fields: bool, overwrite: bool) -> int:
    """Write the table of what there is by now; by default as CSV and HDF5 in the folder, which are the sweep's own."""
    manifest = read_manifest(folder)
    for text in quantities:
        read_quantity(text)
    if out is not None:
        writers = {out: writer_of(out, fields=fields)}
        require_free(out, overwrite=overwrite)
    else:
        tables = folder / CSV_NAME, folder / HDF5_NAME
        writers = {path: writer_of(path, fields=fields and path.name == HDF5_NAME) for path in tables}
    table = collect(manifest, quantities)
    for path, write in writers.items():
        write(table)
        print(path)
    print(_counted(table.states), flush=True)
    return 0


def plot_sweep(folder: Path, kind: str, quantity: str | None, over: tuple[str, ...], out: Path | None) -> int:
    """Draw a quantity over one or two columns of the collected sweep, or the running condition over two."""
    require_matplotlib()
    from fretsolve.plots.canvas import rendered
    from fretsolve.sweep import plot

    manifest = read_manifest(folder)
    if quantity is not None:
        read_quantity(quantity)
    name = quantity or manifest.quantities[0]
    target = out or folder / f"{kind if kind == RUNNING_CONDITION else name}.png"
    file_format = picture_format(target)
    as_quantities = [text for text in over if text not in manifest.keys]
    for text in as_quantities:
        if text.partition("@")[0] not in NAMES:
            raise CaseError(f"--over {text}: neither a varied key ({', '.join(manifest.keys)}) nor a quantity")
    table = collect(manifest, (*manifest.quantities, name, *as_quantities))
    chosen = over or manifest.keys[: 2 if kind == RUNNING_CONDITION else 1]
    if len(chosen) > 2 or (kind == RUNNING_CONDITION and len(chosen) != 2):
        count = "two columns" if kind == RUNNING_CONDITION else "one or two columns"
        raise CaseError(f"--over: {kind} is drawn over {count}, such as {' and '.join(manifest.keys[:2])}")
    try:
        if kind == RUNNING_CONDITION:
            figure = plot.running_condition(table, (chosen[0], chosen[1]))
        elif len(chosen) == 2:
            figure = plot.surface(table, name, (chosen[0], chosen[1]))
        else:
            figure = plot.curve(table, name, chosen[0])
    except PictureError as error:
        raise CaseError(f"{kind}: {error}", (), folder) from error
    write_picture(target, rendered(figure, file_format))
    return 0
