"""Warn of doubtful cases: by their theory, loads, resolution and settings. For example::

    for text in case_warnings(set_up(case)):
        print(text)

Each warning is a function of `WARNINGS`, and each text begins with the key of the case file that it is about.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from fretsolve.case.dimensions import percent
from fretsolve.case.history import ACTUATORS, PAIRS
from fretsolve.case.keys.body_specs import PunchSurface
from fretsolve.case.quantities import QuantityError, split_quantity
from fretsolve.errors import KeyPath, dotted
from fretsolve.problem.friction.limit import friction_warnings, largest_share
from fretsolve.problem.model.required_terms import UNCOUPLED_BELOW
from fretsolve.problem.model.rig import driver
from fretsolve.problem.setup.cost_estimate import disk_problem, estimate, memory_problem, rounded_bytes
from fretsolve.problem.setup.map_warnings import about_maps
from fretsolve.problem.setup.picked_settings import AREA_MARGIN, concave_sphere, room_for_coarse_runs, tolerance_needed
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.problem.setup.rig_warnings import about_rig
from fretsolve.problem.setup.wear_warnings import LARGEST_MOTION, wear_warnings
from fretsolve.problem.setup.yield_warnings import about_yield, cylinder_contact, line_contact
from fretsolve.problem.surface.edges import CYLINDER_END, depth_in_rounding, flat_part, rounding
from fretsolve.reference.hertz import HertzLine
from fretsolve.system.arrays import DoubleArray

LARGEST_SIZE = 0.1
"""Contact radius over radius of curvature up to which a half-space and a paraboloid stand for the body. The strains are
about the same at this slope of a cone, and at this approach of a punch over its radius."""

HOLD_TO = "half-spaces and linear elasticity hold to about"

FEWEST_CELLS, FEWEST_STICK_CELLS, FEWEST_END_CELLS = 20, 3, 2
"""Cells across the contact below which results are off by per cents; across the stick zone for its size to count; in
the contact with the rounding of an end, with which the pressure there is 5 % too low."""

SINGLE_ACCURACY = 0.02
"""Least accuracy for which single precision does as well. Its coarse runs have a tolerance of 1e-4, which leaves the
dissipated energy of a sphere sheared to half of mu P a bar of 1.1 % on 90 to 750 points; double precision 0.07 %."""


LARGE_RESULT = 4e9
"""Bytes of a result that are most likely not wanted."""


def case_warnings(setup: ProblemSetup, out: Path | None = None) -> list[str]:
    """Return one sentence per warning. out: the result to come, which may be too large for its disk."""
    texts = [*setup.model.warnings, *(text for about in WARNINGS for text in about(setup))]
    disk = disk_problem(setup, out) if out is not None else None
    errors = concave_sphere(setup.case), memory_problem(setup, estimate(setup).memory), disk
    texts += _about_size(setup) if disk is None else ()
    return list(dict.fromkeys([*texts, *(f"{dotted(error.key)}: {error.message}" for error in errors if error)]))


def _typed(setup: ProblemSetup, *key: str | int) -> str:
    """Return a key as one types it."""
    return dotted(setup.case.source.typed(key))


# What is most likely not meant.


def _about_bare_numbers(setup: ProblemSetup) -> Iterator[str]:
    """Warn of numbers without a unit that are most likely meant in another one than the internal one."""
    for key, name, value in _bare_numbers(setup.case.source.data, ()):
        said = None
        if name == "young_modulus" and value < 1000.0:  # metals and ceramics have more MPa, and fewer GPa
            said = f"{value:g} MPa; is GPa meant?"
        elif name in ("alpha", "k"):
            said = f"{value:g} mm^3/(N mm), {1e3 * value:g} mm^3/J; write which unit is meant"
        elif name in ("angle", "axis", "phi_x", "phi_y", "phi_z") and abs(value) > 2.0 * math.pi:
            said = f"{value:g} rad, {math.degrees(value):.4g} deg; is '{value:g} deg' meant?"
        if said is not None:
            yield f"{_typed(setup, *key)}: {value:g} without a unit is {said}"


def _bare_numbers(value: Any, key: KeyPath) -> Iterator[tuple[KeyPath, str, float]]:
    """Yield the numbers without a unit that may be meant in another one, with their key and its last part."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for part, inner in items:
        yield from _bare_numbers(inner, (*key, part))
    if key and key[-1] in ("young_modulus", "alpha", "k", "angle", "axis", "phi_x", "phi_y", "phi_z"):
        try:
            number, unit = split_quantity(value)
        except QuantityError:  # a word, as of an axis
            return
        if not unit:
            yield key, str(key[-1]), number


