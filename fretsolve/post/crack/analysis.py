"""Compute a crack from the tractions of a result: stress intensities, range, verdict and lives, with error bars.

Errors of stress intensities are those of the fit of the weight, and the difference to tractions averaged over blocks of
two cells. K converges like the cells' side to the power 1.5, since a cell at the edge of contact is loaded as a whole
or not at all. How much of it the contact covers differs from grid to grid, and from cells to blocks, so that the whole
difference is taken, where an order alone would give 0.55 of it. A crack shorter than a cell sees the stress of the
surface, which converges like the root of the side, so that its error is 1/(sqrt(2) - 1) times the difference.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fretsolve.case.keys.material_spec import Material
from fretsolve.case.keys.output_spec import LIFE_CURVES, LifeCriterion
from fretsolve.errors import CaseError
from fretsolve.post.crack.growth import Growth, GrowthRule, difference, stress_range, threshold_of, together
from fretsolve.post.crack.place import Place, at_edge, at_largest, at_length, contact_steps
from fretsolve.post.crack.request import CrackRequest
from fretsolve.post.crack.stress_intensity import WEIGHT_ERROR
from fretsolve.post.crack.stress_line import StressLine, stress_line
from fretsolve.post.fatigue.criteria import fatigue_field, shear_strain_lives, swt_lives
from fretsolve.post.fatigue.material import placed
from fretsolve.post.stress.cycles import LoadCycle, chosen, cycles_of, require_states, states_of, within
from fretsolve.post.stress.influence import Body
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.system.arrays import DoubleArray

SHORTEST, LONGEST_USUAL, LONGEST = 0.01, 5.0, 1000.0
"""Lengths of the crack over the half-width of the contact: the shortest, the longest one at least, and at most."""

PER_DECADE = 30

BELOW_A_CELL = 1.0 / (math.sqrt(2.0) - 1.0)
"""Error over the difference to blocks of two cells where cracks are shorter than a cell."""

LIVES = {"swt": swt_lives, "fatemi-socie": shear_strain_lives}


@dataclass(frozen=True, eq=False)
class Crack:
    """A crack of many lengths (mm) at a place; stress intensities in MPa m^0.5, lives in cycles.

    half_width: of the contact (mm); K, K_error: (2, steps, lengths) of K_I and K_II; cycles: their states are places in
    `steps`; cycle_ranges: (cycles, lengths); range_error: of the largest of them; initiation: cycles to a crack of each
    length. growth, shortest, longest: from the ranges, from ranges with their errors, and less their errors;
    of_cycles: under each cycle alone.
    missing: one line for each thing that cannot be computed.
    """

    body: Body
    place: Place
    half_width: float
    cell: float
    steps: tuple[int, ...]
    lengths: DoubleArray
    K: DoubleArray
    K_error: DoubleArray
    cycles: tuple[LoadCycle, ...]
    cycle_ranges: DoubleArray
    range_error: DoubleArray
    threshold: DoubleArray | None
    initiation: DoubleArray | None
    growth: Growth
    shortest: Growth
    longest: Growth
    of_cycles: tuple[Growth, ...]
    material: Material
    criterion: LifeCriterion | None
    missing: tuple[str, ...]

    @property
    def range(self) -> DoubleArray:
        """The largest range of all cycles, (lengths,)."""
        return np.asarray(self.cycle_ranges.max(axis=0))

    @property
    def verdict(self) -> str | None:
        """The verdict in words, None without thresholds."""
        arrest = self.growth.arrest
        if arrest is None:
            return None
        return "no crack" if arrest == 0.0 else "goes through" if math.isinf(arrest) else "arrests"

    @property
    def values(self) -> dict[str, float]:
        """What is known of arrest and life, with error bars, by names."""
        growth, bounds = self.growth, (self.shortest, self.longest)
        found = {
            "half_width": self.half_width,
            "arrest_length": growth.arrest,
            "final_length": growth.end,
            "life": growth.life,
            "initiation_length": growth.first,
            "crossing_length": growth.crossing,
        }
        for name, value, others in (
            ("arrest_length_error", growth.arrest, [one.arrest for one in bounds]),
            ("life_error", growth.life, [one.life for one in bounds]),
        ):
            if value is not None:
                found[name] = difference(value, *(math.inf if one is None else one for one in others))
        return {name: float(value) for name, value in found.items() if value is not None}


def crack_of(tractions: TractionHistory, request: CrackRequest) -> Crack:
    """Return the crack that is asked for. Raises CaseError."""
    result = tractions.result
    body = _body(tractions, request)
    with placed(lambda message: request.problem(request.cycles_key, message)):
        absolute = chosen(cycles_of(result), request.cycles)
    with placed(lambda message: CaseError(message, (), result.path)):
        for one in absolute:
            require_states(one, result.steps)
        steps = states_of(absolute, result.steps)
        touching = contact_steps(tractions, steps)
    cycles = tuple(_within(absolute, steps))
    source = request.material.with_elastic_constants(result.effective_case["bodies"][body - 1])
    if request.at == "max":
        source.require((request.require_curve(),))
    line = stress_line(tractions, steps, body)
    with placed(lambda message: request.problem("at", message)):
        if request.at == "edge":
            place = at_edge(tractions, line)
        elif request.at == "max":
            place = at_largest(tractions, line, cycles, request.require_curve(), source.material)
        else:
            place = at_length(tractions, steps, request.at)
    half_width = max(float(result.history["contact_half_width_x"][step]) for step in touching)
    return _analysed(line, place, half_width, tractions.grid.dx, cycles, source.material, request)


def _within(cycles: Sequence[LoadCycle], steps: Sequence[int]) -> list[LoadCycle]:
    """Return cycles with their states as places among `steps`."""
    return [one for cycle in cycles for one in within([cycle], steps)]


def _states(values: DoubleArray, cycle: LoadCycle, axis: int = 0) -> DoubleArray:
    """Return values in the states of a cycle, which lie along `axis`; 0 first if the cycle begins unloaded."""
    return cycle.with_rest(np.take(values, cycle.states, axis), axis)


def _body(tractions: TractionHistory, request: CrackRequest) -> Body:
    elastic = tractions.poisson_ratios
    if request.body is None:
        return 2 if 2 in elastic else 1
    if request.body not in elastic:
        raise request.problem("body", f"body {request.body} is rigid, so that it does not crack; leave it out")
    return request.body


def _analysed(
    line: StressLine,
    place: Place,
    half_width: float,
    cell: float,
    cycles: tuple[LoadCycle, ...],
    material: Material,
    request: CrackRequest,
) -> Crack:
    lengths, K = _stress_intensities(line, place, half_width, material, request)
    factor = np.where(lengths < cell, BELOW_A_CELL, 1.0)
    K_error = factor * np.abs(K[:, 1:] - K[:, :1]).max(axis=1) + WEIGHT_ERROR * np.abs(K[:, 0])
    exponent = 1.0 if material.paris is None else material.paris.walker_exponent
    of_cycles = np.stack([stress_range(_states(K[0], one, 1), exponent) for one in cycles], axis=1)
    largest = np.maximum(K[0], 0.0).max(axis=1)  # (1 + averages, lengths)
    ranges, most = of_cycles[0], largest[0]
    errors = factor * np.abs(of_cycles[1:] - ranges).max(axis=0) + WEIGHT_ERROR * most
    most_error = factor * np.abs(largest[1:] - most).max(axis=0) + WEIGHT_ERROR * most
    initiation, missing_curve = _initiation(line, place, lengths, factor, cycles, material, request.life_criterion)
    times = tuple(one.times for one in cycles)
    rule = GrowthRule(material, times, request.last_length)
    growth, shortest, longest = (
        rule.growth(
            lengths,
            np.maximum(ranges + sign * errors, 0.0),
            most + sign * most_error,
            None if initiation is None else together(initiation[index], times),
        )
        for index, sign in enumerate((0.0, 1.0, -1.0))
    )
    alone = GrowthRule(material, (1.0,), request.last_length)
    of_each = [
        alone.growth(lengths, ranges[[index]], K[0, 0, list(one.states)].max(axis=0), first)
        for index, one in enumerate(cycles)
        for first in [None if initiation is None else initiation[0, index]]
    ]
    threshold = threshold_of(material)
    return Crack(
        line.body,
        place,
        half_width,
        cell,
        line.steps,
        lengths,
        K[:, 0],
        K_error,
        cycles,
        ranges,
        errors[ranges.argmax(axis=0), np.arange(len(lengths))],
        None if threshold is None else threshold(lengths),
        None if initiation is None else together(initiation[0], times),
        growth,
        shortest,
        longest,
        tuple(of_each),
        material,
        request.life_criterion,
        tuple(_missing(material, request, growth, lengths, missing_curve)),
    )


def crack_lengths(half_width: float, begin: int, longest: float) -> DoubleArray:
    """Return lengths from number `begin` on, equally spaced in their logarithm, to `longest` (mm) at least."""
    last = math.ceil(PER_DECADE * math.log10(longest / (SHORTEST * half_width)) - 1e-9)
    return np.asarray(SHORTEST * half_width * 10.0 ** (np.arange(begin, max(last, begin) + 1) / PER_DECADE))


def _stress_intensities(
    line: StressLine, place: Place, half_width: float, material: Material, request: CrackRequest
) -> tuple[DoubleArray, DoubleArray]:
    """Return lengths, and the stress intensities (2, 1 + averages, steps, lengths) of cracks of these lengths."""
    final = request.last_length
    if final is not None and final <= (shortest := SHORTEST * half_width):
        message = (
            f"{final:g} mm is out of range; a length above {shortest:.3g} mm, a hundredth of the half-width of the"
        )
        key = "thickness" if request.final_length is None else "final-length"
        raise request.problem(key, f"{message} contact, is needed")
    lengths = crack_lengths(half_width, 0, max(LONGEST_USUAL * half_width, final or 0.0))
    K = line.stress_intensity((place.x, place.y), lengths)
    if material.paris is None or material.toughness is None or final is not None:
        return lengths, K
    while K[0, 0].max() < material.toughness and lengths[-1] < LONGEST * half_width:
        longer = min(10.0 * float(lengths[-1]), LONGEST * half_width)
        more = crack_lengths(half_width, len(lengths), longer)
        lengths = np.append(lengths, more)
        K = np.concatenate([K, line.stress_intensity((place.x, place.y), more)], axis=-1)
    return lengths, K


def _initiation(
    line: StressLine,
    place: Place,
    lengths: DoubleArray,
    factor: DoubleArray,
    cycles: Sequence[LoadCycle],
    material: Material,
    criterion: LifeCriterion | None,
) -> tuple[DoubleArray | None, str]:
    """Return cycles to a crack under each cycle, (3, cycles, lengths): as computed, fewest, most. Or what is missing.

    They are those of the fatigue parameter at the depth of the length.
    """
    if criterion is None:
        return None, "strain_life or shear_strain_life"
    if getattr(material, LIFE_CURVES[criterion]) is None:
        return None, LIFE_CURVES[criterion]
    try:
        stress = line.stress((place.x, place.y), lengths).transpose(1, 2, 0, 3)
        values = np.array(
            [[fatigue_field(criterion, material, _states(variant, one)).value for one in cycles] for variant in stress]
        )
    except CaseError as error:
        return None, ".".join(map(str, error.key)) or error.message
    errors = factor * np.abs(values[1:] - values[0]).max(axis=0)
    bounds = np.stack([values[0], values[0] + errors, np.maximum(values[0] - errors, 0.0)])
    lives = LIVES[criterion](material, bounds.ravel())
    assert lives is not None
    return lives.reshape(bounds.shape), ""


def _missing(material: Material, request: CrackRequest, growth: Growth, lengths: DoubleArray, curve: str) -> list[str]:
    """Return a line for each thing that cannot be computed, with the key that is missing."""
    found = []
    lacking = [name for name in ("threshold_range", "fatigue_range") if getattr(material, name) is None]
    if lacking:
        found.append(f"no verdict: the material lacks {' and '.join(lacking)}")
    if material.paris is None:
        found.append("no propagation and total life: the material lacks paris")
    elif growth.end is None and material.toughness is None:
        found.append("no propagation and total life: toughness of the material, or a final length, is missing")
    elif growth.end is None:
        found.append(
            f"no propagation and total life: K_I stays below the toughness up to b = {lengths[-1]:.4g} mm; a final"
            " length gives an end"
        )
    if curve:
        found.append(f"no initiation and total life: the material lacks {curve}")
    return found


def notes_of(crack: Crack, *, line: bool, worn: bool) -> list[str]:
    """Return what else is to be said of a crack, a line each. line: of a line contact; worn: with wear."""
    found = []
    closed = crack.K[0] <= 0.0
    if closed.any():
        found.append(
            "where K_I <= 0 the crack is closed, and K_II is an upper bound: contact of its faces is not solved"
        )
    if crack.lengths[0] < crack.cell:
        found.append(
            f"cracks shorter than a cell, {crack.cell:.3g} mm, see the steps of the tractions, as their error bars say"
        )
    if not line:
        found.append(
            "the stress is that of the row through the middle of the contact: K is an estimate for a crack through the"
            " width, and an upper bound for a thumbnail crack"
        )
    if worn:
        found.append("wear: tractions are those of the worn contact, on a half-space that is flat")
    return found


def warnings_of(crack: Crack, request: CrackRequest) -> list[str]:
    """Return warnings about a crack, a line each."""
    found = []
    limit = None if request.thickness is None else 0.1 * request.thickness
    reached = _longest_that_matters(crack)
    if limit is not None and reached > limit:
        found.append(
            f"b up to {reached:.4g} mm counts, more than a tenth of the thickness {request.thickness:g} mm: the body is"
            " no half-plane for such a crack, and K is too small"
        )
    return found


def _longest_that_matters(crack: Crack) -> float:
    """Return the length at which life ends or the crack stops, else the longest one (mm)."""
    growth: Mapping[str, float] = crack.values
    if crack.verdict in ("arrests", "no crack"):
        return growth["arrest_length"]
    return growth.get("final_length", float(crack.lengths[-1]))
