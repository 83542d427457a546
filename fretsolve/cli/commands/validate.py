"""Carry out ``fretsolve validate``: print the values, model, grid, stages and cost of a case, and solve nothing."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import yaml

from fretsolve.case.dimensions import in_small_unit
from fretsolve.case.keys.body_specs import RoughnessSurface
from fretsolve.case.keys.map_keys import HeightsSurface
from fretsolve.case.loading import read_case
from fretsolve.cli.case_summary import (
    accuracy_lines,
    grid_line,
    layer_lines,
    material_lines,
    mirror_lines,
    model_table,
    path_length,
    stage_lines,
    wear_lines,
)
from fretsolve.errors import CaseError, FileError
from fretsolve.problem.setup.closed_forms import WITH_LAYER
from fretsolve.problem.setup.cost_estimate import estimate, rounded_bytes, rounded_time
from fretsolve.problem.setup.line_forms import LineClosedForms
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.problem.setup.warnings import case_warnings, cells_across
from fretsolve.problem.setup.yield_warnings import cylinder_contact
from fretsolve.simulation.accuracy.rounds import Round, first_round
from fretsolve.system.progress import print_warnings

NO_STICK_RADIUS = "no closed form gives the stick radius under a tangential load between unlike bodies"


def validate_cases(cases: Sequence[Path], overrides: Sequence[str]) -> int:
    """Print a report on each case, or its errors; return the exit code of the worst."""
    code = 0
    for path in cases:
        try:
            first = first_round(read_case(path, pipe=True).case(overrides))
            setup = first.setup
            if setup.case.output.fatigue is not None:
                from fretsolve.post.fatigue.request import require_fatigue

                require_fatigue(setup)
            if setup.case.output.crack is not None:
                from fretsolve.post.crack.request import require_crack

                require_crack(setup)
            if any(isinstance(surface, HeightsSurface) for surface in setup.case.surface):
                setup.separation()  # reads the maps
            setup.friction_on_grid()  # as the run will have it
            print(*report(first), "", sep="\n", flush=True)
            print_warnings(path, *case_warnings(setup, path.with_suffix(".h5")))
        except (CaseError, FileError) as error:
            print(error, file=sys.stderr)
            code = max(code, error.exit_code)
    return code


def report(first: Round) -> Iterator[str]:
    """Yield the lines of the report on one case, of which no more than the first round is known."""
    setup = first.setup
    yield f"# {setup.case.source.path}, with all defaults, in mm, N, MPa, rad"
    yield effective_yaml(first)
    yield "# model"
    yield from model_table(setup)
    yield f"Dundurs' constant {setup.model.compliances.dundurs_constant:.4g}"
    yield from material_lines(setup)
    yield from layer_lines(setup)
    yield "\n# grid"
    yield grid_line(setup)
    yield from mirror_lines(setup)
    yield from accuracy_lines(first)
    yield from surface_lines(setup)
    yield f"\n# load path of {path_length(setup)}"
    yield from stage_lines(setup)
    yield from closed_form_lines(setup)
    if setup.on_rig is not None:
        from fretsolve.cli.rig_summary import rig_lines  # other cases do not need them

        yield from rig_lines(setup)
    yield from wear_lines(setup)
    yield f"\n# cost{' of the first round' if setup.case.solver.accuracy is not None else ''}"
    yield from cost_lines(setup)


def effective_yaml(first: Round) -> str:
    """Return the case with all defaults, as a case file, without what the rounds of an accuracy pick."""
    case = first.setup.case.effective()
    for group, name in (key.split(".") for key in first.picked_keys):
        del case[group][name]
    return yaml.safe_dump(case, sort_keys=False, default_flow_style=None, allow_unicode=True, width=110)


def surface_lines(setup: ProblemSetup) -> Iterator[str]:
    """Yield what each measured map and roughness of the case is."""
    for place, surface in enumerate(setup.case.surface):
        if isinstance(surface, HeightsSurface):
            from fretsolve.cli.map_summary import map_lines  # loads the readers, which other cases do without
            from fretsolve.problem.surface.load_map import load_height_map
            from fretsolve.problem.surface.map_measures import measures_of

            yield f"\n# {surface.file.name}, in mm, x to the right and y up"
            found = load_height_map(surface, ("surface", place, "heights"))
            yield from map_lines(found, measures_of(found), max(setup.grid.dx, setup.grid.dy))
        elif isinstance(surface, RoughnessSurface):
            from fretsolve.problem.surface.roughness import waves_of  # other cases do not need it

            height, slope = waves_of(surface).rms()
            yield f"\n# roughness of period {in_small_unit(surface.period)}"
            yield f"root mean square height {in_small_unit(height, 4)}, root mean square slope {slope:.4g}"
    file = setup.case.friction.map
    if file is not None and setup.friction is not None and (field := setup.friction.field) is not None and field.map:
        from fretsolve.cli.map_summary import value_lines

        yield f"\n# {file.name}, coefficients of friction, x to the right and y up"
        yield from value_lines(field.map)


def closed_form_lines(setup: ProblemSetup) -> Iterator[str]:
    """Yield Hertz's or Boussinesq's contact at the largest normal load, the loads of gross slip, the smallest stick."""
    forms, modulus = setup.closed_forms, setup.model.compliances.contact_modulus
    if isinstance(forms, LineClosedForms):
        yield from line_form_lines(setup, forms)
        return
    hertz, punch, stick = forms.largest, forms.punch, forms.smallest_stick
    coupled = setup.model.has_shear and setup.model.terms.normal_tangential_coupling
    contact = hertz or punch
    if contact is None:
        yield from cylinder_lines(setup)
        return
    size, ratio = f"a = {contact.contact_radius:.6g} mm", f"delta_z/a = {contact.delta_z / contact.contact_radius:.3g}"
    source, name, pressure = "Boussinesq", "mean pressure", punch.mean_pressure if punch else 0.0
    if hertz is not None:
        source, name, pressure, ratio = "Hertz", "p0", hertz.max_pressure, f"a/R = {hertz.size_over_radius:.3g}"
        if not hertz.is_circle:
            size = f"semi-axes {hertz.semi_axes[0]:.6g} and {hertz.semi_axes[1]:.6g} mm"
    yield f"\n# {source} at the largest load"
    yield f"P = {contact.load:.6g} N: {size}, {name} = {pressure:.6g} MPa, delta_z = {in_small_unit(contact.delta_z)}"
    yield f"{ratio}, {name}/E* = {pressure / modulus:.3g}, E* = {modulus:.6g} MPa"
    if hertz is not None:
        yield f"{cells_across(setup):.1f} cells across the contact"
    force, torque, displacement = forms.gross_slip(contact.load, hertz)
    limit, source = (
        ("mu P", "Cattaneo-Mindlin")
        if not setup.case.friction_varies
        else ("sum of the friction limit", "slip from the rim")
    )
    if force and math.isfinite(force):
        or_torque = f" or at Mz = {torque:.6g} N mm" if math.isfinite(torque) else ""
        yield f"gross slip begins at Q = {limit} = {force:.6g} N{or_torque}"
    if displacement is not None:
        layer = setup.model.compliances.layer_shear
        source += " and L mu p0 of the layer" if layer else ""
        yield f"gross slip under Q begins at a displacement of {in_small_unit(displacement)} ({source})"
        if layer and (compliance := forms.full_stick(hertz)) is not None:
            yield f"just after a load turns back, Q changes by {1e-3 / compliance:.5g} N per um of the displacement"
    if (pair := setup.case.friction.pair) is not None:
        first, second = (friction * contact.load for friction in pair)
        yield f"gross slip begins at Q = {first:.6g} N along the first axis, {second:.6g} N along the second"
    if setup.case.friction_varies and displacement is None and setup.model.has_shear:
        yield "no closed form holds for partial slip under this friction"
    if setup.model.bulk is not None and not setup.case.friction_varies:
        yield _sphere_under_bulk(setup)
    elif stick is not None:
        cells = 2.0 * stick.value / max(setup.grid.dx, setup.grid.dy)
        yield (
            f"smallest stick radius c = {stick.value:.6g} mm, {cells:.1f} cells across, at the end of stage"
            f" {stick.stage + 1} ({stick.source})"
        )
    elif hertz is not None and setup.model.has_shear and setup.model.compliances.layer_shear:
        yield f"no closed form gives the stick radius: {WITH_LAYER}"
    elif hertz is not None and coupled and not setup.case.friction_varies:
        yield NO_STICK_RADIUS


def _sphere_under_bulk(setup: ProblemSetup) -> str:
    """Return the stick zone of a sphere under a force and bulk stress in words, or why no closed form gives it."""
    found = setup.closed_forms.under_bulk
    if isinstance(found, str):
        return f"no closed form gives the stick zone under this bulk stress: {found}"
    stage, form = found
    x = setup.case.surface[0].center[0] + form.stick_center
    cells = 2.0 * form.stick_radius / max(setup.grid.dx, setup.grid.dy)
    return (
        f"smallest stick radius c = {form.stick_radius:.6g} mm, {cells:.1f} cells across, its middle at x ="
        f" {x:.6g} mm, at the end of stage {stage + 1} ({form.source})"
    )


def cylinder_lines(setup: ProblemSetup) -> Iterator[str]:
    """Yield Hertz's line contact of a cylinder, which its ends on an area disturb, and the force of gross slip."""
    contact, modulus = cylinder_contact(setup), setup.model.compliances.contact_modulus
    if contact is None:
        return
    yield "\n# Hertz's line contact at the largest load, as if the cylinder had no ends"
    a, p0 = contact.half_width, contact.max_pressure
    yield f"P/length = {contact.load:.6g} N/mm: half-width a = {a:.6g} mm, p0 = {p0:.6g} MPa"
    yield f"a/R = {a / contact.radius:.3g}, p0/E* = {p0 / modulus:.3g}, E* = {modulus:.6g} MPa"
    yield f"{cells_across(setup):.1f} cells across the contact"
    yield "the ends carry more than that, and the middle some per cent less"
    force, _, _ = setup.closed_forms.gross_slip(setup.closed_forms.largest_force)
    if force and math.isfinite(force):
        yield f"gross slip begins at Q = mu P = {force:.6g} N"


