"""Warn of doubtful cases: by their theory, resolution, loads and settings."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fretsolve.case.dimensions import percent
from fretsolve.case.history import PAIRS
from fretsolve.errors import dotted
from fretsolve.model.edges import CYLINDER_END, depth_in_rounding, rounding
from fretsolve.model.required_terms import UNCOUPLED_BELOW
from fretsolve.setup.accuracy import points_needed
from fretsolve.setup.closed_forms import Load
from fretsolve.setup.contact_size import AREA_MARGIN, concave_sphere
from fretsolve.setup.cost_estimate import disk_problem, estimate, memory_problem, rounded_bytes
from fretsolve.setup.problem_setup import ProblemSetup
from fretsolve.system.arrays import DoubleArray

if TYPE_CHECKING:
    from fretsolve.reference.line import HertzLine

FEWEST_CELLS, FEWEST_STICK_CELLS, FEWEST_END_CELLS = 20, 3, 2
"""Cells across the contact below which results are off by per cents; across the stick zone for its size to count; in
the contact with the rounding of a cylinder's end, with which the pressure there is 5 % too low."""

LARGEST_SIZE = 0.1
"""Contact radius over radius of curvature up to which a half-space and a paraboloid stand for the body. The strains are
about the same at this slope of a cone, and at this approach of a punch over its radius."""

STEEPEST_MAP = 1.0
"""Root mean square slope of a height map above which something is wrong, rather than rough."""

SPHERE_YIELD, LINE_YIELD = 1.6, 1.67
"""Largest Hertz pressure over the yield stress at which a body of Poisson's ratio 0.3 begins to yield under a sphere
and a cylinder; Johnson, Contact Mechanics (1985), section 6.1 (Tresca). An ellipse lies between both."""

LARGE_RESULT = 4e9
"""Bytes of a result that are most likely not wanted."""

HOLD_TO = "half-spaces and linear elasticity hold to about"


def case_warnings(setup: ProblemSetup, out: Path | None = None) -> list[str]:
    """Return one sentence per warning, each beginning with the key of the case file that it is about.

    out: the result to come, which may be too large for its disk.
    """
    groups = (
        _about_shapes,
        _about_friction,
        _about_sliding,
        _about_varied_friction,
        _about_resolution,
        _about_edges,
        _about_heights,
        _about_solver,
        _about_hertz,
        _about_yield,
        _about_line,
        _about_wear,
    )
    texts = [*setup.model.warnings, *(text for group in groups for text in group(setup))]
    disk = disk_problem(setup, out) if out is not None else None
    errors = concave_sphere(setup.case), memory_problem(setup), disk
    texts += _about_size(setup) if disk is None else ()
    return list(dict.fromkeys([*texts, *(f"{dotted(error.key)}: {error.message}" for error in errors if error)]))


def _about_size(setup: ProblemSetup) -> Iterator[str]:
    """Warn of a result that is very large because it keeps the fields of many increments."""
    cost = estimate(setup)
    size, increments = cost.file, cost.increments
    if size < LARGE_RESULT:
        return
    every = setup.case.output.every * math.ceil(size / (0.1 * LARGE_RESULT))
    cycles = any(stage.cycle is not None and stage.cycle.until is None for stage in setup.load_path.stages)
    yield (
        f"output.every: the result takes about {rounded_bytes(size)}, since it keeps fields of {increments} increments;"
        f" output: {{every: {every}}} keeps fewer, output: {{fields: []}} none, and the history has all of them"
        f"{'; until: periodic ends a cycle that changes no more' if cycles else ''}"
    )


def _about_shapes(setup: ProblemSetup) -> Iterator[str]:
    for place, surface in enumerate(setup.case.surface):
        if surface.kind == "cone" and math.tan(surface.angle) > LARGEST_SIZE:
            key = setup.case.source.problem("", ("surface", place, "cone", "angle")).key
            yield (
                f"{dotted(key)}: {math.degrees(surface.angle):.3g} deg between flank and contact plane is steep (mean"
                f" pressure over E* {0.5 * math.tan(surface.angle):.2g}): {HOLD_TO}"
                f" {math.degrees(math.atan(LARGEST_SIZE)):.2g} deg; is the angle to the axis meant?"
            )
    punch, modulus = setup.closed_forms.punch, setup.model.compliances.contact_modulus
    if punch is not None and punch.delta_z > LARGEST_SIZE * punch.contact_radius:
        depth, mean = punch.delta_z / punch.contact_radius, punch.mean_pressure / modulus
        yield (
            f"load_path: the punch goes deep against its radius (delta_z/a = {depth:.2g}, mean pressure over E*"
            f" {mean:.2g}): {HOLD_TO} delta_z/a = {LARGEST_SIZE:g}; are all units right?"
        )


