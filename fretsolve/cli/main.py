"""Read the options of each command and call its function in `cli.commands`, which has parameters of these names.

Only click is imported here; what a command needs is imported when it is called.
"""

from __future__ import annotations

from contextlib import suppress
from math import isfinite
from pathlib import Path
from typing import Any

import click

from fretsolve import __version__
from fretsolve.case.templates import TEMPLATES
from fretsolve.cli.command_line import (
    FILE,
    CommandLine,
    StepRange,
    WholeNumber,
    error_bars_option,
    flag,
    names_of_list,
    output_option,
    overrides_option,
    overwrite_option,
    pair_of_list,
    picture_options,
    quiet_option,
    repeatable_option,
    result_argument,
    threads_option,
    with_error_bars,
)
from fretsolve.cli.sweep import sweep
from fretsolve.post.export import FORMATS
from fretsolve.post.plots import KINDS, Sheet
from fretsolve.post.plots.kinds import TENSION, Shown
from fretsolve.system.environment import available, processors, quick_imports, set_up_numerics
from fretsolve.system.signals import StopRequest

_CASE = click.argument("case", type=FILE)
_CASES = click.argument("cases", type=FILE, nargs=-1, required=True, metavar="CASE...")
_CYCLE = click.option(
    "--cycle",
    metavar="last|N|all",
    help="The cycle that counts, by default the last one: its number in `fretsolve show`, or each one. A load path"
    " without a cycle counts as one.",
)
_BLOCKS = click.option(
    "--blocks",
    metavar="FILE",
    type=FILE,
    help="A CSV with the heading cycle,times: which cycle of the case stands for how many. The block is repeated, and"
    " damage adds up by Miner's rule.",
)
_BODY = click.Choice(["1", "2"])
_WINDOW = click.option(
    "--window",
    metavar="auto|all|MARGIN",
    default="auto",
    show_default=True,
    help="The cells: the contact with a margin of a quarter of its width, or of one and a half in a line contact; the"
    " whole grid; or the contact with a margin such as 1mm. A margin may reach beyond the grid.",
)


@click.group(cls=CommandLine, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, "-V", "--version", message="fretsolve %(version)s")
def main() -> None:
    """Solve fretting contact: elastic bodies pressed together with friction, sticking and slipping.

    Exit codes: 0 done, 1 a check missed, 2 case or usage error, 3 no solution, 4 a file cannot be read or written,
    70 a bug, 75 stopped by a signal and can be continued.
    """
    set_up_numerics()


main.add_command(sweep)


@main.command()
@_CASE
@output_option("The result file, ending in .h5; by default the name of the case with .h5.")
@overrides_option
@error_bars_option("Estimate the errors of the history from coarse runs (solver.error_bars).")
@flag("--resume", help="Continue a stopped run, or start it.")
@overwrite_option("an existing result")
@threads_option(
    "Threads that share the Fourier transforms; the result does not depend on their number.",
    envvar="SLURM_CPUS_PER_TASK",
    show_envvar=True,
)
@quiet_option
@flag("-v", "--verbose", help="Print stages, settings and the whole history of each increment.")
@flag("--log-json", help="Print one JSON object per line instead, for programs.")
def run(overrides: tuple[str, ...], error_bars: bool, threads: int, **options: Any) -> int:
    """Solve CASE and write the result.

    Increments are saved as they are solved, quick ones a few at a time. Ctrl-C (SIGINT), SIGTERM, SIGUSR1 and a
    closed terminal (SIGHUP) stop the run after the increment under way, a second signal at once. --resume continues it.
    """
    if options["resume"] and options["overwrite"]:
        raise click.UsageError("--resume and --overwrite exclude each other.")
    if options["quiet"] + options["verbose"] + options["log_json"] > 1:
        raise click.UsageError("only one of -q, -v and --log-json is possible.")
    overrides = with_error_bars(overrides, error_bars)
    threads = available(threads)
    with StopRequest() as stop:
        with quick_imports():
            from fretsolve.cli.commands.run import run_case

        return run_case(overrides=overrides, threads=threads, stop=stop, **options)


