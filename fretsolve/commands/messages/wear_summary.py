"""Describe the wear of a case in lines of text, for `validate`."""

from __future__ import annotations

from collections.abc import Iterator

from fretsolve.case.dimensions import WEAR_COEFFICIENT, in_small_unit, percent
from fretsolve.case.keys.wear_spec import WearSpec
from fretsolve.setup.problem_setup import ProblemSetup
from fretsolve.setup.wear_forms import WornCycle, worn_cycles

LEFT_OUT = "left out: debris between the surfaces, oxidation, plastic flow, the motion of worn profiles over each other"


def wear_lines(setup: ProblemSetup) -> Iterator[str]:
    """Yield the law of wear, what closed forms say of each cycle that stands for others, and what is left out."""
    wear = setup.case.wear
    if wear is None:
        return
    yield f"\n# wear by {_law(wear)}"
    cycles = worn_cycles(setup.closed_forms)
    for cycle in cycles:
        yield from _cycle_lines(cycle, max(setup.grid.dx, setup.grid.dy))
    if not cycles:
        yield "no closed form tells how much wears here"
    yield LEFT_OUT


def _law(wear: WearSpec) -> str:
    parts = f"{percent(wear.share[0], 3)} in body 1, {percent(wear.share[1], 3)} in body 2"
    if wear.alpha is not None:
        return f"the dissipated energy: alpha = {WEAR_COEFFICIENT.shown(wear.alpha)}, {parts}"
    power = "" if wear.exponent is None else f" at {wear.reference_pressure:g} MPa, exponent {wear.exponent:g}"
    return f"pressure and slip (Archard): k = {WEAR_COEFFICIENT.shown(wear.k or 0.0)}{power}, {parts}"


def _cycle_lines(cycle: WornCycle, cell: float) -> Iterator[str]:
    first, last = cycle.stages
    jumps = cycle.jumps
    chosen = f"of {jumps.jump:g}" if jumps.jump is not None else f"by a tolerance of {percent(jumps.tolerance)}"
    yield f"stages {first} to {last} stand for {jumps.represents:g} cycles, in jumps {chosen}"
    yield (
        f"at first a cycle dissipates {cycle.energy:.4g} mJ and wears {cycle.volume_per_cycle:.4g} mm^3,"
        f" {in_small_unit(cycle.depth_per_cycle, 3)} deep on the mean where it slips"
    )
    if cycle.slides:
        yield from _gross_slip_lines(cycle)
    else:
        yield from _partial_slip_lines(cycle)
    most = cycle.explicit_limit(cell)
    beyond = f"; jumps of {jumps.jump:g} are beyond that" if jumps.jump is not None and jumps.jump > most else ""
    yield (
        f"an explicit change of the profile would be stable up to {most:.3g} cycles a jump{beyond}; the implicit one is"
        " for any jump"
    )


def _gross_slip_lines(cycle: WornCycle) -> Iterator[str]:
    distance, volume = in_small_unit(cycle.sliding_distance, 4), cycle.volume_at_first_rate
    yield f"gross slip over {distance} in half a cycle at first; all cycles at that rate wear V = {volume:.4g} mm^3"
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