def _about_friction(setup: ProblemSetup) -> Iterator[str]:
    if "friction" in setup.case.model_fields_set:
        return
    moved, beta = ", ".join(setup.model.moved), setup.model.compliances.dundurs_constant
    if moved or abs(beta) > UNCOUPLED_BELOW:
        differ = f"the bodies differ (Dundurs' constant {beta:.4g}), so that pressing alone would shear them"
        although = f"the load path moves {moved}" if moved else differ
        yield f"friction: not given, so it is 0, although {although}; write friction: 0 if that is meant"


def _about_sliding(setup: ProblemSetup) -> Iterator[str]:
    """Warn of the first stage that ends with a tangential force or a torque alone that friction cannot carry."""
    forms, stages, motion = setup.closed_forms, setup.case.stages(), dict(PAIRS)
    if "friction" not in setup.case.model_fields_set:  # then the missing friction is the warning
        return
    varies = setup.case.friction_varies
    limit, of_torque = ("int b dA", "int b r dA") if varies else ("mu P", "3 pi mu P a/16")
    if varies and setup.model.line:
        limit = "int b dx"
    for stage, load, hertz in zip(stages, forms.loads, forms.hertz, strict=True):
        pressed = load.get("P", hertz.load if hertz else math.inf)
        most_force, most_torque, _ = forms.gross_slip(pressed, hertz, load.get("friction"))
        if varies:
            most_force = min(most_force, pressed * _largest_share(setup, load))
        Qx, Qy, Mz = (abs(load.get(name, 0.0)) for name in ("Qx", "Qy", "Mz"))
        if 0.0 < (force := math.hypot(Qx, Qy)) >= most_force:
            name = "Qx" if Qx >= Qy else "Qy"
            unit = setup.case.dimensions[name].unit
            loads = f"{force:.6g} {unit} is not below the {most_force:.6g} {unit} ({limit})"
        elif Mz > most_torque:
            name, loads = "Mz", f"{Mz:.6g} N mm is not below the {most_torque:.6g} N mm ({of_torque})"
        else:
            continue
        place = dotted(stage.place(name))
        advice = "lower it" if setup.model.line else f"impose {motion[name]} to follow it"
        yield f"{place}: {loads} that friction carries: gross slip ends the run; {advice}"
        return


def _largest_share(setup: ProblemSetup, load: Load) -> float:
    from fretsolve.friction.doubts import largest_share  # few cases need it

    return largest_share(setup.case.friction, load.get("Qx", 0.0), load.get("Qy", 0.0))


def _about_varied_friction(setup: ProblemSetup) -> Iterator[str]:
    """Warn of friction that falls too fast, and of cycles that count as periodic before it has run in."""
    if not setup.case.friction_varies or not setup.model.has_shear:
        return
    from fretsolve.friction.doubts import doubts  # few cases need them

    compliance = setup.model.compliances.tangential
    yield from doubts(setup.case.friction, setup.load_path.stages, setup.closed_forms.largest, compliance)


def _about_resolution(setup: ProblemSetup) -> Iterator[str]:
    cells = cells_across(setup)
    if cells is not None and cells < FEWEST_CELLS:
        yield (
            f"grid.points: only {_in_cells(cells)} cells across the contact;"
            f" {FEWEST_CELLS} or more are needed for errors below a few per cent"
        )
    stick = setup.closed_forms.smallest_stick
    across = 2.0 * stick.value / max(setup.grid.dx, setup.grid.dy) if stick is not None else math.inf
    if stick is not None and across < FEWEST_STICK_CELLS:
        yield (
            f"grid.points: the stick zone shrinks to {_in_cells(across)} cells across in stage {stick.stage + 1}"
            f" ({stick.source}: c = {stick.value:.3g} mm); its size is reliable from {FEWEST_STICK_CELLS} cells on"
        )