@main.command()
@_CASES
@overrides_option
@error_bars_option("Show what a run with --error-bars would do (solver.error_bars).")
def validate(overrides: tuple[str, ...], error_bars: bool, **options: Any) -> int:
    """Read each CASE and print what a run would do, without solving.

    It prints all values with their defaults, the model, grid, stages, expected results, memory and cost.
    """
    with quick_imports():
        from fretsolve.cli.commands.validate import validate_cases

    return validate_cases(overrides=with_error_bars(overrides, error_bars), **options)


@main.command()
@click.argument("file", type=FILE)
@repeatable_option("--set", "overrides", "KEY=VALUE", "A key of `heights`, such as unit=um, level=plane or flip=y.")
@flag("--profile", help="The file is a profile along x, as of a line contact.")
@click.option(
    "--plot", "picture", type=FILE, metavar="FILE", help="Draw map, profiles and spectrum (.png, .pdf, .svg)."
)
@picture_options
def surface(width: float | None, title: bool, dpi: int, **options: Any) -> int:
    """Read the measured map FILE and print its size, roughness, tilt and sides, after the steps that --set asks for."""
    from fretsolve.cli.commands.surface import describe_map

    return describe_map(sheet=Sheet(width, title, dpi), **options)


@main.command()
@_CASES
@click.option(
    "--junit",
    type=FILE,
    metavar="FILE.xml",
    help="Also write the outcome as JUnit XML; an earlier FILE.xml of this command is replaced.",
)
@overrides_option
def check(**options: Any) -> int:
    """Solve each CASE, or each case in a folder, in memory and compare with the values it expects.

    All cases are run, those of a folder in the order of their names; its other YAML files, such as sweeps, and its
    folders are named at the end. The exit code is that of the worst outcome: a file cannot be read or written (4), a
    case is wrong (2), there is no solution (3), a value is outside its tolerance (1).
    """
    with quick_imports():
        from fretsolve.cli.commands.check import check_cases

    return check_cases(**options)


@main.command()
@_CASE
@repeatable_option(
    "--vary", "varied", "KEY=A,B,C", "Values of a key; 'stage.*.increments' means every stage.", required=True
)
@output_option("The folder for runs, tables and picture; by default the name of the case with .study.")
@overrides_option
@repeatable_option(
    "--quantity",
    "quantities",
    "NAME[@STAGE]",
    "A quantity to compare, at the end of a stage; without one at the ends of all stages, of a repeated cycle those of"
    " its last repetition; swt_life, crack_life and the like have one value. By default: the responses to the load"
    " path, and what the case expects.",
)
@click.option(
    "--truth",
    "kind",
    type=click.Choice(["finest", "closed-form", "expect"]),
    default="finest",
    show_default=True,
    help="The reference: the finest of the runs, closed forms, or what the case expects.",
)
@flag(
    "--corrected",
    help="Compare values corrected for the number of increments. Costs include the coarse runs that this takes.",
)
@quiet_option
def study(out: Path | None, quiet: bool, **options: Any) -> int:
    """Compare settings of CASE by their errors and costs.

    The error of a quantity is the worst over the ends of the compared stages, relative to the value there. If the
    quantity goes through 0, as a tangential force does, or is 0 there, the error is relative to the largest on the
    path.

    All combinations of the values of --vary are run. The runs are kept in OUT, where later studies reuse them. After an
    interrupt (exit code 75) the same command continues.

    Cases without a solution are reported as failed. The exit code is 0 as long as the reference and one of the cases
    have a result, else 3.
    """
    with StopRequest() as stop:
        from fretsolve.cli.commands.study import study_case

        return study_case(out, stop, quiet=quiet, **options)


