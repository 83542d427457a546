"""Compute a crack from the tractions of a result: stress intensities, range, verdict and lives, with error bars.

Errors of stress intensities are those of the fit of the weight, and a multiple of the difference to tractions averaged
over blocks of two cells. K converges like the cells' side to the power 1.5, since a cell at the edge of contact is
loaded as a whole or not at all. How much of it the contact covers differs from grid to grid, from cells to blocks and
from state to state. So one bar serves a length: that of the largest difference, of K_I and K_II and in all states.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass

import numpy as np

from fretsolve.case.keys.material_spec import Material
from fretsolve.case.keys.output_spec import LIFE_CURVES, LifeCriterion
from fretsolve.errors import CaseError
from fretsolve.post.crack.growth import Growth, GrowthRule, difference, stress_range, threshold_of
from fretsolve.post.crack.place import CrackPlace, at_edge, at_largest, at_length, rows_of_contact
from fretsolve.post.crack.request import CrackRequest
from fretsolve.post.crack.stress_intensity import WEIGHT_ERROR
from fretsolve.post.crack.stress_line import StressLine, stress_line
from fretsolve.post.fatigue.criteria import fatigue_field, lives_of
from fretsolve.post.fatigue.material import placed
from fretsolve.post.fatigue.over_cycles import miner_life
from fretsolve.post.fatigue.stress_cycle import opening_of
from fretsolve.post.stress.cycles import LoadCycle, chosen, cycles_of, require_states, states_of, within
from fretsolve.post.stress.influence import Body
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.system.arrays import DoubleArray

SHORTEST, LONGEST_USUAL, LONGEST = 0.001, 5.0, 1000.0
"""Lengths of the crack over the half-width of the contact: the shortest, the longest one at least, and at most. A crack
begins by fretting within the second."""

JUDGED = 0.01
"""Length over the half-width from which on a crack may stop; above it the stress is that of single cells."""

PER_DECADE = 30

BLOCKS, SHORT = 1.25, 8.0
"""Error over the difference to blocks of two cells, measured on lines and spheres. In cracks shorter than a cell it is
larger by the root of the cell over the length, up to the root of SHORT: they see the stress at the edge, a root."""

Bar = Callable[[int], AbstractContextManager[Callable[[], object]]]
"""Shows a bar of a number of things within a block, which gets the function that advances it by one."""


@dataclass(frozen=True, eq=False)
class Crack:
    """A crack of many lengths (mm) at a place; stress intensities in MPa m^0.5, lives in cycles.

    half_width: of the contact on its middle row (mm); K: (2, steps, lengths), K_I and K_II; K_error: (lengths,), of
    both in all steps; cycles: their states are places in `steps`; cycle_ranges: (cycles, lengths); range_error: of the
    largest of them; initiation: cycles to a crack of each length. growth, shortest, longest: from the ranges, from
    ranges with their errors, and less their errors; of_cycles: under each cycle alone. missing_curve: key of the
    material that initiation lacks, empty if none. opening: how far a cycle misses its beginning, over its range.
    """

    body: Body
    place: CrackPlace
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
    missing_curve: str
    opening: float

    @property
    def judged(self) -> int:
        """Number of the length from which on a crack may stop."""
        return int(np.searchsorted(self.lengths, 0.999 * JUDGED * self.half_width))

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
        """Arrest and life as far as they are known, with error bars, by names."""
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
        found |= {"life_low": bounds[0].life, "life_high": bounds[1].life}
        return {name: float(value) for name, value in found.items() if value is not None}


def crack_of(tractions: TractionHistory, request: CrackRequest, bar: Bar = lambda total: nullcontext(int)) -> Crack:
    """Return the crack that is asked for; bar: shows how many lengths are done. Raises CaseError."""
    result, _ = tractions.result, request.last_length  # refuses a final length above the thickness
    body, there = _body(tractions, request), cycles_of(result)
    with placed(lambda message: request.problem(request.cycles_key, message)):
        absolute = chosen(there, request.cycles)
    with placed(lambda message: CaseError(message, (), result.path)):
        for one in absolute:
            require_states(one, result.steps)
        steps = states_of(absolute, result.steps)
        rows = rows_of_contact(tractions, steps)
        line = stress_line(tractions, steps, body)
    cycles = tuple(within(absolute, steps))
    source = request.material.with_elastic_constants(result.effective_case["bodies"][body - 1])
    if request.at == "max":
        source.require((request.require_curve(),))
    with placed(lambda message: request.problem("at", message)):
        if request.at == "edge":
            place = at_edge(tractions, line, rows)
        elif request.at == "max":
            place = at_largest(tractions, line, cycles, request.require_curve(), source.material)
        else:
            place = at_length(tractions, rows, request.at)
    half_width = max(row.half_width for row in rows)
    lengths, K = _stress_intensities(line, place, half_width, source.material, request, bar)
    return _analysed(line, place, half_width, tractions.grid.dx, cycles, source.material, request, lengths, K)


def _body(tractions: TractionHistory, request: CrackRequest) -> Body:
    elastic = tractions.poisson_ratios
    if request.body is None:
        return 2 if 2 in elastic else 1
    if request.body not in elastic:
        raise request.problem("body", f"body {request.body} is rigid, so that it does not crack; leave it out")
    return request.body


def _analysed(
    line: StressLine,
    place: CrackPlace,
    half_width: float,
    cell: float,
    cycles: tuple[LoadCycle, ...],
    material: Material,
    request: CrackRequest,
    lengths: DoubleArray,
    K: DoubleArray,
) -> Crack:
    """Return the crack with the stress intensities K (2, 1 + averages, steps, lengths)."""
    factor = BLOCKS * np.sqrt(np.clip(cell / lengths, 1.0, SHORT))
    error = factor * np.abs(K[:, 1:] - K[:, :1]).max(axis=(0, 1, 2)) + WEIGHT_ERROR * np.abs(K[:, 0]).max(axis=(0, 1))
    exponent = 1.0 if material.paris is None else material.paris.walker_exponent
    of_cycles = np.stack([stress_range(one.of(K[0], 1), exponent) for one in cycles], axis=1)
    ranges, most = of_cycles[0], np.maximum(K[0, 0], 0.0).max(axis=0)
    errors = np.maximum(factor * np.abs(of_cycles[1:] - ranges).max(axis=0), error)
    highest = np.stack([K[0, 0][list(one.states)].max(axis=0) for one in cycles])
    errors[highest + error <= 0.0] = 0.0  # surely closed
    initiation, missing_curve = _initiation(line, place, lengths, factor, cycles, material, request.life_criterion)
    limits = request.last_length, (1.0 - 1e-9) * JUDGED * half_width, LONGEST_USUAL * half_width
    rule = GrowthRule(material, tuple(one.times for one in cycles), *limits)
    growth, shortest, longest = (
        rule.growth(
            lengths,
            np.maximum(ranges + sign * errors, 0.0),
            most + sign * error,
            None if initiation is None else miner_life(initiation[index], cycles),
        )
        for index, sign in enumerate((0.0, 1.0, -1.0))
    )
    alone = GrowthRule(material, (1.0,), *limits)
    of_each = [
        alone.growth(lengths, ranges[[index]], highest[index], None if initiation is None else initiation[0, index])
        for index in range(len(cycles))
    ]
    threshold = threshold_of(material)
    return Crack(
        body=line.body,
        place=place,
        half_width=half_width,
        cell=cell,
        steps=line.steps,
        lengths=lengths,
        K=K[:, 0],
        K_error=error,
        cycles=cycles,
        cycle_ranges=ranges,
        range_error=errors[ranges.argmax(axis=0), np.arange(len(lengths))],
        threshold=None if threshold is None else threshold(lengths),
        initiation=None if initiation is None else miner_life(initiation[0], cycles),
        growth=growth,
        shortest=shortest,
        longest=longest,
        of_cycles=tuple(of_each),
        material=material,
        criterion=request.life_criterion,
        missing_curve=missing_curve,
        opening=max(opening_of(one.of(K[:, 0], 1).swapaxes(0, 1)) for one in cycles),
    )


def crack_lengths(half_width: float, begin: int, longest: float) -> DoubleArray:
    """Return lengths from number `begin` on, equally spaced in their logarithm, to `longest` (mm) at least."""
    last = math.ceil(PER_DECADE * math.log10(longest / (SHORTEST * half_width)) - 1e-9)
    return np.asarray(SHORTEST * half_width * 10.0 ** (np.arange(begin, max(last, begin) + 1) / PER_DECADE))


def _stress_intensities(
    line: StressLine, place: CrackPlace, half_width: float, material: Material, request: CrackRequest, bar: Bar
) -> tuple[DoubleArray, DoubleArray]:
    """Return lengths, and the stress intensities (2, 1 + averages, steps, lengths) of cracks of these lengths."""
    final = request.last_length
    if final is not None and final <= (shortest := JUDGED * half_width):
        message = (
            f"{final:g} mm is out of range; a length above {shortest:.3g} mm, a hundredth of the half-width of the"
        )
        key = "thickness" if request.final_length is None else "final-length"
        raise request.problem(key, f"{message} contact, is needed")

    def of(lengths: DoubleArray) -> DoubleArray:
        found = []
        with bar(len(lengths)) as advance:
            for length in lengths.tolist():
                found.append(line.stress_intensity((place.x, place.y), length))
                advance()
        return np.stack(found, axis=-1)

    lengths = crack_lengths(half_width, 0, max(LONGEST_USUAL * half_width, final or 0.0))
    K = of(lengths)
    if material.paris is None or material.toughness is None or final is not None:
        return lengths, K
    while K[0, 0].max() < material.toughness and lengths[-1] < LONGEST * half_width:
        longer = min(10.0 * float(lengths[-1]), LONGEST * half_width)
        more = crack_lengths(half_width, len(lengths), longer)
        lengths, K = np.append(lengths, more), np.concatenate([K, of(more)], axis=-1)
    return lengths, K


def _initiation(
    line: StressLine,
    place: CrackPlace,
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
            [
                [fatigue_field(criterion, material, one.of(variant), refine_all=True).value for one in cycles]
                for variant in stress
            ]
        )
    except CaseError as error:
        return None, ".".join(map(str, error.key)) or error.message
    errors = factor * np.abs(values[1:] - values[0]).max(axis=0)
    bounds = np.stack([values[0], values[0] + errors, np.maximum(values[0] - errors, 0.0)])
    lives = lives_of(criterion, material, bounds.ravel())
    assert lives is not None
    return lives.reshape(bounds.shape), ""
