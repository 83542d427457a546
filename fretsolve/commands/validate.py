"""Carry out ``fretsolve validate``: print the values, model, grid, stages and cost of a case, and solve nothing."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import yaml

from fretsolve.case.loading import load_case
from fretsolve.case.surface_specs import HeightsSurface
from fretsolve.commands.case_summary import accuracy_lines, grid_line, model_table, stage_lines, warn
from fretsolve.errors import CaseError, FileError, dotted
from fretsolve.setup.closed_forms import GrossSlip
from fretsolve.setup.cost_estimate import disk_problem, estimate, memory_problem, rounded_bytes, rounded_time
from fretsolve.setup.problem_setup import ProblemSetup, set_up
from fretsolve.setup.warnings import case_warnings, cells_across

YAML_WIDTH = 110


def validate_cases(cases: Sequence[Path], overrides: Sequence[str]) -> int:
    """Print a report on each case, or its errors; return the exit code of the worst."""
    code = 0
    for path in cases:
        try:
            setup = set_up(load_case(path, overrides))
            if any(isinstance(surface, HeightsSurface) for surface in setup.case.surface):
                setup.separation()  # reads the maps
            for line in report(setup):
                print(line)
            print(flush=True)
            too_large = filter(None, (memory_problem(setup), disk_problem(setup, path.with_suffix(".h5"))))
            warn(setup, *case_warnings(setup), *(f"{dotted(error.key)}: {error.message}" for error in too_large))
        except (CaseError, FileError) as error:
            print(error, file=sys.stderr)
            code = max(code, error.exit_code)
    return code


def report(setup: ProblemSetup) -> Iterator[str]:
    """Yield the lines of the report on one case."""
    yield f"# {setup.case.source.path}, with all defaults, in mm, N, MPa, rad"
    yield effective_yaml(setup)
    yield "# model"
    yield from model_table(setup)
    yield f"Dundurs' constant {setup.model.compliances.dundurs_constant:.4g}"
    yield "\n# grid"
    yield grid_line(setup)
    yield from accuracy_lines(setup)
    count = setup.load_path.increments
    yield f"\n# load path of {count} increment{'s' * (count > 1)}"
    yield from stage_lines(setup)
    yield from hertz_lines(setup)
    yield from punch_lines(setup)
    yield "\n# cost"
    yield from cost_lines(setup)


def effective_yaml(setup: ProblemSetup) -> str:
    """Return the case with all defaults, as a case file."""
    return yaml.dump(
        setup.case.effective(),
        Dumper=_Dumper,
        sort_keys=False,
        default_flow_style=None,
        allow_unicode=True,
        width=YAML_WIDTH,
    )


class _Dumper(yaml.SafeDumper):
    """Write equal values out instead of referring back to the first."""

    def ignore_aliases(self, data: object) -> bool:
        return True


def hertz_lines(setup: ProblemSetup) -> Iterator[str]:
    """Yield Hertz's contact at the largest normal load, the loads of gross slip there, and the smallest stick zone."""
    forms, modulus = setup.closed_forms, setup.model.compliances.contact_modulus
    hertz, stick = forms.largest, forms.smallest_stick
    if hertz is None:
        return
    first, second = hertz.semi_axes
    size = f"a = {first:.6g} mm" if first == second else f"semi-axes {first:.6g} and {second:.6g} mm"
    yield "\n# Hertz at the largest load"
    yield f"P = {hertz.load:.6g} N: {size}, p0 = {hertz.max_pressure:.6g} MPa, delta_z = {hertz.delta_z:.6g} mm"
    yield f"a/R = {hertz.size_over_radius:.3g}, p0/E* = {hertz.max_pressure / modulus:.3g}, E* = {modulus:.6g} MPa"
    yield f"{cells_across(setup):.1f} cells across the contact"
    yield from _gross_slip_lines(forms.gross_slip(hertz.load, hertz))
    if stick is not None:
        cells = 2.0 * stick.value / max(setup.grid.dx, setup.grid.dy)
        yield (
            f"smallest stick radius c = {stick.value:.6g} mm, {cells:.1f} cells across, at the end of stage"
            f" {stick.stage + 1} ({stick.source})"
        )


def punch_lines(setup: ProblemSetup) -> Iterator[str]:
    """Yield Boussinesq's flat punch at the largest normal load, and the load of gross slip there."""
    punch, modulus = setup.closed_forms.punch, setup.model.compliances.contact_modulus
    if punch is None:
        return
    a, mean = punch.contact_radius, punch.mean_pressure
    yield "\n# Boussinesq at the largest load"
    yield f"P = {punch.load:.6g} N: a = {a:.6g} mm, mean pressure = {mean:.6g} MPa, delta_z = {punch.delta_z:.6g} mm"
    yield f"delta_z/a = {punch.delta_z / a:.3g}, mean pressure/E* = {mean / modulus:.3g}, E* = {modulus:.6g} MPa"
    yield from _gross_slip_lines(setup.closed_forms.gross_slip(punch.load))


def _gross_slip_lines(limit: GrossSlip) -> Iterator[str]:
    if limit.force:
        torque = f" or at Mz = {limit.torque:.6g} N*mm" if math.isfinite(limit.torque) else ""
        yield f"gross slip begins at Q = mu P = {limit.force:.6g} N{torque}"
    if limit.delta_x is not None:
        yield f"gross slip under Q begins at a displacement of {limit.delta_x:.6g} mm (Cattaneo-Mindlin)"


def cost_lines(setup: ProblemSetup) -> Iterator[str]:
    """Yield the estimate of memory and time in words."""
    cost = estimate(setup)
    yield f"about {rounded_bytes(cost.memory)} of memory, a result file of about {rounded_bytes(cost.file)}"
    yield (
        f"about {cost.applications // setup.load_path.increments} operator applications per increment,"
        f" roughly {rounded_time(cost.seconds)} in all on one thread"
    )
    if cost.saved:
        yield f"single precision saves {rounded_bytes(cost.saved)} of memory and half of the file, but little time"