@main.command()
@_CASE
@click.option("--loop", type=FILE, metavar="MEASURED.csv", required=True, help="The measured record.")
@click.option(
    "--for",
    "names",
    callback=names_of_list,
    required=True,
    metavar="KEY,...",
    help="What to find, as --set names it: friction, rig.stiffness_x, interface.shear_compliance,"
    " bodies.0.young_modulus. The search starts from the values of the case.",
)
@click.option(
    "--columns",
    callback=pair_of_list,
    metavar="FORCE,MOTION",
    help="The columns with the force and the motion along x, by default Qx and actuator_x, or delta_x without a rig. A"
    " column of another name is the motion of the default; delta_x is the motion of the contact, with a rig as well.",
)
@click.option(
    "--offset/--no-offset", default=True, help="Find offset and drift of force and motion, too, or take none."
)
@output_option("The files without their endings; by default the name of the record with .fit.")
@overrides_option
@click.option(
    "-j", "--jobs", type=WholeNumber(1, 1024), metavar="N", help="Processes for large grids; by default one per core."
)
@quiet_option
def fit(jobs: int | None, **options: Any) -> int:
    """Find friction, stiffness of the rig and the like, with which CASE follows a measured loop of force over motion.

    The record is a CSV with the units in its headings, as `fretsolve export --to csv` writes them. It may start
    anywhere and drift; its last whole cycle is fitted by least squares. The stages of CASE that press stay, and the
    record gives the motion along x.

    Written are OUT.csv (parameters with 95 % bounds and correlations), OUT.png (both loops) and OUT.yaml (CASE with the
    values found). The exit code is 1 if a bound exceeds its parameter, which the loop then does not determine.
    """
    from fretsolve.cli.commands.fit import fit_case

    return fit_case(jobs=jobs or processors(), **options)


@main.command()
@result_argument
@flag("--all", "every_increment", help="One row per increment instead of one per stage.")
@click.option(
    "--columns", metavar="NAME,...", help="Columns of the history; by default those that are not 0, for programs all."
)
@flag("--json", "as_json", help="Print a JSON object, for programs: history, cycles and units.")
@flag("--csv", "as_csv", help="Print the history as CSV, for programs.")
def show(**options: Any) -> int:
    """Print the result OUT as a table, even while it grows.

    Of very many stages the table has the first and the last ones.
    """
    if options["as_json"] and options["as_csv"]:
        raise click.UsageError("--json and --csv exclude each other.")
    from fretsolve.cli.commands.output import show_result

    return show_result(**options)


def _point(context: click.Context, parameter: click.Parameter, value: str | None) -> tuple[float, ...] | str | None:
    """Return two or three lengths in mm from a text such as ``0.1,-0.05``, or the name of a point."""
    if value is None or value == TENSION:
        return value
    with suppress(ValueError):
        found = tuple(float(part) for part in value.split(","))
        if len(found) in (2, 3) and all(map(isfinite, found)):
            return found
    raise click.BadParameter(
        f"{value!r} is not a point; two numbers in mm such as 0.1,-0.05 are needed, the depth as a third, or tension"
    )


_KIND_LINES = "\n    ".join(f"{kind.name:15}{kind.caption}" for kind in KINDS.values())


@main.command(
    help=f"""Draw the result OUT, even while it grows.

    KIND is one or more of these, by default loop. It needs matplotlib: pip install '.[plot]' in a clone of fretsolve.

    \b
    {_KIND_LINES}
    """
)
@result_argument
@click.argument("kinds", type=click.Choice(KINDS), nargs=-1, metavar="[KIND]...")
@click.option(
    "-o",
    "--output",
    "target",
    type=click.Path(readable=False),
    metavar="FILE",
    help="The picture (.png, .pdf, .svg; animate: .gif, .mp4), or a folder (created if the name ends in /); by default"
    " OUT with the kind in its name.",
)
@repeatable_option("--step", "steps", "N", "An increment to show; only profiles show several at once.", type=int)
@click.option(
    "--at",
    callback=_point,
    metavar="X,Y[,Z]|tension",
    help="The point in mm of profiles and of stress-cycle. Of stress-cycle Z is the depth below the surface, by default"
    " 0, and the default is tension: the point of the surface with the largest tension in the cycle, where cracks"
    " begin.",
)
@repeatable_option(
    "--field",
    "fields",
    "NAME,...",
    "Fields that map and animate show, or criteria of fatigue-map, as swt, and lives, as swt_life.",
)
@click.option(
    "--body",
    type=_BODY,
    callback=lambda context, parameter, value: value and int(value),
    help="The body whose stresses are shown, by default 2, or 1 if 2 is rigid; fatigue-map and crack show all.",
)
@flag("--all", "every_kind", help="All kinds, and a page that shows them, in the folder of -o.")
@picture_options
def plot(
    out: Path,
    kinds: tuple[str, ...],
    target: str | None,
    every_kind: bool,
    fields: tuple[str, ...],
    width: float | None,
    title: bool,
    dpi: int,
    **of_kinds: Any,
) -> int:
    """Draw a result. The help is given above, since it lists the kinds of pictures."""
    if every_kind and kinds:
        raise click.UsageError("--all takes all kinds; leave KIND out.")
    from fretsolve.cli.commands.plot import plot_result

    shown = Shown(fields=tuple(name for text in fields for name in text.split(",") if name), **of_kinds)
    return plot_result(out, None if every_kind else kinds or ("loop",), target, shown, Sheet(width, title, dpi))


