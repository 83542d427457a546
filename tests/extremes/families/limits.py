"""Distances of solved cases from what theory says of them: relative, unless stated otherwise."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from solving import RADIUS

from fretsolve.problem.model.materials import Compliances
from fretsolve.reference.hertz import HertzContact, boussinesq_punch, hertz_elliptic, hertz_sphere, love_cone
from fretsolve.reference.tangential import cattaneo_mindlin, full_stick_compliance, lubkin, spence_stick_ratio

from .driving import Run, solve_parts

Distance = Callable[[Run], float]


def off(found: float, exact: float) -> float:
    """Relative distance."""
    return abs(found - exact) / abs(exact)


def worst(*distances: Distance) -> Distance:
    """The largest of several."""
    return lambda run: max(distance(run) for distance in distances)


def material(run: Run) -> Compliances:
    """Of the pair of bodies."""
    return run.setup.model.compliances


def hertz(run: Run, radius: float = RADIUS) -> HertzContact:
    """The contact of the sphere under the load at the end."""
    return hertz_sphere(run.end.P, radius, material(run).contact_modulus)


def friction(run: Run) -> float:
    """Its coefficient."""
    return run.setup.model.friction


def of_hertz(run: Run, radius: float = RADIUS) -> float:
    """Approach and peak pressure."""
    exact = hertz(run, radius)
    return max(off(run.end.delta_z, exact.delta_z), off(run.end.max_pressure, exact.max_pressure))


def of_ellipse(radius_x: float, radius_y: float) -> Distance:
    """Approach and peak pressure of Hertz's elliptic contact."""

    def distance(run: Run) -> float:
        exact = hertz_elliptic(run.end.P, radius_x, radius_y, material(run).contact_modulus)
        return max(off(run.end.delta_z, exact.delta_z), off(run.end.max_pressure, exact.max_pressure))

    return distance


def of_cone(angle: float) -> Distance:
    """Love's approach."""
    return lambda run: off(run.end.delta_z, love_cone(run.end.P, angle, material(run).contact_modulus).delta_z)


def of_punch(radius: float) -> Distance:
    """Boussinesq's approach."""
    return lambda run: off(run.end.delta_z, boussinesq_punch(run.end.P, radius, material(run).contact_modulus).delta_z)


def of_bonded_punch(run: Run) -> float:
    """Approach of a bonded flat punch over that of the frictionless one on the same cells, ln((1+b)/(1-b))/2b its
    inverse (Mossakovskii 1954, in Dundurs' constant b); for nu it is Spence's ln(3 - 4 nu)(1 - nu)/(1 - 2 nu)."""
    beta = abs(material(run).dundurs_constant)
    stiffer = math.atanh(beta) / beta if beta else 1.0
    free = again(run, friction=0.0)
    return off(run.end.delta_z * stiffer, free.end.delta_z)


def of_mindlin(run: Run) -> float:
    """Rigid displacement after loading by Qx from nothing; Cattaneo, Mindlin."""
    exact = cattaneo_mindlin(hertz(run), friction(run), run.end.Qx, material(run).tangential)
    return off(run.end.delta_x, exact.delta_x)


def of_stick_compliance(run: Run) -> float:
    """Rigid displacement per Qx where everything sticks: S/8a, Mindlin."""
    exact = run.end.Qx * full_stick_compliance(hertz(run).contact_radius, material(run).tangential)
    return off(run.end.delta_x, exact)


def cattaneo_cells(run: Run) -> float:
    """Error of the stick radius of Cattaneo, Mindlin in cells."""
    exact = cattaneo_mindlin(hertz(run), friction(run), run.end.Qx, material(run).tangential)
    return abs(run.end.stick_radius - exact.stick_radius) / run.cell


def of_lubkin(run: Run) -> float:
    """Rotation under a torque; for a small one it is 3 Mz/16 G a^3 of the disc that sticks."""
    return off(run.end.phi_z, lubkin(hertz(run), friction(run), run.end.Mz, material(run).torsional).phi_z)


def lubkin_cells(run: Run) -> float:
    """Error of Lubkin's stick radius in cells."""
    exact = lubkin(hertz(run), friction(run), run.end.Mz, material(run).torsional)
    return abs(run.end.stick_radius - exact.stick_radius) / run.cell


def spence_cells(run: Run) -> float:
    """Error of Spence's stick radius in cells; he leaves out what the shear does to the pressure."""
    ratio = spence_stick_ratio(friction(run), material(run).dundurs_constant)
    return abs(run.end.stick_radius - ratio * hertz(run).contact_radius) / run.cell


def of_sliding(run: Run) -> float:
    """|q| against mu p in every cell, over the largest mu p, and |Q| against mu P."""
    bound = friction(run) * run.last.fields.pressure
    short = np.abs(np.hypot(*run.last.fields.shear) - bound).max() / bound.max()
    return max(float(short), off(math.hypot(run.end.Qx, run.end.Qy), friction(run) * run.end.P))


def of_dissipation(run: Run) -> float:
    """Power of the loads over the last increment against what the sliding contact dissipates, 1 - F.v/sum mu p |v|.

    It vanishes as v becomes a rigid motion: by the kinematic theorem the loads then lie on the limit surface, with v
    normal to it.
    """
    grid, before, after = run.setup.grid, run.states[-2].summary, run.end
    dx, dy, turn = (getattr(after, name) - getattr(before, name) for name in ("delta_x", "delta_y", "phi_z"))
    speed = np.hypot(dx - turn * grid.y[None, :], dy + turn * grid.x[:, None])
    power = after.Qx * dx + after.Qy * dy + after.Mz * turn
    dissipated = float(np.vdot(friction(run) * run.last.fields.pressure, speed)) * grid.cell_area
    return abs(1.0 - float(power) / dissipated)


def of_superposition(run: Run) -> float:
    """Shear and delta_x against mu [p(P) - p(P - Qx/mu)] and mu [delta_z(P) - delta_z(P - Qx/mu)]; Jaeger, Ciavarella.

    Exact on any grid and surface for equal bodies of nu = 0, loaded from nothing by P and then by Qx > 0: shear and
    pressure then have the same influence coefficients.
    """
    assert material(run).B == 0.0
    assert material(run).C == 0.0
    mu = friction(run)
    inner = again(run, friction=0.0, load_path=[{"P": run.end.P - run.end.Qx / mu}])
    exact = mu * (run.last.fields.pressure - inner.last.fields.pressure)
    shear = np.abs(run.last.fields.shear[0] - exact).max() / (mu * run.end.max_pressure)
    moved = mu * (run.states[0].summary.delta_z - inner.end.delta_z)
    return max(float(shear), off(run.end.delta_x, moved))


def like(quantities: tuple[str, ...], exact: Callable[[Run], Run], **factors: float) -> Distance:
    """The named scalars at the end against those of another run, times `factors` of them (1 by default)."""

    def distance(run: Run) -> float:
        other = exact(run).end
        return max(off(getattr(run.end, name), factors.get(name, 1.0) * getattr(other, name)) for name in quantities)

    return distance


def again(run: Run, **parts: Any) -> Run:
    """The same case on the same grid with other `parts`."""
    spec = run.setup.case.grid
    grid = {"points": list(spec.points), "size": list(run.setup.grid.size), "center": list(spec.center)}
    return solve_parts(run.parts | {"grid": grid} | parts, run.folder)


def case_of(**parts: Any) -> Callable[[Run], Run]:
    """Another case altogether, for `like`."""
    return lambda run: solve_parts(parts, run.folder)