def _about_friction(setup: ProblemSetup) -> Iterator[str]:
    """Warn of friction that is not given although something shears the contact."""
    moved, beta = ", ".join(setup.model.moved), setup.model.compliances.dundurs_constant
    if "friction" not in setup.case.model_fields_set and (moved or abs(beta) > UNCOUPLED_BELOW):
        differ = f"the bodies differ (Dundurs' constant {beta:.4g}), so that pressing alone would shear them"
        although = f"the load path moves {moved}" if moved else differ
        yield f"friction: not given, so it is 0, although {although}; write friction: 0 if that is meant"


def _about_size(setup: ProblemSetup) -> Iterator[str]:
    """Warn of a result that is very large because it keeps the fields of many increments."""
    cost = estimate(setup)
    if cost.file < LARGE_RESULT:
        return
    every = setup.case.output.every * math.ceil(cost.file / (0.1 * LARGE_RESULT))
    cycles = any(stage.cycle is not None and stage.cycle.until is None for stage in setup.load_path.stages)
    yield (
        f"output.every: the result takes about {rounded_bytes(cost.file)}, since it keeps fields of {cost.increments}"
        f" increments; output: {{every: {every}}} keeps fewer, output: {{fields: []}} none, and the history has all of"
        f" them{'; until: periodic ends a cycle that changes no more' if cycles else ''}"
    )


# Loads that friction cannot carry.


def _about_sliding(setup: ProblemSetup) -> Iterator[str]:
    """Warn of the first stage that ends with a tangential force or a torque alone that friction cannot carry."""
    forms, varies = setup.closed_forms, setup.case.friction_varies
    if "friction" not in setup.case.model_fields_set:  # then the missing friction is the warning
        return
    limit, of_torque = (
        ("sum of the friction limit", "sum of the friction limit times r") if varies else ("mu P", "3 pi mu P a/16")
    )
    seen = set[object]()
    for stage, load, hertz in zip(setup.case.stages(), forms.loads, forms.hertz, strict=True):
        if (same := tuple(sorted(load.items()))) in seen:  # repeated cycles come back to the same ones
            continue
        seen.add(same)
        pressed = load.get("P", hertz.load if hertz else math.inf)
        most_force, most_torque, _ = forms.gross_slip(pressed, hertz, load.get("friction"))
        Qx, Qy, Mz = (load.get(name, 0.0) for name in ("Qx", "Qy", "Mz"))
        if varies:
            most_force = min(most_force, pressed * largest_share(setup.case.friction, Qx, Qy))
        if 0.0 < (force := math.hypot(Qx, Qy)) >= most_force:
            name = "Qx" if abs(Qx) >= abs(Qy) else "Qy"
            unit = setup.case.dimensions[name].unit
            if most_force == 0.0:
                limit = "P is 0" if pressed == 0.0 else "friction is 0"
            loads = f"{force:.6g} {unit} is not below the {most_force:.6g} {unit} ({limit})"
        elif abs(Mz) > most_torque:
            name, loads = "Mz", f"{abs(Mz):.6g} N mm is not below the {most_torque:.6g} N mm ({of_torque})"
        else:
            continue
        advice = f"impose {driver(setup.model.rig, dict(PAIRS)[name])} to follow it"
        if setup.model.line and setup.case.reference_depth is None:
            advice += ", with a reference_depth"
        advice = "lower it" if setup.model.line and name == "Qy" else advice
        place = _typed(setup, *stage.place(name))
        yield f"{place}: {loads} that friction carries: gross slip ends the run; {advice}"
        return


