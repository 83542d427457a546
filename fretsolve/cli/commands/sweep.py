"""``fretsolve sweep``: run a case at many points, on this machine or on a cluster, and collect the results."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path

from fretsolve.cli.case_messages import CaseMessages, none_solved
from fretsolve.cli.commands.plot import picture_format, require_matplotlib, write_picture
from fretsolve.errors import CaseError, PictureError, printable
from fretsolve.post.plots.sheet import Sheet
from fretsolve.sweep.beginnings import remove_beginnings
from fretsolve.sweep.manifest import (
    CaseState,
    Manifest,
    ManifestRow,
    RunReport,
    counted,
    index_list,
    read_manifest,
    require_no_link,
    require_own,
    state_of,
    states,
    write_manifest,
)
from fretsolve.sweep.plan import make_sweep_plan
from fretsolve.sweep.quantity import ALL_NAMES, plain, read_quantity
from fretsolve.sweep.seeds import seed_keys, seeds_path, write_seeds_csv
from fretsolve.sweep.slurm import requeue, submit
from fretsolve.sweep.study.assessment import HDF5_NAME
from fretsolve.sweep.table import collect, require_tables, writer_of
from fretsolve.system import atomic_files
from fretsolve.system.environment import processors
from fretsolve.system.files import require_free
from fretsolve.system.progress import print_error_line
from fretsolve.system.signals import EXIT_STOPPED, StopRequest


def run_sweep(
    sweep: Path, out: Path | None, jobs: int | None, engine: str, stop: StopRequest, *, dry: bool = False, quiet: bool
) -> int:
    """Check the sweep, write its manifest and run what is missing. Return the exit code.

    out: a folder, None for the file's name with .sweep; jobs: how many cases at a time, None for one per core; dry:
    with Slurm, submit nothing.
    """
    folder = out or sweep.with_suffix(".sweep")
    if (folder / HDF5_NAME).exists():
        raise CaseError("holds a study; give another folder with -o", (), folder)
    require_own(folder, sweep)
    plan = make_sweep_plan(sweep, folder)
    stop.idle = False
    write_manifest(plan.manifest)
    todo = plan.manifest.missing()
    messages = CaseMessages(plan.manifest, todo, quiet=quiet)
    messages.start(sweep, folder, plan.warnings)
    if todo and engine == "slurm":
        told = submit(plan, todo, jobs, dry=dry)
        if dry or not quiet:
            print(told, flush=True)
        return 0
    reports = _shown(_run(plan.manifest, todo, jobs, engine, stop), messages) if todo else []
    return _conclude(sweep, messages, reports, stop)


def _run(
    manifest: Manifest, todo: Sequence[ManifestRow], jobs: int | None, engine: str, stop: StopRequest
) -> Iterator[RunReport]:
    # The engines load pebble or Dask, which planning, Slurm, collecting and drawing do without.
    from fretsolve.sweep.worker_pool import in_rounds, run_cases

    if engine.startswith("dask:"):
        from fretsolve.sweep.dask import run_on_dask

        return run_on_dask(manifest, todo, engine.removeprefix("dask:"), stop, print_error_line)
    at_once = jobs or max(1, processors() // manifest.threads)

    def run(left: list[ManifestRow]) -> Iterator[RunReport]:
        return run_cases(manifest, (row for row in left if not manifest.is_taken(row)), at_once, stop)

    return in_rounds(manifest, todo, stop, print_error_line, run)


def work(folder: Path, indices: Sequence[int], stop: StopRequest, *, requeued: bool = False) -> int:
    """Run the cases `indices` that have no result, one after another; for job scripts of any scheduler.

    requeued: have Slurm run this task again if a signal stops it, unless it has saved nothing.
    """
    from fretsolve.sweep.worker_pool import run_cases  # on demand, as in `_run`

    manifest = read_manifest(folder)
    require_no_link(folder)
    last = len(manifest.rows) - 1
    if max(indices) > last:
        raise CaseError(f"--cases {index_list(indices)}: there are the cases 0 to {last}", (), folder)
    rows = [manifest.rows[index] for index in indices]
    todo = manifest.missing({row.id: row for row in rows}.values())
    before = _progress(manifest, todo)
    reports = _shown(run_cases(manifest, todo, 1, stop), CaseMessages(manifest, todo))
    if not stop.requested or not manifest.missing(todo):
        return _worst_code(report.code for report in reports if not report.has_result and not report.busy)
    if requeued and _progress(manifest, todo) == before:
        print_error_line("no increment was saved before the signal: not requeued; more time is needed")
    elif requeued:
        requeue()
    return EXIT_STOPPED


def _progress(manifest: Manifest, rows: Sequence[ManifestRow]) -> list[tuple[bool, int]]:
    """Return what there is of each case: whether it has a result, and how many increments are saved."""
    return [(state.has_result, state.increments) for state in (state_of(manifest, row) for row in rows)]


def _worst_code(found: Iterable[int]) -> int:
    codes = set(found)
    return max(codes - {EXIT_STOPPED}, default=EXIT_STOPPED) if codes else 0


def status(folder: Path) -> int:
    """Print how far a sweep is."""
    manifest = read_manifest(folder)
    found = list(states(manifest))
    print(printable(f"{manifest.title}: {counted(found)}"))
    ended = [one for name in ("error", "no solution") for one in found if one.status == name]
    most = 20
    for one in ended[:most]:
        reason = f"{one.row.words}: {one.status} (exit code {one.exit_code}): {one.reason}"
        print(f"{one.row.index}: {printable(reason)}")
    if len(ended) > most:
        print(f"and {len(ended) - most} more such cases; sweep collect has the reasons of all")
    left = [one.row.index for one in found if not one.has_result and one.status != "running"]
    if left:
        print(f"missing: --array={index_list(left)}")
    return 0


def _shown(reports: Iterable[RunReport], messages: CaseMessages) -> list[RunReport]:
    """Print each report as it comes, and what is wrong with it; return all of them."""
    found = []
    for report in reports:
        row = messages.manifest.rows[report.index]
        values = {"case": report.index, "exit_code": report.code, "increments": report.increments}
        messages.case(row.id, **values, wall_time=f"{report.seconds:.3g}")
        if report.reason and not report.has_result:
            print_error_line(f"case {report.index}: {row.words}: {report.reason}")
        messages.warn(messages.manifest.result(row), report.notes)
        found.append(report)
    return found


def _conclude(sweep: Path, messages: CaseMessages, reports: Sequence[RunReport], stop: StopRequest) -> int:
    """Print how the sweep ended, by `reports` or else by the files.

    Return 0 if every case has a result, else the code of the worst. Raises NoSolutionError if no case has a solution.
    """
    manifest = messages.manifest
    found = list(states(manifest, reports))
    _name_damaged(manifest, found)
    messages.end(found)
    if not manifest.missing():
        remove_beginnings(manifest.folder)
    code = _worst_code(one.exit_code or EXIT_STOPPED for one in found if not one.has_result)
    if code:
        return EXIT_STOPPED if stop.requested else code
    if all(one.status == "no solution" for one in found):
        raise none_solved(sweep, found[0].reason)
    return 0


def _name_damaged(manifest: Manifest, found: Iterable[CaseState]) -> None:
    """Print the cases whose results cannot be read."""
    for one in found:
        if one.status == "error" and manifest.is_finished(one.row):
            print_error_line(f"case {one.row.index}: {one.reason}; remove it to run the case again")


def collect_sweep(folder: Path, out: Path | None, quantities: Sequence[str], *, fields: bool, overwrite: bool) -> int:
    """Write the table of what there is by now; by default as CSV and HDF5 in the folder, which are the sweep's own.

    Where seeds vary, their means and scatter are written beside it.
    """
    manifest = read_manifest(folder)
    own = {folder / "table.csv": False, folder / "table.h5": fields}
    exclusive = out is not None and not overwrite
    chosen = {out: fields} if out else own
    writers = {path: writer_of(path, fields=linked, exclusive=exclusive) for path, linked in chosen.items()}
    seeds = seeds_path(next(iter(chosen))) if seed_keys(manifest) else None
    if out is not None:
        require_free(out, *([seeds] if seeds else []), overwrite=overwrite)
    else:
        require_tables([*own, *([seeds] if seeds else [])])
    table = collect(manifest, quantities)
    if seeds is not None:
        writers[seeds] = partial(write_seeds_csv, seeds, exclusive=exclusive)
    with atomic_files.all_or_none() as making:
        for path, write in writers.items():
            with making(path):
                write(table)
    print(*writers, sep="\n")
    _name_damaged(manifest, table.states)
    print(counted(table.states), flush=True)
    return 0


def plot_sweep(
    folder: Path, kind: str, quantity: str | None, over: tuple[str, ...], out: Path | None, sheet: Sheet
) -> int:
    """Draw a quantity over one or two columns of the collected sweep, or the running condition over two."""
    require_matplotlib()
    from fretsolve.post.plots.canvas import rendered  # matplotlib is optional
    from fretsolve.sweep import plot

    manifest = read_manifest(folder)
    of_condition = kind == "running-condition"
    if quantity is not None and of_condition:
        raise CaseError(f"--quantity has no effect on {kind}; leave it out", (), folder)
    if quantity is not None:
        read_quantity(quantity)
    name = plain(quantity or manifest.quantities[0])
    target = out or folder / f"{kind if of_condition else name}.png"
    file_format = picture_format(target)
    over = tuple(text if text in manifest.keys else plain(text) for text in over)
    as_quantities = [text for text in over if text not in manifest.keys]
    for text in as_quantities:
        if text.partition("@")[0] not in ALL_NAMES:
            raise CaseError(f"--over {text}: neither a varied key ({', '.join(manifest.keys)}) nor a quantity")
    wanted = dict.fromkeys(
        (*map(plain, manifest.quantities), name, *as_quantities, *(["energy_ratio"] if of_condition else []))
    )
    table = collect(manifest, tuple(wanted))
    keys = plot.independent_keys(table)
    chosen = over or tuple(keys[: 2 if of_condition else 1])
    if len(chosen) not in ((2,) if of_condition else (1, 2)):
        count = "two columns" if of_condition else "one or two columns"
        raise CaseError(f"--over: {kind} is drawn over {count}, such as {' and '.join(keys[:2])}")
    try:
        if len(chosen) == 1:
            figure = plot.curve(table, name, *chosen, sheet)
        else:
            figure = (
                plot.running_condition_map(table, chosen, sheet)
                if of_condition
                else plot.surface(table, name, chosen, sheet)
            )
    except PictureError as error:
        raise CaseError(f"{kind}: {error}", (), folder) from error
    write_picture(target, rendered(figure, file_format, sheet.dpi))
    _name_damaged(manifest, table.states)
    return 0