@main.command()
@result_argument
@click.option("--to", "file_format", type=click.Choice(FORMATS), required=True, help="The format; see above.")
@output_option("By default OUT with .pvd, .xdmf, .csv, .npz or .heights.hdf5.", "FILE", "target")
@repeatable_option("--step", "steps", "N", "Export this increment instead of all that have fields.", type=int)
@overwrite_option("existing files")
def export(**options: Any) -> int:
    """Write the result OUT for ParaView, spreadsheets or NumPy.

    OUT may still be growing. Files of stresses (OUT.stress.h5) and of fatigue
    parameters (OUT.fatigue.h5) are written to vtk as volumes.

    \b
    vtk   for ParaView: the deformed surfaces of both bodies and all fields, over the increments. Open FILE.pvd; the
          surfaces lie in the folder FILE.vtk. Heights are true to scale: scale z up to see them.
    xdmf  for ParaView: the fields over the increments. FILE.xdmf refers to OUT and to FILE.xdmf.h5.
    csv   for spreadsheets: the history, with units in the header.
    npz   for NumPy: history and fields.
    heights  for another case: worn depth and worn separation after the last increment, or that of --step, as maps.
    """
    from fretsolve.cli.commands.output import export_result

    return export_result(**options)


@main.command()
@result_argument
@repeatable_option("--body", "bodies", "1|2", "The body, by default 2, or 1 if 2 is rigid.", type=_BODY)
@repeatable_option(
    "--depth", "depths", "D", "A depth such as 20 um; by default the surface and graded ones to two contact radii."
)
@repeatable_option("--stage", "stages", "S", "The end of stage S; by default all, or 1000 of more.", type=int)
@repeatable_option("--step", "steps", "N|N:M", "Increment N, or those with fields from N to M.", type=StepRange())
@click.option("--cycle", metavar="last|N|all", help="All increments of a cycle of the load path.")
@click.option("--plane", type=click.Choice(["x=0", "y=0"]), help="Only the row of cells nearest to this plane.")
@_WINDOW
@output_option("By default OUT with .stress.h5.", "FILE", "target")
@overwrite_option("an existing file")
@threads_option("Threads to use.")
@quiet_option
def stress(threads: int, **options: Any) -> int:
    """Compute the stresses below the surface of the result OUT.

    FILE gets the components xx, yy, zz, xy, xz, yz of each body over increment, depth, x and y, with the bulk stress of
    the body. The largest von Mises stress, tension and shear (Tresca) are printed with their places and errors.
    """
    from fretsolve.cli.commands.stress import StressOptions, stress_of_result

    return stress_of_result(StressOptions(threads=available(threads), **options))


@main.command()
@result_argument
@click.option(
    "--material",
    metavar="FILE|KEYS",
    required=True,
    help="The constants: a YAML file, or keys such as 'tension_limit=300 MPa,torsion_limit=190 MPa'.",
)
@repeatable_option(
    "--criterion",
    "criteria",
    "NAME,...",
    "crossland, dang-van, findley, mcdiarmid, fatemi-socie, swt, ruiz-1 or ruiz-2, also written with _.",
    required=True,
)
@click.option(
    "--average",
    metavar="KIND:LENGTH",
    help="Average stresses first: point:20um (at half the length below the surface), line:20um (over twice the length),"
    " volume:20um (over a cube).",
)
@_CYCLE
@_BLOCKS
@repeatable_option("--body", "bodies", "1|2", "The body; by default those of OUT, or body 2.", type=_BODY)
@_WINDOW
@output_option("By default OUT with .fatigue.h5.", "FILE", "target")
@overwrite_option("an existing file")
@threads_option("Threads for stresses.")
@quiet_option
def fatigue(threads: int, **options: Any) -> int:
    """Find where cracks may begin, from the result OUT or from a file of its stresses.

    FILE gets each parameter over depth, x and y with its critical plane, and the utilisation of its limit or the life.
    The worst places are printed with their error bars. From a result the stresses of the cycles are computed first, at
    the depths of `fretsolve stress`; a file of stresses knows its cycles, but neither error bars nor the slip that
    Ruiz's parameters need. Of several cycles the largest parameter counts at each point, and damage adds up.
    """
    from fretsolve.cli.commands.fatigue import FatigueOptions, fatigue_of_result

    return fatigue_of_result(FatigueOptions(threads=available(threads), **options))


