"""Warn of doubtful cases: by their theory, loads, resolution and settings. For example::

for text in case_warnings(set_up(case)):
    print(text)
"""

from __future__ import annotations

from pathlib import Path

from fretsolve.errors import dotted
from fretsolve.setup.contact_size import concave_sphere
from fretsolve.setup.cost_estimate import disk_problem, estimate, memory_problem
from fretsolve.setup.problem_setup import ProblemSetup
from fretsolve.setup.warnings.bare_numbers import about_bare_numbers
from fretsolve.setup.warnings.resolution import about_edges, about_heights, about_resolution
from fretsolve.setup.warnings.settings import about_size, about_solver
from fretsolve.setup.warnings.sliding import about_friction, about_sliding, about_varied_friction
from fretsolve.setup.warnings.theory import about_hertz, about_line, about_shapes, about_yield
from fretsolve.setup.warnings.wear import about_wear


def case_warnings(setup: ProblemSetup, out: Path | None = None) -> list[str]:
    """Return one sentence per warning, each beginning with the key of the case file that it is about.

    out: the result to come, which may be too large for its disk.
    """
    groups = (
        about_bare_numbers,
        about_shapes,
        about_friction,
        about_sliding,
        about_varied_friction,
        about_resolution,
        about_edges,
        about_heights,
        about_solver,
        about_hertz,
        about_yield,
        about_line,
        about_wear,
    )
    texts = [*setup.model.warnings, *(text for group in groups for text in group(setup))]
    disk = disk_problem(setup, out) if out is not None else None
    errors = concave_sphere(setup.case), memory_problem(setup, estimate(setup).memory), disk
    texts += about_size(setup) if disk is None else ()
    return list(dict.fromkeys([*texts, *(f"{dotted(error.key)}: {error.message}" for error in errors if error)]))
