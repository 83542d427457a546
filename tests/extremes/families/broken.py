"""What fails today, and why: to be taken out as it is mended (the tests of what is listed here have to fail)."""

from __future__ import annotations

import re

TINY_FRICTION = "tangential problem: 2000 iterations where the shear is 1e-12 of the pressure"
HUGE_MOTION = "tangential problem: 2000 iterations where the rigid motion is 1e9 times the elastic one or more"
COUPLING = "pressure and shear do not settle in 200 passes where mu |beta| is about 5 or more"
LIMIT_SURFACE = "tangential problem: 2000 iterations at a force and torque next to the limit surface"
HELD = "tangential problem: a held load has to meet the tolerance relative to 1e-6 of the elastic displacement"
ROUNDING = "runs 2000 iterations at rounding's floor, and does not name it"
ONE_CELL = "the error of a torque on one cell names remedies that do not help"
ADVICE = "the size advised holds the contact of the failing increment, not of the load path"
UNLOADED = "a contact of 1e-12 of the load or less is not solved, and the error names a residual that is met"
TWO_ROWS = "normal problem: no contact of two rows of cells is found under a moment"
LIFTED = "a moment imposed where delta_z lifts the body off is not refused in words"
TINY_FORCES = "a force or moment of less than 1e-40 is refused rather than taken for what it is"
TINY_CELLS = "cells of 1e-200 mm divide by zero"

REASONS: dict[str, str] = {
    r"mode II, friction to 0: .* friction 1e-12": TINY_FRICTION,
    r"mode II, friction to infinity: sphere: rigid on nu 0 friction (10000|1e\+06)": COUPLING,
    r"gross sliding by delta_x: rigid on nu 0 friction 10 .*": COUPLING,
    r"gross sliding by delta_x: .* delta_x 1e\+09": HUGE_MOTION,
    r"partial slip at large friction: rigid on nu 0 friction 10 .*": COUPLING,
    r"Dundurs' constant at its ends: friction 10": COUPLING,
    r"Q and Mz along the limit surface: 60 deg 1 - 1e-0[68]": LIMIT_SURFACE,
    r"loads held, at tight tolerance: equal tolerance 1e-(08|09|10|12)": HELD,
    r"loads held, at tight tolerance: unlike tolerance 1e-(07|08|09|10|12)": HELD,
    r"tolerance at rounding's floor: (equal tolerance 2e-15 Qx|unlike tolerance 2e-15 .*|heights .*)": ROUNDING,
    r"numbers beyond physics: size 1e-200": TINY_CELLS,
    r"next to nothing instead of 0: (Qx|My|Mz)": TINY_FORCES,
    r"contact of few cells: one cell, torque": ONE_CELL,
    r"contact at the edge of the grid: size (0.05|0.3) mm": ADVICE,
    r"unloading and reloading: equal to 1e-14, delta_x held": HUGE_MOTION,
    r"unloading and reloading: unlike to (1e-12|1e-14.*)": UNLOADED,
    r"punch lifted on one side: between two rows .*": TWO_ROWS,
    r"loads that no contact can carry: moment while delta_z lifts off.*": LIFTED,
}
"""Regular expression of ``family: label`` in full, and what the solver lacks."""


def why_broken(family: str, label: str) -> str:
    """The reason why a probe fails today, empty if it should not."""
    name = f"{family}: {label}"
    return next((reason for pattern, reason in REASONS.items() if re.fullmatch(pattern, name)), "")