def _about_varied_friction(setup: ProblemSetup) -> Iterator[str]:
    """Warn of friction that falls too fast, and of cycles that count as periodic before it has run in."""
    if setup.case.friction_varies and setup.model.has_shear:
        stages, material = setup.load_path.stages, setup.model.compliances
        yield from friction_warnings(setup.case.friction, stages, setup.closed_forms.largest, material)


# Contacts that half-spaces, linear elasticity and small motions do not stand for.


def _about_shapes(setup: ProblemSetup) -> Iterator[str]:
    """Warn of a cone that is too steep, and of a punch that goes too deep, for the theory."""
    for place, surface in enumerate(setup.case.surface):
        if surface.kind == "cone" and math.tan(surface.angle) > LARGEST_SIZE:
            yield (
                f"{_typed(setup, 'surface', place, 'cone', 'angle')}: {math.degrees(surface.angle):.3g} deg between"
                f" flank and contact plane is steep (mean pressure over E* {0.5 * math.tan(surface.angle):.2g}):"
                f" {HOLD_TO} {math.degrees(math.atan(LARGEST_SIZE)):.2g} deg; is the angle to the axis meant?"
            )
    punch, modulus = setup.closed_forms.punch, setup.model.compliances.contact_modulus
    if punch is not None and punch.delta_z > LARGEST_SIZE * punch.contact_radius:
        depth, mean = punch.delta_z / punch.contact_radius, punch.mean_pressure / modulus
        yield (
            f"load_path: the punch goes deep against its radius (delta_z/a = {depth:.2g}, mean pressure over E*"
            f" {mean:.2g}): {HOLD_TO} delta_z/a = {LARGEST_SIZE:g}; are all units right?"
        )


def _about_large_contacts(setup: ProblemSetup) -> Iterator[str]:
    """Warn of a contact by Hertz that is large against the radius."""
    hertz, line = setup.closed_forms.largest, line_contact(setup)
    share, pressure = 0.0, ""
    if hertz is not None:
        share = hertz.size_over_radius
        pressure = f", p0/E* = {hertz.max_pressure / setup.model.compliances.contact_modulus:.2g}"
    elif isinstance(line, HertzLine):
        share = line.half_width / line.radius
    elif setup.model.compliances.layer_normal and (surface := setup.case.surface[0]).kind == "sphere":
        # no closed form of a layer that is compressed; the automatic size holds the contact
        share = 0.5 * max(setup.automatic_size()) / AREA_MARGIN / abs(surface.radius)
    if share > LARGEST_SIZE:
        yield (
            f"load_path: the contact is large against the radius (a/R = {share:.2g}{pressure}):"
            f" {HOLD_TO} a/R = {LARGEST_SIZE:g}; are all units right?"
        )


def _about_motions(setup: ProblemSetup) -> Iterator[str]:
    """Warn of motions that are not small against a contact by Hertz."""
    hertz, line = setup.closed_forms.largest, setup.closed_forms.widest
    if hertz is None and line is None:
        return
    radius = line.half_width if line is not None else min(hertz.half_extent) if hertz is not None else 0.0
    loads = zip(setup.load_path.imposed, setup.closed_forms.loads, strict=True)
    for (imposed, load), name in product(loads, ("delta_x", "delta_y", "phi_z")):
        actuator = ACTUATORS[name]
        motion = abs(load.get(name, load.get(actuator, 0.0))) * (radius if name == "phi_z" else 1.0)
        if motion > LARGEST_MOTION * radius:
            named, moves = (actuator, "may move") if actuator in imposed else (name, "moves")
            yield (
                f"load_path: {named} {moves} the surfaces by {motion / radius:.2g} contact radii, but both keep their"
                f" places on the grid: errors are of that order from {LARGEST_MOTION:g} on; is the unit right?"
            )


# Grids that do not hold or resolve the contact.