def line_form_lines(setup: ProblemSetup, forms: LineClosedForms) -> Iterator[str]:
    """Yield the line contact at the largest load, the force of gross slip and the smallest stick zone."""
    if (contact := forms.widest) is None:
        return
    grid, stick, modulus = setup.grid, forms.smallest_stick, setup.model.compliances.contact_modulus
    yield f"\n# {forms.source} at the largest load"
    name = "p0" if forms.source == "Hertz" else "largest pressure"
    a, p0 = contact.half_width, contact.max_pressure
    yield f"P = {contact.load:.6g} N/mm: half-width a = {a:.6g} mm, {name} = {p0:.6g} MPa"
    yield f"{name}/E* = {p0 / modulus:.3g}, E* = {modulus:.6g} MPa"
    yield f"{2.0 * a / grid.dx:.1f} cells across the contact"
    force, _, _ = forms.gross_slip(contact.load)
    varies = setup.case.friction_varies
    if force and math.isfinite(force):
        yield f"gross slip begins at Q = {'sum of the friction limit' if varies else 'mu P'} = {force:.6g} N/mm"
    if varies:
        if setup.model.has_shear:
            yield "no closed form holds for partial slip under this friction"
        return
    if stick is not None:
        yield (
            f"smallest stick half-width c = {stick.value:.6g} mm, {2.0 * stick.value / grid.dx:.1f} cells across,"
            f" at the end of stage {stick.stage + 1} ({stick.source})"
        )
        shear = forms.partial_slip(stick.stage)
        if setup.model.bulk is not None and shear is not None:
            middle = setup.case.surface[0].center[0] + shear.stick_center
            yield f"bulk stress shifts its middle to x = {middle:.6g} mm"
    elif setup.model.has_shear and setup.model.compliances.layer_shear:
        yield f"no closed form gives the stick zone: {WITH_LAYER}"
    elif setup.model.bulk is not None:
        yield from _why_no_line_form(forms)
    elif setup.model.has_shear and setup.model.terms.normal_tangential_coupling:
        yield NO_STICK_RADIUS