def _about_edges(setup: ProblemSetup) -> Iterator[str]:
    """Warn of sharp ends, and of roundings that cells do not resolve."""
    side = max(setup.grid.dx, setup.grid.dy)
    if (line := cylinder_contact(setup)) is not None:
        yield from _about_end(setup, line)
    for place, surface in enumerate(setup.case.surface):
        radius = rounding(surface)
        if surface.kind == "cylinder" and surface.crown_radius and setup.closed_forms.largest is not None:
            continue  # the contact ends before the cylinder
        if surface.kind == "cylinder" and radius == 0.0:
            key = setup.case.source.problem("", ("surface", place, "cylinder", "length")).key
            yield (
                f"{dotted(key)}: the ends of the cylinder are sharp, so that the pressure there is infinite and the"
                " largest one depends on the grid; end_radius rounds them"
            )
        if radius and radius < side:
            name = "end_radius" if surface.kind == "cylinder" else "edge_radius"
            key = setup.case.source.problem("", ("surface", place, surface.kind, name)).key
            yield (
                f"{dotted(key)}: the rounding of {radius:.3g} mm fits into a cell of {side:.3g} mm, so that the edge"
                " counts as sharp: the largest pressure is much too small"
            )


def _about_end(setup: ProblemSetup, contact: HertzLine) -> Iterator[str]:
    """Warn of the ends of a cylinder that reaches the grid's edge, or whose rounding the contact hardly enters."""
    surface, grid = setup.case.surface[0], setup.grid
    if surface.kind != "cylinder":
        return
    if surface.length is None:
        key = setup.case.source.problem("", ("surface", 0, "cylinder")).key
        yield (
            f"{dotted(key)}: it has no ends, so that it ends at the grid's edge, where the pressure is infinite and"
            " the largest one depends on the grid; plane: strain has no ends, length ends it within the grid"
        )
        return
    radius, modulus = surface.end_radius or 0.0, setup.model.compliances.contact_modulus
    cell = math.hypot(grid.dx * math.cos(surface.axis), grid.dy * math.sin(surface.axis))
    depth = depth_in_rounding(CYLINDER_END * contact.max_pressure * math.sqrt(contact.half_width), radius, modulus)
    if radius >= max(grid.dx, grid.dy) and depth < FEWEST_END_CELLS * cell:
        key = setup.case.source.problem("", ("surface", 0, "cylinder", "end_radius")).key
        yield (
            f"{dotted(key)}: the contact reaches about {depth:.2g} mm into the rounding of the ends, and"
            f" cells are {cell:.2g} mm along the cylinder: the largest pressure, there, depends on the grid"
        )


def cylinder_contact(setup: ProblemSetup) -> HertzLine | None:
    """Return Hertz's line contact of a straight cylinder on an area; one without ends ends with the grid."""
    if setup.model.line:
        return None
    surface, grid = setup.case.surface[0], setup.grid
    endless = None
    if surface.kind == "cylinder" and surface.length is None and setup.case.grid.size is not None:
        along = (abs(math.cos(surface.axis)), abs(math.sin(surface.axis)))
        endless = min(side / part for side, part in zip(grid.size, along, strict=True) if part > 1e-9)
    return setup.closed_forms.cylinder(endless)


def _about_heights(setup: ProblemSetup) -> Iterator[str]:
    """Warn of height maps that are too steep, or finer than the cells, if flattening what these miss takes a part of
    the pressure."""
    grid, heights = setup.grid, setup.heights()
    if (slope := heights.slope()) > STEEPEST_MAP:
        yield (
            f"surface: the root mean square slope of the height map is {slope:.2g}: half-spaces and linear elasticity"
            " hold for slopes small against 1; are unit and spacing right, and missing points nan?"
        )
    if (needed := heights.flattening_pressure((grid.dx, grid.dy))) > 0.0:
        nx, ny = heights.resolving_points(grid.size, grid.shape)
        coarse = " as far as the map does, which has few points per wave itself" if heights.too_coarse() else ""
        yield (
            f"grid.points: {grid.nx} x {grid.ny} cells miss waves of the height map that take {needed:.3g} MPa to"
            f" flatten; {nx} x {ny} points would resolve them{coarse}"
        )