def _about_room(setup: ProblemSetup) -> Iterator[str]:
    """Warn of a contact that comes near the grid's edge. The edge of the discrete contact may reach 1.5 cells on."""
    grid, center = setup.grid, setup.case.surface[0].center
    hertz, line = setup.closed_forms.largest, setup.closed_forms.widest
    extent = hertz.half_extent if hertz is not None else (line.half_width, 0.0) if line is not None else None
    if setup.case.grid.size is None or extent is None:
        return
    reach = np.abs(np.subtract(center, grid.center)) + extent
    room = 0.5 * np.array(grid.size) - 1.5 * np.array([grid.dx, grid.dy])
    axes = len(grid.axes)  # a line has one
    if (reach > room)[:axes].any():
        sides = [f"{side:.3g} mm" for side in (2.0 * AREA_MARGIN * reach)[:axes]]
        advised = sides[0] if setup.model.line else f"[{', '.join(sides)}]"
        yield f"grid.size: the contact comes near the grid's edge or reaches it; {advised} would leave room"


def _about_resolution(setup: ProblemSetup) -> Iterator[str]:
    """Warn of a contact or a stick zone that few cells lie across, unless error bars judge that."""
    if setup.case.solver.accuracy is not None and setup.case.solver.error_bars:
        return
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


def _about_ends(setup: ProblemSetup) -> Iterator[str]:
    """Warn of a single cylinder that ends with the grid, or whose rounding the contact hardly enters."""
    surface, grid, contact = setup.case.surface[0], setup.grid, cylinder_contact(setup)
    if contact is None or surface.kind != "cylinder":
        return
    if surface.length is None:
        yield (
            f"{_typed(setup, 'surface', 0, 'cylinder')}: it has no ends, so that it ends at the grid's edge, where the"
            " pressure is infinite and the largest one depends on the grid; plane: strain has no ends, length ends it"
            " within the grid"
        )
        return
    radius, modulus = surface.end_radius or 0.0, setup.model.compliances.contact_modulus
    cell = math.hypot(grid.dx * math.cos(surface.axis), grid.dy * math.sin(surface.axis))
    depth = depth_in_rounding(CYLINDER_END * contact.max_pressure * math.sqrt(contact.half_width), radius, modulus)
    if radius >= max(grid.dx, grid.dy) and depth < FEWEST_END_CELLS * cell:
        yield (
            f"{_typed(setup, 'surface', 0, 'cylinder', 'end_radius')}: the contact reaches about {depth:.2g} mm into"
            f" the rounding of the ends, and cells are {cell:.2g} mm along the cylinder: the largest pressure, there,"
            " depends on the grid"
        )


def _about_edges(setup: ProblemSetup) -> Iterator[str]:
    """Warn of sharp ends, and of roundings that cells do not resolve."""
    side = max(setup.grid.dx, setup.grid.dy)
    for place, surface in enumerate(setup.case.surface):
        radius = rounding(surface)
        if surface.kind == "cylinder" and surface.crown_radius and setup.closed_forms.largest is not None:
            continue  # the contact ends before the cylinder
        if surface.kind == "cylinder" and radius == 0.0:
            yield (
                f"{_typed(setup, 'surface', place, 'cylinder', 'length')}: the ends of the cylinder are sharp, so that"
                " the pressure there is infinite and the largest one depends on the grid; end_radius rounds them"
            )
        if radius and radius < side:
            name = "end_radius" if surface.kind == "cylinder" else "edge_radius"
            yield (
                f"{_typed(setup, 'surface', place, surface.kind, name)}: the rounding of {radius:.3g} mm fits into a"
                f" cell of {side:.3g} mm, so that the edge counts as sharp: the largest pressure is much too small"
            )
        elif radius and surface.kind == "punch" and len(setup.case.surface) == 1:
            yield from _about_punch(setup, surface, radius)


