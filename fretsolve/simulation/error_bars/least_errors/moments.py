"""Least errors of moments and tilts, which sum up tractions of opposite effect."""

from __future__ import annotations

import math

import numpy as np

from fretsolve.case.history import Summary
from fretsolve.model.required_terms import Model
from fretsolve.simulation.error_bars.quantity_estimates import DELTA_Z, MX, MY, MZ, PHI_Y, QX, QY, TILTS
from fretsolve.system.arrays import DoubleArray

MOMENT, MOMENT_LINE, MOMENT_ENDS, MOMENT_SHEARED = 0.015, 0.1, 0.05, 1.3
"""Least error of Mx and My over (h/a)^2 P a, and of Mz with the shear force Q: they sum up tractions of opposite
effect. Those at ends are largest, and those of line contacts, whose two edges nothing averages: of 42 cylinders off the
middle of the grid, tilted or not, none had more than 0.115. And of Mx and My between unlike bodies over (h/a)^2 beta Q
a with Dundurs' constant beta, by which Q moves the pressure sideways: true errors over that are spread alike on spheres
and on height maps."""

TILT = 0.03
"""Least error of tilts over (h/a)^2 delta_z/a. A tilt of delta_z/a takes a moment of about P a. In line contact, where
the approach is not known, it is the tilt of a cylinder under the least error of My, 4 My/(pi E* a^2)."""


def add_moments_and_tilts(
    least: DoubleArray, model: Model, summary: Summary, largest: DoubleArray, cells: DoubleArray, *, ends: bool
) -> None:
    """Add what sums of tractions of opposite effect miss, and tilts by them.

    largest: largest absolute values so far; cells: (h/a)^2 of each value; ends: whether a body ends.
    """
    arm, shear = cells * summary.contact_radius, float(np.hypot(largest[QX], largest[QY]))
    mismatch = abs(model.compliances.dundurs_constant) if model.coupled else 0.0
    opposite = MOMENT_LINE if model.line else MOMENT_ENDS if ends else MOMENT
    force = math.hypot(opposite * summary.P, MOMENT_SHEARED * mismatch * shear)
    if model.line:
        add_moment_of_line(least, model, summary, force * float(arm[MY]))
        return
    least[[MX, MY]] = np.hypot(least[[MX, MY]], force * arm[[MX, MY]])
    least[MZ] = math.hypot(least[MZ], opposite * shear * float(arm[MZ]))
    if summary.contact_radius:
        turn = TILT * float(largest[DELTA_Z]) / summary.contact_radius
        least[TILTS] = np.hypot(least[TILTS], turn * cells[TILTS])


def add_moment_of_line(least: DoubleArray, model: Model, summary: Summary, moment: float, factor: float = 1.0) -> None:
    """Add an error of My in line contact, and that of phi_y: the tilt of a cylinder under it, times a factor."""
    least[MY] = math.hypot(least[MY], moment)
    if summary.contact_radius:
        stiffness = 0.25 * math.pi * model.compliances.contact_modulus * summary.contact_radius**2
        least[PHI_Y] = math.hypot(least[PHI_Y], factor * moment / stiffness)
