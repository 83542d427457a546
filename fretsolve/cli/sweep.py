"""The command line of sweeps: options only, as in `fretsolve.cli.main`."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import click

from fretsolve.cli.command_line import (
    FILE,
    WholeNumber,
    flag,
    output_option,
    overwrite_option,
    picture_options,
    quiet_option,
    repeatable_option,
)
from fretsolve.post.plots import Sheet
from fretsolve.system.signals import StopRequest


@click.group()
def sweep() -> None:
    """Run a case over many values of its keys.

    On this machine or on a cluster; see docs/howto/sweeps.md.
    """


def _engine(context: click.Context, parameter: click.Parameter, value: str) -> str:
    if value in ("local", "slurm") or re.fullmatch(r"dask:\S+", value):
        return value
    raise click.BadParameter(f"{value!r} is not an engine; local, slurm or dask:ADDRESS is needed")


def _indices(context: click.Context, parameter: click.Parameter, value: str) -> list[int]:
    """Read numbers from a text such as ``3,7-9``."""
    from fretsolve.sweep import MOST_CASES

    found: list[int] = []
    for part in value.split(","):
        match = re.fullmatch(r"\s*(\d{1,9})(?:-(\d{1,9}))?\s*", part)
        if match is None:
            raise click.BadParameter(f"{value!r} is not a list of cases; one such as 3,7-9 is needed")
        first, last = int(match[1]), int(match[2] or match[1])
        if not 0 <= last - first < MOST_CASES:
            raise click.BadParameter(f"{part.strip()!r} is not a range of cases; one such as 7-9 is needed")
        found += range(first, last + 1)
    return found


_FOLDER = click.argument("folder", type=FILE, metavar="DIR")


@sweep.command("run")
@click.argument("file", type=FILE, metavar="SWEEP")
@output_option("The folder of manifest and results; by default SWEEP with .sweep.", "DIR")
@click.option("-j", "--jobs", type=WholeNumber(1, 1024), metavar="N", help="Cases at a time; by default one per core.")
@click.option(
    "--on",
    "engine",
    callback=_engine,
    default="local",
    show_default=True,
    metavar="ENGINE",
    help="Where to run: local, slurm, or dask:ADDRESS of a Dask scheduler.",
)
@flag("--dry-run", "dry", help="With slurm: write the job script and print how to submit it, without Slurm.")
@quiet_option
def run(file: Path, out: Path | None, jobs: int | None, engine: str, dry: bool, quiet: bool) -> int:
    """Run the cases of SWEEP that have no result yet.

    All cases are checked before the first one runs. Whatever ends a sweep, the same command continues it, on any
    engine. The exit code is 0 if every case has a result; "no solution" is a result as well.

    The `quantities` of SWEEP are columns of the history or of the table of cycles, such as delta_x@2 and energy_ratio,
    and what files beside the results have: max_mises, max_tension, max_tresca (output.stress), largest fatigue
    parameters and shortest lives such as findley_max, swt_life (output.fatigue), crack_arrest_length and crack_life
    (output.crack). A life of inf is a run-out.
    """
    if dry and engine != "slurm":
        raise click.UsageError("--dry-run goes with --on slurm; `fretsolve validate` tells what a case would take.")
    notice = "stopping after the current increments; a second signal stops this command at once"
    at_once = "stopped; its processes stop after their increments, then the same command continues the sweep"
    with StopRequest(notice, at_once=at_once, idle=True) as stop:
        from fretsolve.cli.commands.sweep import run_sweep

        return run_sweep(file, out, jobs, engine, stop, dry=dry, quiet=quiet)


@sweep.command()
@_FOLDER
@click.option(
    "--cases", "indices", required=True, callback=_indices, metavar="LIST", help="Numbers of the cases, such as 3,7-9."
)
@flag("--requeue", "requeued", help="Under Slurm: queue the job again after a signal.")
def work(folder: Path, indices: list[int], requeued: bool) -> int:
    """Run some cases of a sweep one after another.

    For job scripts of any scheduler. DIR is the folder of the sweep.
    """
    with StopRequest() as stop:
        from fretsolve.cli.commands.sweep import work

        return work(folder, indices, stop, requeued=requeued)


@sweep.command()
@_FOLDER
def status(folder: Path) -> int:
    """Print which cases of the sweep in DIR are done, failed or missing.

    For failed cases it prints the reasons.
    """
    from fretsolve.cli.commands.sweep import status

    return status(folder)


@sweep.command()
@_FOLDER
@output_option("A name ending in .csv, .h5 or .parquet; by default table.csv and table.h5 in DIR.", "FILE")
@repeatable_option(
    "--quantity",
    "quantities",
    "NAME[@STAGE]",
    "A quantity to collect, at the end of a stage (by default the last); see `sweep run --help`. By default: what the"
    " sweep file names.",
)
@flag("--fields", help="Link every result in the HDF5 file, as results/ID.")
@overwrite_option("an existing FILE")
def collect(folder: Path, out: Path | None, quantities: tuple[str, ...], fields: bool, overwrite: bool) -> int:
    """Collect settings and results of the sweep in DIR into one table.

    It has error bars where the results have them. The tables in DIR belong to the sweep and are written anew each time.
    """
    from fretsolve.cli.commands.sweep import collect_sweep

    return collect_sweep(folder, out, quantities, fields=fields, overwrite=overwrite)


@sweep.command()
@_FOLDER
@click.argument("kind", type=click.Choice(["quantity", "running-condition"]), default="quantity", metavar="[KIND]")
@click.option(
    "--quantity",
    metavar="NAME[@STAGE]",
    help="What to draw; by default the first that is collected. Run-outs are arrows.",
)
@repeatable_option(
    "--over",
    "over",
    "KEY",
    "A varied key or a quantity along an axis; two of them give a map. By default the first keys of the sweep.",
)
@output_option("The picture (.png, .pdf, .svg); by default DIR/QUANTITY.png or DIR/running-condition.png.", "FILE")
@picture_options
def plot(folder: Path, kind: str, quantity: str | None, over: tuple[str, ...], out: Path | None, **look: Any) -> int:
    """Draw the sweep in DIR as far as it is.

    KIND is quantity (the default): a quantity over one or two keys; or running-condition: where there is stick, partial
    slip, mixed and gross slip, over two keys, with contours of the energy ratio of cycles. It needs matplotlib: pip
    install '.[plot]' in a clone of fretsolve.
    """
    from fretsolve.cli.commands.sweep import plot_sweep

    return plot_sweep(folder, kind, quantity, over, out, Sheet(**look))
