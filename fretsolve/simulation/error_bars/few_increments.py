"""Least errors by few increments that press unlike bodies, or that turn the shear.

Coarse runs have some of the run's increments, and twice as many. Where these are few, both hide the same errors.
"""

from __future__ import annotations

import math

import numpy as np

from fretsolve.case.history import Summary
from fretsolve.model.required_terms import Model
from fretsolve.simulation.error_bars.quantity_estimates import (
    ALL,
    DELTA_X,
    DELTA_Y,
    MZ,
    PHI_Z,
    QX,
    QY,
    STICK,
    STICK_EXTENTS,
    TOTAL,
    WORK,
)
from fretsolve.simulation.error_bars.shear_path import UNSHEARED, ShearPath
from fretsolve.system.arrays import DoubleArray

EARLY_EDGE, EARLY_ORDER, EARLY_ORDER_LINE, SHEARED_EDGE, SHEARED_EDGE_LINE = 0.3, 1.5, 1.0, 0.062, 0.07
"""Least error of the stick radius in the first stage of unlike bodies, over the contact radius, after one increment.
After k increments it is that over k^EARLY_ORDER, in line contact over k^EARLY_ORDER_LINE: random ones whose stick zone
fills 0.8 to 0.95 of the contact had 0.04/k to 0.4/k, those of 5 increments as those of 2. Where few cells of the coarse
grid stick, other increments move none of them. In later stages of a contact that k increments have pressed before shear
it is SHEARED_EDGE over k times beta/mu, 1 at most, with Dundurs' beta; in line contact SHEARED_EDGE_LINE over k. What
pressing has left in the surfaces moves the edge then, and the half and a quarter of few increments move it alike. It
moves none where all of the contact sticks."""

PRESSED_RADIUS, PRESSED_RADIUS_LINE, PRESSED_FRICTION = 0.062, 0.1, 3.5
"""Least relative error of the contact radius of unlike bodies, over Dundurs' beta and over the number k of increments
that press it, where the friction is at least PRESSED_FRICTION beta. Below it goes with the friction. Rigid spheres and
ellipsoids pressed on beta of .29 to .5 with friction of .5 and 1 in 1 and 2 increments had 0.5 to 1.1 times that; what
coarse runs show comes on top. In line contact it goes with the square of the friction below: with 2 to 16 increments,
beta of .1 to .5 and friction of .2 to 1.5, 23 of 24 errors were below that, the largest 0.127; at little friction they
were far below."""

PRESSED_ENERGY, PRESSED_STICKING, PRESSED_ENERGY_ORDER = 0.42, 3.0, 1.5
"""Least relative error, ALL at most, of what k increments of the first stage dissipate that press unlike bodies, times
k^PRESSED_ENERGY_ORDER: PRESSED_ENERGY where nearly all slips, and PRESSED_STICKING c/(a - c) more with the radii c of
the stick zone and a of the contact. What sticks in the end slips under no steady load, but within each increment. With
c/a of 0, 0.2, 0.35 and 0.5 nine of ten errors of 170 random contacts were below 0.6 to 0.9, 1.2 to 1.4, 1.7 to 1.9 and
3.3 to 3.5. The cells of coarse grids, which may stick or not, hide it by chance. Corrected values keep a part of it
(`CORRECTED_LINKED`)."""

SHEARED_ENERGY, SHEARED_ENERGY_ORDER, SHEARED_MISMATCH = 0.5, 1.2, 0.15
"""Least relative error of what unlike bodies dissipate up to the end of the first stage that shears, times
k^SHEARED_ENERGY_ORDER with the number k of increments that have pressed them, from Dundurs' beta of SHEARED_MISMATCH
on; below it goes with beta. Errors of 12 random contacts with beta of 0.15 to 0.38 were 0.2 to 2.9 after one increment,
0.13 to 0.43 after three, 0.03 to 0.18 after eight. Coarse runs show them, but on their few cells not always: the least
error, a sixth to a third of the largest ones, is for these."""

MOST_STICKS = 0.99
"""Largest c/a that counts there: that of contacts all of whose cells stick."""

TURNED, TURNED_MOMENT, TURNED_ENERGY = 0.035, 1.0, 0.15
"""Least relative error of tangential values where the shear turns, over `ShearPath.turned`. Slip that turns converges
with the first order in the increments once these are many. Of few, as the coarse runs have, twice as many change
little. TURNED_MOMENT is that of the moment Mz that holds unlike bodies from twisting meanwhile: errors were 4 % of it
where `turned` is 0.033, and 22 % where that is 0.097. TURNED_ENERGY is that of the energies: a right angle in one
increment near gross slip, where `turned` is 0.32, dissipated 4.5 % too much, of which twice as many show a fifth."""

TURNED_EDGE, TURNED_AGAIN = 0.05, 0.14
"""Least error of the stick radius once the shear has turned, over the contact radius and `ShearPath.turned`, and that
in a stage that turns it after another one has. Of like spheres and ellipsoids that were turned in 1 to 8 increments it
was up to 0.06 times that in 15 of 16 cases, after a second turn up to 0.11 times in nine of ten (36 cases) and 0.14
times by long increments; what was more came from cells that stick or slip as a whole."""

