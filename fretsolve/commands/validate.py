"""``fretsolve validate``: what a case comes to, before anything is solved."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import yaml

from fretsolve.case import HeightsSurface, load_case
from fretsolve.commands.case_summary import accuracy_lines, grid_line, model_table, stage_lines, warn
from fretsolve.errors import CaseError, FileError, dotted
from fretsolve.setup.boussinesq import punch_contact
from fretsolve.setup.cost_estimate import disk_problem, estimate, memory_problem
from fretsolve.setup.hertz import hertz_contact, hertz_contacts
from fretsolve.setup.problem_setup import set_up
from fretsolve.setup.slip_forecast import sliding_displacement, smallest_stick
from fretsolve.setup.warnings import doubts

if TYPE_CHECKING:
    from fretsolve.setup.hertz import Hertz
    from fretsolve.setup.problem_setup import ProblemSetup

YAML_WIDTH = 110


def validate_cases(cases: Sequence[Path], overrides: Sequence[str]) -> int:
    """Print a report on each case, or its errors; the exit code of the worst."""
    code = 0
    for path in cases:
        try:
            setup = set_up(load_case(path, overrides))
            if any(isinstance(surface, HeightsSurface) for surface in setup.case.surface):
                setup.separation()  # reads the maps
            hertz = hertz_contact(setup)
            for line in report(setup, hertz):
                print(line)
            print(flush=True)
            warn(setup, *warnings(setup))
        except (CaseError, FileError) as error:
            print(error, file=sys.stderr)
            code = max(code, error.exit_code)
    return code


def report(setup: ProblemSetup, hertz: Hertz | None) -> Iterator[str]:
    """The lines on one case."""
    yield f"# {setup.case.source.path}, with all defaults, in mm, N, MPa, rad"
    yield effective_yaml(setup)
    yield "# model"
    yield from model_table(setup)
    yield f"Dundurs' constant {setup.model.compliances.dundurs_constant:.4g}"
    yield "\n# grid"
    yield grid_line(setup)
    yield from accuracy_lines(setup)
    yield f"\n# load path of {setup.load_path.increments} increments"
    yield from stage_lines(setup)
    if hertz is not None:
        yield "\n# Hertz at the largest load"
        yield from closed_form_lines(setup, hertz)
        yield from stick_lines(setup)
    yield from punch_lines(setup)
    yield "\n# cost"
    yield from estimate(setup).lines()


def effective_yaml(setup: ProblemSetup) -> str:
    """The case with all defaults, as a case file."""
    return yaml.dump(
        setup.case.effective(),
        Dumper=_Dumper,
        sort_keys=False,
        default_flow_style=None,
        allow_unicode=True,
        width=YAML_WIDTH,
    )


class _Dumper(yaml.SafeDumper):
    """Writes equal values out instead of referring back to the first."""

    def ignore_aliases(self, data: object) -> bool:
        return True


def closed_form_lines(setup: ProblemSetup, hertz: Hertz) -> Iterator[str]:
    """What Hertz's theory says at the largest normal load, and where friction gives way there."""
    first, second = hertz.semi_axes
    size = f"a = {first:.6g} mm" if first == second else f"semi-axes {first:.6g} and {second:.6g} mm"
    yield f"P = {hertz.load:.6g} N: {size}, p0 = {hertz.max_pressure:.6g} MPa, delta_z = {hertz.delta_z:.6g} mm"
    yield f"a/R = {hertz.size_over_radius:.3g}, p0/E* = {hertz.strain:.3g}, E* = {hertz.modulus:.6g} MPa"
    yield f"{hertz.cells_across(setup.grid):.1f} cells across the contact"
    friction, circle = setup.model.friction, hertz.circle
    if not friction:
        return
    torque = hertz.torque(friction)
    at_torque = f", at Mz = {torque:.6g} N*mm" if torque is not None else ""
    yield f"everything slides at Q = mu P = {friction * hertz.load:.6g} N{at_torque}"
    displacement = sliding_displacement(setup, circle) if circle is not None else None
    if displacement is not None:
        yield f"that is at a displacement of {displacement:.6g} mm (Cattaneo, Mindlin)"


def punch_lines(setup: ProblemSetup) -> Iterator[str]:
    """What Boussinesq's theory says of a flat punch at the largest load, and where friction gives way there."""
    punch, modulus = punch_contact(setup), setup.model.compliances.contact_modulus
    if punch is None:
        return
    a, mean = punch.contact_radius, punch.mean_pressure
    yield "\n# Boussinesq at the largest load"
    yield (
        f"P = {punch.load:.6g} N: a = {a:.6g} mm, mean pressure = {mean:.6g} MPa, delta_z = {punch.delta_z:.6g} mm"
    )
    yield f"delta_z/a = {punch.delta_z / a:.3g}, mean pressure/E* = {mean / modulus:.3g}, E* = {modulus:.6g} MPa"
    if setup.model.friction:
        yield f"everything slides at Q = mu P = {setup.model.friction * punch.load:.6g} N"


def stick_lines(setup: ProblemSetup) -> Iterator[str]:
    """The smallest stick zone of the path, where a closed form tells."""
    stick = smallest_stick(setup, hertz_contacts(setup))
    if stick is not None:
        cells = stick.cells_across(max(setup.grid.dx, setup.grid.dy))
        yield (
            f"smallest stick radius c = {stick.radius:.6g} mm, {cells:.1f} cells across, at the end of stage"
            f" {stick.stage + 1} ({stick.authors})"
        )


def warnings(setup: ProblemSetup) -> Iterator[str]:
    """What a person should hear before running the case."""
    yield from doubts(setup)
    for too_large in (memory_problem(setup), disk_problem(setup, setup.case.source.path.with_suffix(".h5"))):
        if too_large is not None:
            yield f"{dotted(too_large.key)}: {too_large.message}"
