"""Least errors by the cells, of side h, for what no coarse run need show: errors that agree by chance on all grids."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from fretsolve.case.history import EXTENTS
from fretsolve.problem.setup.closed_forms import spence_ratio
from fretsolve.result.state import ESTIMATED, State, Zone
from fretsolve.simulation.error_bars.cells import Cells
from fretsolve.simulation.error_bars.hidden import hidden_pressure, unseen_energy
from fretsolve.simulation.error_bars.shear_path import ShearPath
from fretsolve.system.arrays import DoubleArray, vector_lengths

SUM, TORSION, MOMENT = 0.02, 0.2, 0.02
"""Least relative errors over (h/a)^2 of forces, displacements and pressures, of a torque and its turn, which act by
their arm near the edge, and of moments over P a or Q a with their tilts, which add up tractions of opposite effect."""

CONTACT_EDGE, FEW_CELLS, STICK_EDGE, ROW = 0.01, 0.7, 0.15, 0.1
"""Least errors over h of the contact radius, of one of few cells over (h/a)^2, of a stick radius, and of half-widths
and middles, which depend on the last row of cells."""

OUTLINE, OUTLINE_ROW = 0.13, 0.5
"""Least errors over h of radii, and of half-widths and middles, where a body ends, whose outline all grids round to
their cells. Loads, displacements and energies have the relative error of the radius, moments and turns with it."""

THIN = 0.1
"""Least relative error over h/a of forces and displacements, three times that of torques and turns, where an annulus of
no width slips: the shear traction rises towards an edge that cells place to a part of one. It falls with the width."""

UNSEEN_STICK = 1.2
"""Radius over h of a round stick zone that may exist although no cell sticks."""

AT_LIMIT = 3e-3
"""Distance from the friction limit, over it, within which a cell that sticks may as well slip. A load that comes back
to where a cycle has slipped before brings a whole ring of cells there."""

TURNED = 0.03
"""Least relative error of tangential values over `ShearPath.turned`: few increments and twice as many turn alike."""


def floors(cells: Cells, state: State, largest: Mapping[str, float], path: ShearPath, in_annuli: float) -> DoubleArray:
    """Return the least errors of `ESTIMATED`, in their order; that of a pressure at a sharp edge is infinite.

    largest: largest absolute values so far; in_annuli: least error (mJ) of all energy by slip annuli.
    """
    summary, cells = state.summary, cells.reached_by(state)
    # Where the contact has opened, the largest one counts: its errors are those that are left.
    radius = summary.contact_radius or largest["contact_radius"]
    if not radius:
        return np.zeros(len(ESTIMATED))
    ratio = min(cells.side / radius, 1.0)
    rounded = cells.rounded(state)
    outline = OUTLINE * rounded * ratio
    thin = THIN * ratio / (1.0 + (2.0 * (radius - summary.stick_radius) / cells.side) ** 3)
    sums = _of_sums(cells, largest, path, (radius, outline, thin if path.length else 0.0))
    found = {**sums, **_of_zones(cells, state, path, rounded)}
    found["max_pressure"] = SUM * ratio**2 * largest["max_pressure"] + hidden_pressure(cells, state)
    unseen = unseen_energy(cells, state, largest["P"], radius, path)
    last = math.hypot(*path.way) / path.length if path.length else 0.0
    known = outline + (in_annuli / summary.work_total if summary.work_total else 0.0)
    found["work_total"] = known * summary.work_total + unseen
    found["work"] = known * summary.work + last * unseen
    least = np.array([found[name] for name in ESTIMATED])
    if cells.flattening and summary.max_pressure:  # bodies that touch at their peaks alone are unknown
        heights = min(cells.flattening / summary.max_pressure, 1.0) ** 2
        least += heights * np.array([abs(getattr(summary, name)) for name in ESTIMATED])
    return least


def _of_sums(
    cells: Cells, largest: Mapping[str, float], path: ShearPath, edge: tuple[float, float, float]
) -> dict[str, float]:
    """Return the least errors of loads, displacements and turns.

    edge: radius of the contact (mm), its relative error where a body ends, and that of a thin annulus.
    """
    radius, outline, thin = edge
    ratio = min(cells.side / radius, 1.0)
    part, twist = outline + SUM * ratio**2, outline + TORSION * ratio**2 + 3.0 * thin
    sheared = part + TURNED * path.turned + thin
    moment = MOMENT * ratio ** (1.5 if cells.model.line else 2.0) + (outline if cells.holes else 0.0)
    force, motion = (math.hypot(largest[f"{name}x"], largest[f"{name}y"]) for name in ("Q", "delta_"))
    tilt = largest["delta_z"] / radius
    if cells.model.line:  # whose approach has a free constant: that of a cylinder under the moment P a
        tilt = 4.0 * largest["P"] / (math.pi * cells.model.compliances.contact_modulus * radius)
    return {
        "P": part * largest["P"],
        "delta_z": part * largest["delta_z"],
        **dict.fromkeys(("Qx", "Qy"), sheared * force),
        **dict.fromkeys(("delta_x", "delta_y"), sheared * motion),
        **{name: moment * largest["P"] * radius + outline * largest[name] for name in ("Mx", "My")},
        **{name: moment * tilt + outline * largest[name] for name in ("phi_x", "phi_y")},
        "Mz": twist * largest["Mz"] + moment * force * radius,
        "phi_z": twist * largest["phi_z"] + moment * motion / radius,
    }


def _of_zones(cells: Cells, state: State, path: ShearPath, rounded: float) -> dict[str, float]:
    """Return the least errors (mm) of the zones; rounded: how much of the errors where a body ends counts."""
    summary, side = state.summary, cells.side
    body = OUTLINE * rounded
    few = min(side / summary.contact_radius, 1.0) ** 2 if summary.contact_radius else 0.0
    contact = (CONTACT_EDGE + FEW_CELLS * few + body) * side
    stick = _of_stick_radius(cells, state, path)
    if summary.stick_cells > 0:
        stick = math.hypot(stick + body * side, contact)
        stick += _held_at_limit(cells, state) if path.moves_on else 0.0
    row = (ROW + (OUTLINE_ROW - ROW) * rounded) * side
    extents = {"contact": row, "stick": max(row, stick)}
    return {
        "contact_radius": contact,
        "stick_radius": stick,
        **{name: extents[name.partition("_")[0]] for name in EXTENTS},
    }


def _of_stick_radius(cells: Cells, state: State, path: ShearPath) -> float:
    """Return the least error (mm) of the stick radius by the place of its edge in the cells.

    By Cattaneo and Mindlin the stick zone is the contact under the part of the load that the shear leaves. So a zone
    that no cell shows, or an annulus around it, is known by the part of the friction limit that is left.
    """
    summary, side, model = state.summary, cells.side, cells.model
    if not (model.may_slip and model.friction):
        return 0.0
    order = 1.0 / 2.0 if model.line else 1.0 / 3.0
    if summary.stick_cells == 0:
        widths = sorted((summary.contact_half_width_x, summary.contact_half_width_y))
        slender = 1.0 if model.line or not widths[0] else widths[1] / widths[0]
        return min(UNSEEN_STICK * math.sqrt(slender) * side, math.pow(path.left, order) * summary.contact_radius)
    share = min(math.pow(1.0 - path.largest, order), spence_ratio(model))
    thin = summary.contact_radius - summary.stick_radius < 0.5 * side
    annulus = min((1.0 - share) * summary.contact_radius, side) if thin else 0.0
    return max(annulus, STICK_EDGE * side if summary.stick_cells < summary.contact_cells else 0.0)


def _held_at_limit(cells: Cells, state: State) -> float:
    """Return what cells that stick next to the friction limit add to the stick radius (mm), 0 where friction varies."""
    sticks = state.fields.zone == Zone.STICK
    if not (cells.uniform and sticks.any()):
        return 0.0
    limit = (1.0 - AT_LIMIT) * cells.model.friction * state.fields.pressure
    surely = sticks & (vector_lengths(state.fields.shear) < limit)
    part = float(np.count_nonzero(surely) / np.count_nonzero(sticks))
    return (1.0 - (part if cells.model.line else math.sqrt(part))) * state.summary.stick_radius
