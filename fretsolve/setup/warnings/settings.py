"""Warn of solver settings that fall short, and of results that are most likely not meant."""

from __future__ import annotations

import math
from collections.abc import Iterator

from fretsolve.case.dimensions import cell_counts, percent
from fretsolve.errors import dotted
from fretsolve.setup.accuracy import points_needed, tolerance_needed
from fretsolve.setup.cost_estimate import estimate, rounded_bytes
from fretsolve.setup.problem_setup import ProblemSetup

LARGE_RESULT = 4e9
"""Bytes of a result that are most likely not wanted."""

SINGLE_ACCURACY = 0.02
"""Least accuracy for which single precision does as well. Its coarse runs have a tolerance of 1e-4, which leaves the
dissipated energy of a sphere sheared to half of mu P a bar of 1.1 % on 90 to 750 points; double precision 0.07 %."""

TOLERANCE_TOO_LOOSE = 5.0
"""Tolerance over the one that an accuracy picks, from which it may show in the bars."""


def about_size(setup: ProblemSetup) -> Iterator[str]:
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


def about_solver(setup: ProblemSetup) -> Iterator[str]:
    """Warn of a loose tolerance, and of settings in the case that fall short of those that its accuracy would pick."""
    accuracy, tolerance = setup.case.solver.accuracy, setup.case.solver.tolerance
    if tolerance > 1e-3:  # residuals then show in the digits that people read
        yield (
            f"solver.tolerance: {tolerance:g} lets the contact conditions be violated by {percent(tolerance)}, so no"
            " digit is reliable; 1e-6 is usual"
        )
    if accuracy is not None:
        if not setup.case.solver.error_bars and setup.case.wear is None:
            yield (
                f"solver.error_bars: without error bars nothing tells if accuracy {percent(accuracy)} is met; leave the"
                " key out"
            )
        yield from _about_digits(setup, accuracy)
        yield from _about_counts(setup, accuracy)


def _about_digits(setup: ProblemSetup, accuracy: float) -> Iterator[str]:
    """Warn of a precision or tolerance that falls short of an accuracy."""
    tolerance, needed = setup.case.solver.tolerance, tolerance_needed(accuracy)
    if setup.case.solver.precision == "single":
        if accuracy < SINGLE_ACCURACY:
            yield (
                f"solver.precision: single has too few digits for accuracy {percent(accuracy)} in many cases; take"
                f" double, or an accuracy of {percent(SINGLE_ACCURACY)} or more"
            )
    elif tolerance > TOLERANCE_TOO_LOOSE * needed:
        yield (
            f"solver.tolerance: {tolerance:g} is looser than the {needed:g} that accuracy {percent(accuracy)} picks;"
            " leave it out to meet it"
        )


def _about_counts(setup: ProblemSetup, accuracy: float) -> Iterator[str]:
    """Warn of points and increments that fall short of an accuracy."""
    wanted, path = f"that accuracy {percent(accuracy)} picks", setup.load_path
    (nx, ny), (more_x, more_y) = (
        setup.grid.shape,
        points_needed(setup.closed_forms, path, setup.grid.size, setup.heights),
    )
    if nx < more_x or ny < more_y:
        given, picked = cell_counts((nx, ny)), cell_counts((more_x, more_y))
        yield f"grid.points: {given} are fewer than the {picked} {wanted}; leave them out to meet it"
    all_needed = path.needed
    short = [place for place, count in enumerate(path.counts) if count < all_needed[place]]
    if short:
        stage, count, needed = setup.case.stages()[short[0]], path.counts[short[0]], all_needed[short[0]]
        more = f", and {len(short) - 1} more stages have too few" if len(short) > 1 else ""
        key = dotted(setup.case.source.typed((*stage.key, "increments")))
        yield f"{key}: {count} are fewer than the {needed} {wanted}{more}; leave them out to meet it"