def _about_solver(setup: ProblemSetup) -> Iterator[str]:
    """Warn of a loose tolerance, and of settings in the case that fall short of those that its accuracy would pick."""
    accuracy, tolerance, path = setup.case.solver.accuracy, setup.case.solver.tolerance, setup.load_path
    if tolerance > 1e-3:  # residuals then show in the digits that people read
        yield (
            f"solver.tolerance: {tolerance:g} lets the contact conditions be violated by {percent(tolerance)}, so no"
            " digit is reliable; 1e-6 is usual"
        )
    if accuracy is None:
        return
    wanted = f"that accuracy {percent(accuracy)} picks"
    (nx, ny), (more_x, more_y) = (
        setup.grid.shape,
        points_needed(setup.closed_forms, path, setup.grid.size, setup.heights),
    )
    if nx < more_x or ny < more_y:
        yield f"grid.points: {nx} x {ny} are fewer than the {more_x} x {more_y} {wanted}; leave them out to meet it"
    short = [number for number, count in enumerate(path.counts) if count < path.needed[number]]
    if short:
        stage, count, needed = setup.case.stages()[short[0]], path.counts[short[0]], path.needed[short[0]]
        more = f", and {len(short) - 1} more stages have too few" if len(short) > 1 else ""
        key = f"{dotted(stage.key)}.increments"
        yield f"{key}: {count} are fewer than the {needed} {wanted}{more}; leave them out to meet it"


def _about_hertz(setup: ProblemSetup) -> Iterator[str]:
    """Warn of a contact by Hertz that is too large for the theory, for the motions or for the grid."""
    hertz, modulus = setup.closed_forms.largest, setup.model.compliances.contact_modulus
    if hertz is None:
        return
    if hertz.size_over_radius > LARGEST_SIZE:
        yield (
            f"load_path: the contact is large against the radius (a/R = {hertz.size_over_radius:.2g}, p0/E* ="
            f" {hertz.max_pressure / modulus:.2g}): {HOLD_TO} a/R = {LARGEST_SIZE:g}; are all units right?"
        )
    radius = min(hertz.half_extent)
    for load, name in product(setup.load_path.imposed, ("delta_x", "delta_y", "phi_z")):
        motion = abs(load.get(name, 0.0)) * (radius if name == "phi_z" else 1.0)
        if motion > radius:
            yield (
                f"load_path: {name} moves the surfaces by {motion / radius:.2g} contact radii, but both keep their"
                " places on the grid: motions must be small against the contact"
            )
    if setup.case.grid.size is None:
        return
    grid, center = setup.grid, setup.case.surface[0].center
    reach = np.abs(np.subtract(center, grid.center)) + hertz.half_extent
    # The edge of the discrete contact may reach into the next 1.5 cells.
    if (reach > 0.5 * np.array(grid.size) - 1.5 * np.array([grid.dx, grid.dy])).any():
        advised = ", ".join(f"{side:.3g} mm" for side in 2.0 * AREA_MARGIN * reach)
        yield f"grid.size: the contact comes near the grid's edge or reaches it; [{advised}] would leave room"


def _about_yield(setup: ProblemSetup) -> Iterator[str]:
    """Warn of a Hertz contact that would yield below the surface, where a body gives its yield stress."""
    if not any(getattr(body, "yield_stress", None) for body in setup.case.bodies):
        return
    pressure, factor = 0.0, SPHERE_YIELD
    if setup.closed_forms.largest is not None:
        pressure = setup.closed_forms.largest.max_pressure
    elif (line := cylinder_contact(setup)) is not None:
        pressure, factor = line.max_pressure, LINE_YIELD
    elif setup.model.line:
        from fretsolve.setup.line_forms import LineClosedForms

        forms = setup.closed_forms
        if isinstance(forms, LineClosedForms) and forms.source == "Hertz" and forms.widest is not None:
            pressure, factor = forms.widest.max_pressure, LINE_YIELD
    for number, body in enumerate(setup.case.bodies):
        limit = factor * (getattr(body, "yield_stress", None) or math.inf)
        if pressure > limit:
            yield (
                f"bodies.{number}.yield_stress: p0 = {pressure:.4g} MPa is above {factor:g} times the yield stress,"
                f" {limit:.4g} MPa, from where body {number + 1} yields below the surface: the solution is elastic"
            )


def _about_line(setup: ProblemSetup) -> Iterator[str]:
    """Warn of the contact of a cylinder or of a line that is too large for the theory or for the grid."""
    if (line := cylinder_contact(setup)) is not None:
        yield from _about_width(line.half_width / line.radius)
    if not setup.model.line:
        return
    from fretsolve.setup.line_forms import LineClosedForms

    forms, grid, surface = setup.closed_forms, setup.grid, setup.case.surface[0]
    if not isinstance(forms, LineClosedForms) or (contact := forms.widest) is None:
        return
    if surface.kind == "cylinder":
        yield from _about_width(contact.half_width / surface.radius)
    reach = abs(surface.center[0] - grid.x0) + contact.half_width
    if setup.case.grid.size is not None and reach > 0.5 * grid.size[0] - 1.5 * grid.dx:
        advised = f"{2.0 * AREA_MARGIN * reach:.3g} mm"
        yield f"grid.size: the contact comes near the grid's edge or reaches it; {advised} would leave room"


