"""Describe a case in lines of text, for `run` and `validate`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from fretsolve.case.dimensions import LENGTH, NUMBER, WEAR_COEFFICIENT, Dimension, counted, in_small_unit, percent
from fretsolve.case.history import DIMENSIONS_BY_NAME, moment_sign
from fretsolve.case.keys.unrolled_path import Stage
from fretsolve.case.keys.wear_spec import WearSpec
from fretsolve.problem.model.required_terms import Model
from fretsolve.problem.setup.cost_estimate import estimate
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.problem.setup.wear_forms import AnyWornCycle, WornCycle, worn_cycles
from fretsolve.reference.materials import material_named
from fretsolve.reference.tangential import full_stick_compliance
from fretsolve.simulation.accuracy.rounds import Round

MOST_STAGES_LISTED = 40


def model_lines(model: Model) -> list[str]:
    """Return one line per part of the model: whether it is kept, and why."""
    width = max(len(one.part) for one in model.decisions)
    return [f"{one.part:{width}}  {'on ' if one.kept else 'off'}  {one.reason}" for one in model.decisions]


def model_table(setup: ProblemSetup) -> Iterator[str]:
    """Yield the parts of the model as a table: share of memory and time, what each takes, and why it is kept."""
    shares = estimate(setup).shares
    memory, seconds = map(sum, zip(*shares.values(), strict=True))
    width = max(len(one.part) for one in setup.model.decisions)
    yield f"{'part':{width}}       {'memory':>6}  {'time':>5}  what and why"
    for one in setup.model.decisions:
        if not one.kept:
            yield f"{one.part:{width}}  off  {'':13}  {one.reason}"
            continue
        of_memory, of_time = shares[one.part][0] / memory, shares[one.part][1] / seconds
        yield f"{one.part:{width}}  on   {of_memory:6.0%}  {of_time:5.0%}  {one.takes}: {one.reason}"


def material_lines(setup: ProblemSetup) -> Iterator[str]:
    """Yield a line on each body of a named material: the source of its constants, and what the case changes."""
    for number, body in enumerate(setup.case.bodies, start=1):
        if body == "rigid" or body.material is None:
            continue
        if (found := material_named(body.material)) is not None:
            changed = [name for name, value in found.constants.items() if getattr(body, name) != value]
            but = f"; the case changes {' and '.join(changed)}" if changed else ""
            yield f"body {number}: {found.name}, by {found.source}{but}"


def layer_lines(setup: ProblemSetup) -> Iterator[str]:
    """Yield a line on what a layer between the bodies adds, over what the bodies give where a closed form has that."""
    pair, forms, said = setup.model.compliances, setup.closed_forms, list[str]()
    line, area = forms.widest, forms.largest
    size = line.half_width if line is not None else min(area.half_extent) if area is not None else None
    if pair.layer_shear:
        said.append(f"it shears by L = {pair.layer_shear:.4g} mm/MPa")
        if size is not None and pair.torsional:
            said.append(f"L E'/a = {2.0 * pair.layer_shear / (pair.torsional * size):.3g}")
        if area is not None and (stick := forms.full_stick(area)) is not None:
            share = 1.0 - full_stick_compliance(area.contact_radius, pair.tangential) / stick
            said.append(f"{percent(share, 3)} of the motion while nothing slips")
    if pair.layer_normal:
        said.append(f"it is compressed by {pair.layer_normal:.4g} mm/MPa, so that no closed form gives the contact")
    if said:
        yield f"layer: {', '.join(said)}"


def grid_line(setup: ProblemSetup) -> str:
    """Return cells, cell sides and size of the grid, and whether the size is automatic."""
    grid = setup.grid
    chosen = " (auto)" if setup.case.grid.size is None else ""
    at = f" about ({grid.x0:g}, {grid.y0:g}) mm" if grid.x0 or grid.y0 else ""
    if setup.model.line:
        return f"{grid.nx} cells of {grid.dx:.4g} mm on {grid.size[0]:.4g} mm{chosen}{at}"
    return (
        f"{grid.nx} x {grid.ny} cells of {grid.dx:.4g} x {grid.dy:.4g} mm"
        f" on {grid.size[0]:.4g} x {grid.size[1]:.4g} mm{chosen}{at}"
    )


def mirror_lines(setup: ProblemSetup) -> list[str]:
    """Return a line with the increments that are solved on one half of the grid, or would be with an even number of
    points; none where there are none."""
    count, increments, grid = setup.mirrored_increments, setup.load_path.increments, setup.grid
    if not count and grid.ny % 2 and not setup.model.line:
        even = replace(setup, grid=grid.cut_into(grid.nx, grid.ny + 1))
        advice = "an even number of points along y lets mirror images be solved on the half y > 0"
        return [advice] if even.mirrored_increments else []
    if not count:
        return []
    which = "all increments are" if count == increments else f"the first {counted(count, 'increment')} "
    if count < increments:
        which += "is" if count == 1 else "are"
    return [f"mirror images about y = 0: {which} solved on the half y > 0"]


def accuracy_lines(current: Round) -> list[str]:
    """Return a line with the settings that the accuracy picks for a round, and the limits of further rounds."""
    setup, accuracy = current.setup, current.asked.solver.accuracy
    if accuracy is None:
        return []
    picked = ", ".join(setup.picked) or "nothing: all settings are given"
    most, limits = accuracy.at_most, [f"{accuracy.at_most.cells} cells"]
    limits += [] if most.time is None else [f"{most.time:g} s"]
    rounds = f"; further rounds take at most {' and '.join(limits)}" if current.picked_keys else ""
    return [f"accuracy {percent(accuracy.target)} picks {picked}{rounds}"]


def path_length(setup: ProblemSetup) -> str:
    """Return the number of increments in words, with wear also the one that is likely to be solved."""
    most = counted(setup.load_path.increments, "increment")
    stages = setup.load_path.stages
    if any(stage.wears is not None for stage in stages):
        return f"about {estimate(setup).increments} increments, at most {setup.load_path.increments}"
    return f"at most {most}" if any(stage.cycle and stage.cycle.until for stage in stages) else most


def represented_cycles(setup: ProblemSetup) -> float:
    """Return how many cycles the cycles with wear stand for, 0 without any."""
    if setup.case.wear is None:
        return 0.0
    first = {stage.wears for stage in setup.load_path.stages if stage.wears is not None and stage.wears.turn == 1}
    return sum(cycle.jumps.represents for cycle in first if cycle.jumps is not None)


def stage_lines(setup: ProblemSetup) -> Iterator[str]:
    """Yield one line per stage: its targets and its number of increments.

    Of the repetitions of a cycle that stands for others the first one is listed.
    """
    stages, path = setup.case.stages(), setup.load_path
    listed = [one for one in zip(stages, path.counts, path.graded, strict=True) if not _is_repeated(one[0])]
    for stage, count, graded in listed[:MOST_STAGES_LISTED]:
        if stage.wears is not None:
            yield f"stage {stage.number}: the surfaces change by the wear of the cycles that the last one stands for"
            continue
        dimensions = {**DIMENSIONS_BY_NAME, **setup.case.dimensions, "friction": NUMBER}
        targets = ", ".join(f"{name} -> {_target(value, dimensions[name])}" for name, value in stage.targets)
        notes = ["auto"] * (stage.increments is None) + ["graded"] * graded
        chosen = f" ({', '.join(notes)})" if notes else ""
        yield f"stage {stage.number}: {targets} in {count} increment{'s' * (count > 1)}{chosen}"
    if len(listed) > MOST_STAGES_LISTED:
        yield f"... and {len(listed) - MOST_STAGES_LISTED} more stages, up to stage {listed[-1][0].number}"
    if len(listed) < len(stages):
        yield f"cycles that stand for others repeat, so that there are at most {len(stages)} stages"
    moments = [name for name in ("Mx", "My") if any(name in dict(stage.targets) for stage in stages)]
    if moments:
        yield moment_sign(moments)


def _is_repeated(stage: Stage) -> bool:
    """Return whether a stage is of a later repetition of a cycle that stands for others."""
    cycle = stage.cycle or stage.wears
    return cycle is not None and cycle.jumps is not None and cycle.turn > 1


def _target(value: float, dimension: Dimension) -> str:
    """Return the value that a stage moves a component to, small displacements in um."""
    return in_small_unit(value) if dimension is LENGTH else f"{value:g} {dimension.unit}".rstrip()


LEFT_OUT = "left out: debris between the surfaces, oxidation, plastic flow, the motion of worn profiles over each other"


def wear_lines(setup: ProblemSetup) -> Iterator[str]:
    """Yield the law of wear, what closed forms say of each cycle that stands for others, and what is left out."""
    wear = setup.case.wear
    if wear is None:
        return
    yield f"\n# wear by {_law(wear)}"
    cycles = worn_cycles(setup.closed_forms)
    for cycle in cycles:
        yield from _cycle_lines(cycle, setup.grid.dx if setup.model.line else max(setup.grid.dx, setup.grid.dy))
    if not cycles:
        yield "no closed form tells how much wears here"
    yield LEFT_OUT


def _law(wear: WearSpec) -> str:
    parts = f"{percent(wear.share[0], 3)} in body 1, {percent(wear.share[1], 3)} in body 2"
    if wear.alpha is not None:
        return f"the dissipated energy: alpha = {WEAR_COEFFICIENT.shown(wear.alpha)}, {parts}"
    power = "" if wear.exponent is None else f" at {wear.reference_pressure:g} MPa, exponent {wear.exponent:g}"
    return f"pressure and slip (Archard): k = {WEAR_COEFFICIENT.shown(wear.k or 0.0)}{power}, {parts}"


def _cycle_lines(cycle: AnyWornCycle, cell: float) -> Iterator[str]:
    first, last = cycle.stages
    jumps = cycle.jumps
    chosen = f"of {jumps.jump:g}" if jumps.jump is not None else f"by a tolerance of {percent(jumps.tolerance)}"
    per = "" if isinstance(cycle, WornCycle) else "/mm"
    yield f"stages {first} to {last} stand for {jumps.represents:g} cycles, in jumps {chosen}"
    yield (
        f"at first a cycle dissipates {cycle.energy:.4g} mJ{per} and wears {cycle.volume_per_cycle:.4g} mm^3{per},"
        f" {in_small_unit(cycle.depth_per_cycle, 3)} deep on the mean where it slips"
    )
    if isinstance(cycle, WornCycle) and not cycle.slides:
        yield from _partial_slip_lines(cycle)
    else:
        yield from _gross_slip_lines(cycle, per)
    most = cycle.explicit_limit(cell)
    beyond = f"; jumps of {jumps.jump:g} are beyond that" if jumps.jump is not None and jumps.jump > most else ""
    yield (
        f"an explicit change of the profile would be stable up to {most:.3g} cycles a jump{beyond}; the implicit one is"
        " for any jump"
    )


def _gross_slip_lines(cycle: AnyWornCycle, per: str) -> Iterator[str]:
    distance, worn = in_small_unit(cycle.sliding_distance, 4), f"{cycle.volume_at_first_rate:.4g} mm^3{per}"
    yield f"gross slip over {distance} in half a cycle at first; all cycles at that rate wear V = {worn}"
    if (scar := cycle.scar) is not None:
        depth, delta_z = in_small_unit(max(scar.center_depth, 0.0), 3), in_small_unit(scar.delta_z, 4)
        yield (
            f"with that volume (V/V0 = {cycle.time:.3g}) the scar has a = {scar.scar_radius:.4g} mm and is"
            f" {depth} deep, delta_z = {delta_z}, mean pressure"
            f" {scar.mean_pressure:.4g} MPa (uniform pressure)"
        )


def _partial_slip_lines(cycle: WornCycle) -> Iterator[str]:
    yield (
        f"partial slip outside of c = {cycle.slip.stick_radius:.4g} mm; all cycles at that rate would wear"
        f" {cycle.volume_at_first_rate:.4g} mm^3 (T = {cycle.time:.3g})"
    )
    if cycle.coupled:
        yield "these are of like bodies: between unlike ones no closed form holds, and the stick zone may change"
    if (limit := cycle.limit) is not None:
        kept = f"delta_z = {in_small_unit(limit.delta_z, 4)}" if cycle.load_kept else f"P = {limit.load:.4g} N"
        yield (
            f"the worn limit, near from T = 100 on, has V = {limit.volume:.4g} mm^3, a scar of"
            f" {limit.scar_radius:.4g} mm and {kept}, with the same c (Popov)"
        )
