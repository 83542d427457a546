"""Closed forms of the cases that the error bars are calibrated on, at the end of their stages.

Each is a function of the pair's compliances, or makes one. The contact is that of a sphere of 10 mm under 400 N where
nothing else is said.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from fretsolve.model.materials import Compliances
from fretsolve.reference.cyclic_loading import CyclicLoading
from fretsolve.reference.hertz import boussinesq_punch, hertz_elliptic, hertz_sphere, love_cone
from fretsolve.reference.tangential import cattaneo_mindlin, gross_slip_torque, lubkin

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