@main.command(context_settings={"token_normalize_func": lambda name: name.replace("_", "-")})
@result_argument
@click.option(
    "--material",
    metavar="FILE|KEYS",
    help="The constants: a YAML file, or keys such as 'threshold_range=2.1 MPa m^0.5,fatigue_range=248 MPa'. Stress"
    " intensity needs none.",
)
@click.option(
    "--at",
    metavar="edge|max|X",
    default="edge",
    show_default=True,
    help="Where it begins: at the edge of contact with the larger tension, where the fatigue parameter on the surface"
    " is largest, or at x.",
)
@click.option("--body", type=_BODY, help="The body, by default 2, or 1 if 2 is rigid.")
@click.option(
    "--criterion",
    type=click.Choice(["swt", "fatemi-socie"]),
    help="The parameter that gives the cycles to a crack, by default the one whose life curve the material has.",
)
@click.option("--final-length", metavar="L", help="Length at which life ends, by default where toughness is reached.")
@click.option(
    "--thickness", metavar="L", help="Thickness of the body, at which life ends; K holds for cracks of a tenth of it."
)
@_CYCLE
@_BLOCKS
@output_option("By default OUT with .crack.h5.", "FILE", "target")
@overwrite_option("an existing file")
@quiet_option
def crack(**options: Any) -> int:
    """Look at a crack from the surface, normal to it: does it stop, and how long does it take?

    FILE gets stress intensities over increment and length, with their range over a cycle beside the threshold, and the
    lives to a crack of each length and from there to the end. They are printed with error bars. What a constant of the
    material is missing for is left out.
    """
    from fretsolve.cli.commands.crack import CrackOptions, crack_of_result

    return crack_of_result(CrackOptions(**options))


@main.command()
@click.argument("kind", type=click.Choice(TEMPLATES))
@output_option("By default KIND.yaml.", "CASE", "target")
def new(kind: str, target: Path | None) -> int:
    """Write a commented case to start from. An existing file is not touched.

    \b
    hertz       a sphere pressed on a flat
    mode1       cyclic tangential force: partial slip, the fretting loop
    mode2       pressed on a body of another material: slip without a tangential load
    mode3       cyclic torsion
    gross-slip  cyclic displacement up to gross slip
    rough       a rough sphere, with a height map beside the case
    line        a line contact in plane strain, the specimen pulled in phase
    wear        a scar worn over 100000 cycles, of which a few are solved
    """
    from fretsolve.cli.commands.new import new_case

    return new_case(kind, target or Path(f"{kind}.yaml"))


@main.command()
def materials() -> int:
    """Print the materials that a body may name, with their sources.

    A body of a case takes one by its name, as {material: Ti-6Al-4V}; keys beside it, as young_modulus: 120 GPa,
    override its constants. Constants are those at room temperature. Compare them with those of your own material.
    """
    from fretsolve.cli.commands.new import print_materials

    return print_materials()


@main.command()
@output_option("Write it to this .json file instead of printing it.", "FILE", "target")
@overwrite_option("an existing file")
def schema(target: Path | None, overwrite: bool) -> int:
    """Print the JSON Schema of the case file, for editors.

    Begin a case with the line `# yaml-language-server: $schema=FILE`: editors with the YAML language server then
    complete its keys, show their meaning and mark mistakes.
    """
    from fretsolve.cli.commands.new import print_schema

    return print_schema(target, overwrite=overwrite)
