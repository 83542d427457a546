"""The command line of stresses below the surface, and of fatigue by them: options only, as in `fretsolve.cli.main`."""

from __future__ import annotations

from typing import Any

import click

from fretsolve.cli.options import (
    StepRange,
    WholeNumber,
    output_option,
    overwrite_option,
    quiet_option,
    repeatable_option,
    result_argument,
)
from fretsolve.system.environment import available

_WINDOW = click.option(
    "--window",
    metavar="auto|all|MARGIN",
    default="auto",
    show_default=True,
    help="The cells: the contact with a margin of a quarter of its width, or of one and a half in a line contact; the"
    " whole grid; or the contact with a margin such as 1mm. A margin may reach beyond the grid.",
)


@click.command()
@result_argument
@repeatable_option(
    "--body", "bodies", "1|2", "The body, by default 2, or 1 if 2 is rigid.", type=click.Choice(["1", "2"])
)
@repeatable_option(
    "--depth", "depths", "D", "A depth such as 20 um; by default the surface and graded ones to two contact radii."
)
@repeatable_option("--stage", "stages", "S", "The end of stage S; by default the ends of all stages.", type=int)
@repeatable_option("--step", "steps", "N|N:M", "Increment N, or those with fields from N to M.", type=StepRange())
@click.option("--cycle", type=click.Choice(["last"]), help="All increments of the last cycle of the load path.")
@click.option("--plane", type=click.Choice(["x=0", "y=0"]), help="Only the row of cells nearest to this plane.")
@_WINDOW
@output_option("By default OUT with .stress.h5.", "FILE", "target")
@overwrite_option("an existing file")
@click.option("--threads", type=WholeNumber(1), metavar="N", default=1, show_default=True, help="Threads to use.")
@quiet_option
def stress(threads: int, **options: Any) -> int:
    """Compute the stresses below the surface of the result OUT.

    FILE gets the components xx, yy, zz, xy, xz, yz of each body over increment, depth, x and y, with the bulk stress of
    the body. The largest von Mises stress, tension and shear (Tresca) are printed with their places and errors.
    """
    from fretsolve.commands.stress import StressOptions, stress_of_result

    return stress_of_result(StressOptions(threads=available(threads), **options))


@click.command()
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
    "crossland, dang-van, findley, mcdiarmid, fatemi-socie or swt.",
    required=True,
)
@click.option(
    "--average",
    metavar="KIND:LENGTH",
    help="Average stresses first: point:20um (at half the length below the surface), line:20um (over twice the length),"
    " volume:20um (over a cube).",
)
@click.option("--cycle", type=click.Choice(["last"]), default="last", show_default=True, help="The cycle to look at.")
@repeatable_option(
    "--body", "bodies", "1|2", "The body; by default those of OUT, or body 2.", type=click.Choice(["1", "2"])
)
@_WINDOW
@output_option("By default OUT with .fatigue.h5.", "FILE", "target")
@overwrite_option("an existing file")
@click.option("--threads", type=WholeNumber(1), metavar="N", default=1, show_default=True, help="Threads for stresses.")
@quiet_option
def fatigue(threads: int, cycle: str, **options: Any) -> int:
    """Find where cracks may begin, from the result OUT or from a file of its stresses.

    FILE gets each parameter over depth, x and y with its critical plane, and the utilisation of its limit or the life.
    The worst places are printed. From a result the stresses of its last cycle are computed first, at the depths of
    `fretsolve stress`; from a file of stresses, the last cycle in it is taken, or all of it where the load path has
    no cycle.
    """
    from fretsolve.commands.fatigue import FatigueOptions, fatigue_of_result

    return fatigue_of_result(FatigueOptions(threads=available(threads), **options))