def _about_wear(setup: ProblemSetup) -> Iterator[str]:
    """Warn of wear without cycles that wear, of slip that is long for the contact, and of a scar beyond the grid."""
    if setup.case.wear is None:
        return
    from fretsolve.setup.wear_forms import SLIP_PER_RADIUS, worn_cycles, worn_radius  # few cases have wear

    if not any(stage.cycle is not None and stage.cycle.jumps is not None for stage in setup.case.stages()):
        yield (
            "wear: no cycle represents others, so that worn depth is counted and the surfaces keep their shape;"
            " represents in place of times changes them"
        )
        return
    cycles, grid = worn_cycles(setup.closed_forms), setup.grid
    for cycle in cycles:
        if cycle.sliding_distance > SLIP_PER_RADIUS * cycle.hertz.contact_radius:
            yield (
                f"wear: half a cycle slips {cycle.sliding_distance:.3g} mm,"
                f" {percent(cycle.sliding_distance / cycle.hertz.contact_radius)} of the contact radius, but worn"
                f" profiles keep their places on the grid; {percent(SLIP_PER_RADIUS)} or less are needed"
            )
            break
    if setup.case.grid.size is None:
        if not cycles:
            yield "grid.size: auto does not know how far wear widens this contact; a size that leaves room is needed"
        return
    reach = worn_radius(setup.closed_forms) + max(map(abs, np.subtract(setup.case.surface[0].center, grid.center)))
    if reach > 0.5 * min(grid.size) - 1.5 * max(grid.dx, grid.dy):
        yield (
            f"grid.size: the worn contact may reach {reach:.3g} mm from the grid's middle, to its edge or beyond;"
            f" {2.0 * AREA_MARGIN * reach:.3g} mm would leave room"
        )


def _about_width(share: float) -> Iterator[str]:
    if share > LARGEST_SIZE:
        yield (
            f"load_path: the contact is large against the radius (a/R = {share:.2g}):"
            f" {HOLD_TO} a/R = {LARGEST_SIZE:g}; are all units right?"
        )


def cells_across(setup: ProblemSetup) -> float | None:
    """Return the cells across the contact where it is largest, along the axis with fewer; None without a closed form.

    Cells may be as slender as the contact.
    """
    grid, surface, hertz = setup.grid, setup.case.surface[0], setup.closed_forms.largest
    if hertz is not None:
        cosine, sine = math.cos(hertz.angle), math.sin(hertz.angle)
        along = (math.hypot(grid.dx * cosine, grid.dy * sine), math.hypot(grid.dx * sine, grid.dy * cosine))
        return min(2.0 * axis / cell for axis, cell in zip(hertz.semi_axes, along, strict=True))
    width = setup.closed_forms.contact_width(max(grid.size))
    if width is None:
        cells = grid.nx if setup.model.line else min(grid.shape)
        return cells / AREA_MARGIN if setup.case.grid.size is None else None
    if surface.kind == "cylinder":
        return width / math.hypot(grid.dx * math.sin(surface.axis), grid.dy * math.cos(surface.axis))
    return width / max(grid.dx, grid.dy)


def warning_of_result(setup: ProblemSetup, contact_cells: DoubleArray) -> str | None:
    """Warn if the contact had too few cells in all increments, where no closed form could warn before the run."""
    most, needed = int(contact_cells.max(initial=0)), math.ceil(0.25 * math.pi * FEWEST_CELLS**2)
    needed = FEWEST_CELLS if setup.model.line else needed
    if not len(contact_cells) or cells_across(setup) is not None or most >= needed:
        return None
    like = "" if setup.model.line else f", as many as a round contact of {FEWEST_CELLS} cells across has"
    return (
        f"grid.points: the contact has at most {most} cell{'s' * (most != 1)}; errors below a few per cent need"
        f" {needed} or more{like}"
    )


def _in_cells(number: float) -> str:
    """Write a number of cells, never rounded up to a limit that it misses."""
    return f"{number:.2g}" if number < 1.0 else f"{math.floor(10.0 * number) / 10.0:.1f}"
