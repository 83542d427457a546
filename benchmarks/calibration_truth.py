"""Truth of the cases that the error bars are calibrated on: closed forms, and runs with finer grids and increments.

Each closed form is a function of the pair's compliances, or makes one, and tells the values at the end of stages. The
contact is that of a sphere of 10 mm under 400 N where nothing else is said.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

import fretsolve
from fretsolve.model.edges import rounding
from fretsolve.model.materials import Compliances
from fretsolve.reference.cyclic_loading import CyclicLoading
from fretsolve.reference.hertz import boussinesq_punch, hertz_elliptic, hertz_sphere, love_cone
from fretsolve.reference.tangential import cattaneo_mindlin, gross_slip_torque, lubkin
from fretsolve.result.state import CORRECTED
from fretsolve.setup.problem_setup import ProblemSetup
from fretsolve.simulation.error_bars.coarse_runs import FIRST_ORDER

Truth = Mapping[int, Mapping[str, float]]
"""Values of the history at the end of stages (1-based)."""

LOAD, RADIUS = 400.0, 10.0


def hertz(pair: Compliances, load: float = LOAD, radius: float = RADIUS) -> Truth:
    """Return the values of a sphere, pressed."""
    found = hertz_sphere(load, radius, pair.contact_modulus)
    return {1: {"delta_z": found.delta_z, "max_pressure": found.max_pressure, "contact_radius": found.contact_radius}}


def elliptic(radius_x: float, radius_y: float, load: float = LOAD) -> Callable[[Compliances], Truth]:
    """Return the values of an ellipsoid, pressed."""

    def exact(pair: Compliances) -> Truth:
        found = hertz_elliptic(load, radius_x, radius_y, pair.contact_modulus)
        radius = found.contact_radius
        return {1: {"delta_z": found.delta_z, "max_pressure": found.max_pressure, "contact_radius": radius}}

    return exact


def driven(delta_z: float) -> Callable[[Compliances], Truth]:
    """Return the values of a sphere, pressed by displacement."""

    def exact(pair: Compliances) -> Truth:
        radius = math.sqrt(delta_z * RADIUS)
        load = 4.0 / 3.0 * pair.contact_modulus * radius**3 / RADIUS
        found = hertz_sphere(load, RADIUS, pair.contact_modulus)
        return {1: {"P": load, "max_pressure": found.max_pressure, "contact_radius": radius}}

    return exact


def cone(load: float, angle: float) -> Callable[[Compliances], Truth]:
    """Return the values of a cone, pressed."""

    def exact(pair: Compliances) -> Truth:
        found = love_cone(load, angle, pair.contact_modulus)
        return {1: {"delta_z": found.delta_z, "contact_radius": found.contact_radius}}

    return exact


def punch(pair: Compliances) -> Truth:
    """Return the values of a flat punch with a radius of 0.3 mm, pressed."""
    found = boussinesq_punch(LOAD, 0.3, pair.contact_modulus)
    return {1: {"delta_z": found.delta_z, "contact_radius": found.contact_radius}}


def mindlin(
    force: float, friction: float = 0.1, back: bool = False, load: float = LOAD, radius: float = RADIUS
) -> Callable[[Compliances], Truth]:
    """Return the values of a sphere, pressed and sheared; back: then unloaded, and sheared by the opposite force."""

    def exact(pair: Compliances) -> Truth:
        contact = hertz_sphere(load, radius, pair.contact_modulus)
        found = cattaneo_mindlin(contact, friction, force, pair.tangential)
        first = {
            "delta_z": contact.delta_z,
            "delta_x": found.delta_x,
            "stick_radius": found.stick_radius,
            "work_total": 0.25 * found.work_per_cycle,
        }
        values: dict[int, Mapping[str, float]] = {**hertz(pair, load, radius), 2: first}
        if back:
            unloaded = CyclicLoading(contact, (0.0, 0.0), friction, pair.tangential, (1.0, 0.0), (force, 0.0))
            values[3] = {"delta_x": unloaded.displacements()["delta_x"]}
            values[4] = {
                "delta_x": -found.delta_x,
                "stick_radius": found.stick_radius,
                "work_total": 0.75 * found.work_per_cycle,
            }
        return values

    return exact


def gross_slip(friction: float, motion: float) -> Callable[[Compliances], Truth]:
    """Return the values of a sphere moved by D, with gross slip from d on: mu P (D - 0.8 d) is dissipated."""

    def exact(pair: Compliances) -> Truth:
        contact = hertz_sphere(LOAD, RADIUS, pair.contact_modulus)
        limit = friction * LOAD
        last = 3.0 * limit * pair.tangential / (16.0 * contact.contact_radius)
        return {**hertz(pair), 2: {"Qx": limit, "work_total": limit * (motion - 0.8 * last)}}

    return exact


def torsion(
    torque: float, friction: float = 0.1, load: float = LOAD, radius: float = RADIUS
) -> Callable[[Compliances], Truth]:
    """Return the values of a sphere, pressed and twisted by a share of the torque of gross slip."""

    def exact(pair: Compliances) -> Truth:
        contact = hertz_sphere(load, radius, pair.contact_modulus)
        found = lubkin(contact, friction, torque * gross_slip_torque(contact, friction), pair.torsional)
        return {**hertz(pair, load, radius), 2: {"phi_z": found.phi_z, "stick_radius": found.stick_radius}}

    return exact


Row = Mapping[str, float]

CELLS_ON_EDGE = 4.0
"""Cells of a fine run on the radius of an edge, at least, for its largest pressure to be a truth."""


def corrected_run(setup: ProblemSetup) -> list[Row]:
    """Return the values of each increment; where the slip depends on the path, 2 Q_m - Q_(m/2) for what is corrected.

    The energy of the first stage is corrected by its own order. The first, the third and so on of the increments keep
    their values as run; all do if a stage has an odd number.
    """
    rows: list[Row] = [vars(state.summary) for state in fretsolve.run(setup)]
    counts = setup.load_path.counts
    if not setup.load_path.path_dependent or any(count % 2 for count in counts):
        return rows
    half = replace(setup, load_path=setup.load_path.with_counts(tuple(count // 2 for count in counts)))
    coarse = [vars(state.summary) for state in fretsolve.run(half)]
    energy = 0.0  # that the first stage has too much, by its order rather than by the first
    for place, row in enumerate(coarse):
        fine = 2 * place + 1  # all stages are halved
        if fine < counts[0]:
            energy = (rows[fine]["work_total"] - row["work_total"]) * (1.0 / (2.0**FIRST_ORDER - 1.0) - 1.0)
        corrected = {name: 2.0 * rows[fine][name] - row[name] for name in CORRECTED}
        rows[fine] = {**rows[fine], **corrected, "work_total": corrected["work_total"] + energy}
    return rows


def knows_peak(fine: ProblemSetup) -> bool:
    """Return whether the largest pressure of a fine run is one: no tip, sharp edge or rounding of few of its cells."""
    surfaces, side = fine.case.surface, max(fine.grid.dx, fine.grid.dy)
    radii = [0.0 if surface.kind == "cone" else rounding(surface) for surface in surfaces]
    return all(radius is None or radius >= CELLS_ON_EDGE * side for radius in radii)