def _about_punch(setup: ProblemSetup, punch: PunchSurface, radius: float) -> Iterator[str]:
    """Warn of a punch whose contact hardly enters the rounding of its edge."""
    load, flat = setup.closed_forms.largest_force, flat_part(punch, line=setup.model.line)
    if load <= 0.0 or flat <= 0.0:
        return
    # near the edge of the flat part a rigid flat punch has the pressure K / s^(1/2) at the distance s
    factor = load / (math.pi * math.sqrt(2.0 * flat) * (1.0 if setup.model.line else 2.0 * flat))
    depth = depth_in_rounding(factor, radius, setup.model.compliances.contact_modulus)
    side = max(setup.grid.dx, setup.grid.dy)
    if depth < FEWEST_END_CELLS * side:
        yield (
            f"{_typed(setup, 'surface', 0, 'punch', 'edge_radius')}: the contact reaches about {depth:.2g} mm into the"
            f" rounding of the edge, and cells are {side:.2g} mm: the largest pressure, there, depends on the grid"
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
        if setup.case.grid.size is not None:
            return None
        bars = setup.case.solver.error_bars
        rooms = ((cells, room_for_coarse_runs(cells) if bars else 1.0) for cells in grid.shape[: len(grid.axes)])
        return min(cells / (AREA_MARGIN * room) for cells, room in rooms)
    if surface.kind == "cylinder":
        return width / math.hypot(grid.dx * math.sin(surface.axis), grid.dy * math.cos(surface.axis))
    return width / max(grid.dx, grid.dy)


def warning_of_result(setup: ProblemSetup, contact_cells: DoubleArray) -> str | None:
    """Warn if the contact had too few cells in all increments, where no closed form could warn before the run."""
    most, needed = int(contact_cells.max(initial=0)), math.ceil(0.25 * math.pi * FEWEST_CELLS**2)
    needed = FEWEST_CELLS if setup.model.line else needed
    if not len(contact_cells) or cells_across(setup) is not None or most >= needed:
        return None
    if not most:
        return "load_path: the bodies never touch; a force P > 0 N, or a larger approach delta_z, presses them together"
    like = "" if setup.model.line else f", as many as a round contact of {FEWEST_CELLS} cells across has"
    return (
        f"grid.points: the contact has at most {most} cell{'s' * (most != 1)}; errors below a few per cent need"
        f" {needed} or more{like}"
    )


def _in_cells(number: float) -> str:
    """Write a number of cells, never rounded up to a limit that it misses."""
    return f"{number:.2g}" if number < 1.0 else f"{math.floor(10.0 * number) / 10.0:.1f}"


# Settings that fall short.


def _about_solver(setup: ProblemSetup) -> Iterator[str]:
    """Warn of a loose tolerance, and of a precision or tolerance that falls short of the case's accuracy."""
    solver = setup.case.solver
    if solver.tolerance > 1e-3:  # residuals then show in the digits that people read
        yield (
            f"solver.tolerance: {solver.tolerance:g} lets the contact conditions be violated by"
            f" {percent(solver.tolerance)}, so no digit is reliable; 1e-6 is usual"
        )
    if solver.accuracy is None:
        return
    accuracy = solver.accuracy.target
    needed = tolerance_needed(accuracy)
    if solver.precision == "single":
        if accuracy < SINGLE_ACCURACY:
            yield (
                f"solver.precision: single has too few digits for accuracy {percent(accuracy)} in many cases; take"
                f" double, or an accuracy of {percent(SINGLE_ACCURACY)} or more"
            )
    elif solver.tolerance > 5.0 * needed:  # from where it may show in the bars
        yield (
            f"solver.tolerance: {solver.tolerance:g} is looser than the {needed:g} that accuracy {percent(accuracy)}"
            " picks; leave it out to meet it"
        )


def _about_wear(setup: ProblemSetup) -> Iterator[str]:
    if setup.case.wear is not None:
        yield from wear_warnings(setup)


WARNINGS: tuple[Callable[[ProblemSetup], Iterator[str]], ...] = (
    _about_bare_numbers,
    _about_shapes,
    _about_friction,
    _about_sliding,
    _about_varied_friction,
    _about_resolution,
    _about_ends,
    _about_edges,
    about_maps,
    _about_solver,
    _about_large_contacts,
    _about_motions,
    about_rig,
    _about_room,
    about_yield,
    _about_wear,
)
"""All warnings, in the order in which they are printed."""
