"""The outcome of a fit as tables, sentences and CSV."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator
from itertools import combinations
from pathlib import Path

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.table import Table

from fretsolve.case.dimensions import in_small_unit, percent
from fretsolve.sweep.fit.least_squares import DOUBLED, STEPS, Fit
from fretsolve.sweep.fit.model_loop import FORCE
from fretsolve.system import atomic_files
from fretsolve.system.arrays import DoubleArray
from fretsolve.system.files import writing

FIRST_COLUMNS = "parameter,value,lower_95,upper_95,"
"""Beginning of the table as CSV."""

MISFIT = 0.005
"""Part of the loop's range that the residual may exceed twice the noise by: coarse grids and thin loops take it."""

HARDLY_APART = 0.95
"""Correlation of two parameters from which their bounds are three times as wide as with one of them known."""

FEW_POINTS = 50
"""Points of a cycle below which the loop bends as much from point to point as noise or backlash may bend it."""

CORRELATED = 0.6
"""Correlation of neighbouring points from which bounds are twice as wide as with white noise."""

IN_SERIES = ("rig.", "interface.")
"""Beginnings of the names of what gives in series with the contact."""


def words(fit: Fit, place: int) -> str:
    """Return a parameter with its bounds, such as ``friction = 0.1002 (0.0999 to 0.1005)``."""
    one, (low, high) = fit.plan.parameters[place], fit.bounds
    bounds = f"{low[place]:.4g} to {high[place]:.4g}"
    return f"{one.name} = {one.written(fit.values[place], 4)} ({bounds})"


def tables(fit: Fit) -> Iterator[Table]:
    """Yield the table of the parameters, and of several parameters their correlations."""
    table = Table("parameter", "found", "95 % bounds", "either way", "start", box=SIMPLE_HEAD)
    for place, (one, width) in enumerate(zip(fit.plan.parameters, fit.widths, strict=True)):
        low, high = (bound[place] for bound in fit.bounds)
        wide = percent(math.expm1(width)) if width < DOUBLED else "more than itself"
        found = one.written(fit.values[place], 5)
        table.add_row(one.name, found, f"{low:.5g} to {high:.5g}", wide, one.written(one.start, 5))
    yield table
    names = [one.name for one in fit.plan.parameters]
    if len(names) > 1:
        table = Table("correlation", *names, box=SIMPLE_HEAD)
        for name, row in zip(names, fit.correlation, strict=True):
            table.add_row(name, *(f"{value:.3f}" for value in row))
        yield table


def notes(fit: Fit) -> Iterator[str]:
    """Yield lines on the residual, the energies, and what was taken off the force."""
    loop, units = fit.plan.loop, fit.plan.case.dimensions
    force, energy = units[FORCE].unit, units["work_total"].unit
    of_range = percent(fit.rms / loop.range)
    noise = f"{fit.noise:.3g} {force}, {percent(fit.noise / loop.range)}"
    yield f"residual: {fit.rms:.3g} {force}, {of_range} of the range of the force; noise along the branches: {noise}"
    measured, fitted = fit.energies
    yield f"energy of the loop: measured {measured:.4g} {energy}, fitted {fitted:.4g} {energy}"
    if fit.plan.request.offset:
        start, end = fit.drift[np.argmin(loop.time)], fit.drift[np.argmax(loop.time)]
        yield f"taken off the force: {start:.3g} {force} at the start of the cycle, {end:.3g} {force} at its end"
    yield from hardly_apart([one.name for one in fit.plan.parameters], fit.correlation)
    yield f"loops solved: {fit.solved} in {fit.seconds:.3g} s"


def hardly_apart(names: list[str], correlation: DoubleArray) -> Iterator[str]:
    """Yield a line on each two parameters that the loop tells apart by little: one can make up for the other."""
    for one, other in combinations(range(len(names)), 2):
        if abs(correlation[one, other]) > HARDLY_APART:
            number = f"correlation {correlation[one, other]:.3f}"
            yield f"{names[one]} and {names[other]} are hardly told apart ({number}): fix one of them if it is known"


def doubts(fit: Fit) -> Iterator[str]:
    """Yield what is wrong with the fit: a misfit, and parameters that the loop does not determine."""
    loop = fit.plan.loop
    if fit.rms > 2.0 * fit.noise + MISFIT * loop.range:
        residual, noise = percent(fit.rms / loop.range), percent(fit.noise / loop.range)
        yield (
            f"the model does not explain the loop: residual {residual} of the range, noise is {noise}; the bounds allow"
            " for noise, not for a wrong model"
        )
    elif fit.neighbours > CORRELATED:
        yield (
            f"the residual is correlated along the loop, {fit.neighbours:.2f} from point to point: the noise is slow,"
            " or the model misses something; the bounds are wider for it"
        )
    if not fit.ended:
        yield f"the search stopped after {STEPS} steps before its end: start it from the values found"
    if len(loop.force) < FEW_POINTS:
        yield (
            f"a cycle of {len(loop.force)} points hides its noise and the errors of the model; record 100 points or"
            " more"
        )
    if 2.0 * loop.reach > fit.plan.side:
        motion = in_small_unit(2.0 * loop.reach, 3)
        yield f"the motion of {motion} to and fro is more than the contact; is its unit right?"
    names = [one.name for one in fit.plan.parameters]
    for name, value, one in zip(names, fit.at_limit, fit.plan.parameters, strict=True):
        if value:
            yield f"{name} went as far from its start, {one.written(one.start, 5)}, as the search does"
    for direction in fit.undetermined:
        yield undetermined_words(names, direction, fit.branches.slides)
    for name, exceeds in zip(names, fit.exceeded, strict=True):
        if exceeds:
            yield f"the 95 % bound of {name} exceeds {name} itself"


def undetermined_words(names: list[str], direction: DoubleArray, slides: bool) -> str:
    """Return a sentence on a change of the parameters that the loop does not show.

    direction: of their logarithms; slides: whether the loop shows gross slip, without which friction hides behind what
    gives in series.
    """
    taking = [
        place for place in np.argsort(-np.abs(direction)) if abs(direction[place]) > 0.1 * np.abs(direction).max()
    ]
    reason = ""
    if not slides and any(names[place].startswith("friction") for place in taking):
        free = [name for name in names if name.startswith(IN_SERIES)]
        while_free = f" while {' and '.join(free)} {'is' if len(free) == 1 else 'are'} free" if free else ""
        reason = f": the loop stays below gross slip{while_free}"
    factors = [f"{math.exp(direction[place]):.3g} times {names[place]}" for place in taking]
    if len(taking) == 1:
        return f"{names[taking[0]]} is not determined{reason}"
    pair = " and ".join(names[place] for place in sorted(taking))
    return f"{pair} are not determined apart{reason}; {' with '.join(factors)} gives the same loop within the residual"


def exceeded(fit: Fit) -> bool:
    """Return whether a bound exceeds its parameter."""
    return bool(np.any(fit.exceeded))


def write_fit_csv(path: Path, fit: Fit) -> None:
    """Write a row per parameter: value, 95 % bounds, unit, start, correlations. Raises FileError."""
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    names = [one.name for one in fit.plan.parameters]
    writer.writerow([*FIRST_COLUMNS.strip(",").split(","), "unit", "start", *(f"correlation {name}" for name in names)])
    for one, value, low, high, row in zip(fit.plan.parameters, fit.values, *fit.bounds, fit.correlation, strict=True):
        writer.writerow([one.name, *map(float, (value, low, high)), one.unit, one.start, *map(float, row)])
    with writing(path):
        atomic_files.write_text(path, text.getvalue())
