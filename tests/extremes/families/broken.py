"""What fails today, and why: to be taken out as it is mended (the tests of what is listed here have to fail)."""

from __future__ import annotations

import re

COUPLING = "cells that can neither stick nor be open, at a bound of 1e4 times the pressure, go in and out of contact"
LIMIT_SURFACE = "tangential problem: 2000 iterations at a force and torque next to the limit surface"

REASONS: dict[str, str] = {
    r"mode II, friction to infinity: sphere: rigid on nu 0 friction (10000|1e\+06)": COUPLING,
    r"Q and Mz along the limit surface: 60 deg 1 - 1e-0[68]": LIMIT_SURFACE,
}
"""Regular expression of ``family: label`` in full, and what the solver lacks."""


def why_broken(family: str, label: str) -> str:
    """The reason why a probe fails today, empty if it should not."""
    name = f"{family}: {label}"
    return next((reason for pattern, reason in REASONS.items() if re.fullmatch(pattern, name)), "")