FALL, FALL_ORDER, FALL_SHEARED, LEAST_SHEARED = 0.4, 1.5, 0.7, 0.2
"""Least relative error, ALL at most, of what an increment dissipates whose load falls under shear: FALL times
(P before/P after - 1)^FALL_ORDER over the part of the friction limit at its end, LEAST_SHEARED at least, to the power
FALL_SHEARED. Cells that slip at its end under little pressure have stuck under more before. Of 14 random spheres, like
and unlike, whose load fell to 0.34 to 0.89 of it in one increment, errors were 0.5 to 1.0 times that, and less in 2, 4
and 8. Coarse grids, whose few cells may slip all at once, need not show it."""

MOST_FALL = 1e9
"""Largest P before over P after that counts there: far beyond ALL, and its power is a number."""


def early_edge(model: Model, summary: Summary, pressed: int) -> float:
    """Return the least error (mm) of the stick radius of unlike bodies by few increments that press, 0 of others.

    pressed: number of increments of the stages before the first one that shears.
    """
    if not model.coupled:
        return 0.0
    if summary.stage == 1:
        order = EARLY_ORDER_LINE if model.line else EARLY_ORDER
        return EARLY_EDGE * summary.contact_radius / math.pow(summary.step + 1, order)
    if not (pressed and model.friction):
        return 0.0
    if model.line:
        return SHEARED_EDGE_LINE * summary.contact_radius / pressed
    if summary.stick_cells == summary.contact_cells:
        return 0.0
    part = min(abs(model.compliances.dundurs_constant) / model.friction, 1.0)
    return SHEARED_EDGE * part * summary.contact_radius / pressed


def pressed_radius(model: Model, summary: Summary, pressed: int) -> float:
    """Return the least relative error of the contact radius of unlike bodies, 0 of others.

    pressed: as of `early_edge`.
    """
    increments, mismatch = summary.step + 1 if summary.stage == 1 else pressed, abs(model.compliances.dundurs_constant)
    if not (model.coupled and increments):
        return 0.0
    part = min(model.friction / (PRESSED_FRICTION * mismatch), 1.0)
    return (PRESSED_RADIUS_LINE * part**2 if model.line else PRESSED_RADIUS * part) * mismatch / increments


def pressed_energy(model: Model, summary: Summary) -> float:
    """Return the least error (mJ) of what unlike bodies have dissipated in the first stage, 0 of others."""
    if not (model.coupled and summary.stage == 1):
        return 0.0
    share = min(summary.stick_radius / summary.contact_radius, MOST_STICKS) if summary.contact_radius else 0.0
    at_once = PRESSED_ENERGY + PRESSED_STICKING * share / (1.0 - share)
    return min(at_once / math.pow(summary.step + 1, PRESSED_ENERGY_ORDER), ALL) * summary.work_total


def sheared_energy(model: Model, summary: Summary, pressed: int) -> float:
    """Return the least error (mJ) of what unlike bodies have dissipated that few increments pressed before shear.

    pressed: as of `early_edge`. 0 of others. Bodies that slide dissipate what is known.
    """
    if not (model.coupled and pressed):
        return 0.0
    part = min(abs(model.compliances.dundurs_constant) / SHEARED_MISMATCH, 1.0)
    return SHEARED_ENERGY * part / math.pow(pressed, SHEARED_ENERGY_ORDER) * summary.work_total


def energy_of_fall(before: Summary | None, summary: Summary, share: float) -> float:
    """Return the least error (mJ) of what an increment dissipates whose load falls under shear, 0 of others.

    before: of the increment before; share: part of the friction limit at the end.
    """
    if before is None or not 0.0 < summary.P < before.P or share < UNSHEARED:
        return 0.0
    fall, sheared = min(before.P / summary.P, MOST_FALL) - 1.0, max(share, LEAST_SHEARED)
    return min(FALL * math.pow(fall, FALL_ORDER) / math.pow(sheared, FALL_SHEARED), ALL) * summary.work


def add_turned(least: DoubleArray, largest: DoubleArray, summary: Summary, path: ShearPath) -> None:
    """Add what few increments that turn the shear hide of tangential values, energies and the stick zone.

    Tangential values and energies are known to a part of the largest ones so far. Where all sticks, or nothing, the
    edge of the stick zone is known.
    """
    turned = path.turned
    relative = TURNED * turned
    for one, other in ((DELTA_X, DELTA_Y), (QX, QY)):
        pair = [one, other]
        least[pair] = np.hypot(least[pair], relative * math.hypot(*largest[pair]))
    energies = [WORK, TOTAL]
    least[energies] = np.hypot(least[energies], TURNED_ENERGY * turned * largest[energies])
    turns = [MZ, PHI_Z]
    least[turns] = np.hypot(least[turns], [TURNED_MOMENT * turned * largest[MZ], relative * largest[PHI_Z]])
    if 0 < summary.stick_cells < summary.contact_cells:
        edge = TURNED_AGAIN if min(path.turning, path.turned_before) > UNSHEARED else TURNED_EDGE
        zone = [STICK, *STICK_EXTENTS]
        least[zone] = np.hypot(least[zone], edge * turned * summary.contact_radius)