def _why_no_line_form(forms: LineClosedForms) -> Iterator[str]:
    """Yield the stick zone of a cycle with mean values, or why no closed form gives the stick zone."""
    steady = forms.shaken_down
    if steady is None:
        yield (
            "no closed form gives the stick zone: it needs a cylinder on a body of its own material, P kept, force and"
            " bulk stress in proportion, and no slip zone that shrinks on the way"
        )
        return
    middle = forms.case.surface[0].center[0] + steady.stick_center
    yield (
        "force and bulk stress are not in proportion, so no closed form gives the first stick zones; once the last two"
        f" stages repeat: half-width c = {steady.stick_half_width:.6g} mm, middle at x = {middle:.6g} mm (Hills-Nowell"
        " with half their difference)"
    )


def cost_lines(setup: ProblemSetup) -> Iterator[str]:
    """Yield the estimate of memory and time in words."""
    cost = estimate(setup)
    yield f"about {rounded_bytes(cost.memory)} of memory, a result file of about {rounded_bytes(cost.file)}"
    yield (
        f"about {cost.applications // cost.increments} operator applications per increment,"
        f" roughly {rounded_time(cost.seconds)} in all on one thread"
    )
    if cost.saved:
        yield f"single precision saves {rounded_bytes(cost.saved)} of memory and half of the file, but little time"
