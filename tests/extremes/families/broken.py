"""What fails today, and why: to be taken out as it is mended (the tests of what is listed here have to fail)."""

from __future__ import annotations

import re

COUPLING = "pressure and shear do not settle in 200 passes where mu |beta| is about 5 or more"
LIMIT_SURFACE = "tangential problem: 2000 iterations at a force and torque next to the limit surface"
ONE_CELL = "the error of a torque on one cell names remedies that do not help"
ADVICE = "the size advised holds the contact of the failing increment, not of the load path"
TWO_ROWS = "normal problem: no contact of two rows of cells is found under a moment"
LIFTED = "a moment imposed where delta_z lifts the body off is not refused in words"
TINY_FORCES = "a force or moment of less than 1e-40 is refused rather than taken for what it is"
TINY_CELLS = "cells of 1e-200 mm divide by zero"
FAR = "tangential problem: 2000 iterations under a torque about an origin 1e6 times the contact away"

REASONS: dict[str, str] = {
    r"mode II, friction to infinity: sphere: rigid on nu 0 friction (10000|1e\+06)": COUPLING,
    r"gross sliding by delta_x: rigid on nu 0 friction 10 .*": COUPLING,
    r"partial slip at large friction: rigid on nu 0 friction 10 .*": COUPLING,
    r"Dundurs' constant at its ends: friction 10": COUPLING,
    r"Q and Mz along the limit surface: 60 deg 1 - 1e-0[68]": LIMIT_SURFACE,
    r"numbers beyond physics: size 1e-200": TINY_CELLS,
    r"next to nothing instead of 0: (Qx|My|Mz)": TINY_FORCES,
    r"contact far from the origin: x = 1e\+06 mm": FAR,
    r"contact of few cells: one cell, torque": ONE_CELL,
    r"contact at the edge of the grid: size (0.05|0.3) mm": ADVICE,
    r"punch lifted on one side: between two rows .*": TWO_ROWS,
    r"loads that no contact can carry: moment while delta_z lifts off.*": LIFTED,
}
"""Regular expression of ``family: label`` in full, and what the solver lacks."""


def why_broken(family: str, label: str) -> str:
    """The reason why a probe fails today, empty if it should not."""
    name = f"{family}: {label}"
    return next((reason for pattern, reason in REASONS.items() if re.fullmatch(pattern, name)), "")
