"""Closed forms for the case of a result, where one applies; all derived from the effective case and the history."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fretsolve.case import Case, EllipsoidSurface, SphereSurface
from fretsolve.model.materials import Compliances
from fretsolve.model.required_terms import derive_model
from fretsolve.reference.closed_forms import hertz_elliptic, hertz_sphere, spence_stick_ratio
from fretsolve.reference.cyclic_loading import SAME, TangentialForm, remembered
from fretsolve.result.stored_case import stored_case
from fretsolve.system.arrays import DoubleArray

if TYPE_CHECKING:
    from fretsolve.result import Result


CURVE_POINTS = 200


@dataclass(frozen=True)
class ClosedForm:
    """A closed form with its authors' name. at: values at points x, y (mm), (n,) or of a vector (2, n)."""

    name: str
    at: Callable[[DoubleArray, DoubleArray], DoubleArray]


@dataclass(frozen=True)
class StickRatio:
    """c/a of each increment by a closed form, NaN where it does not apply."""

    name: str
    values: DoubleArray


def hertz_pressure(result: Result, step: int) -> ClosedForm | None:
    """Pressure of a sphere or an ellipsoid without friction."""
    case, load = stored_case(result), float(result.history["P"][step])
    if case is None or len(case.surface) > 1 or load <= 0.0:
        return None
    modulus = _compliances(case).contact_modulus
    surface = case.surface[0]
    if isinstance(surface, SphereSurface) and surface.radius > 0.0:
        circle = hertz_sphere(load, surface.radius, modulus)
        x0, y0 = _center(result, step, surface, surface.radius, surface.radius, 0.0)
        return ClosedForm("Hertz", lambda x, y: circle.pressure(np.hypot(x - x0, y - y0)))
    if isinstance(surface, EllipsoidSurface) and min(surface.radius_x, surface.radius_y) > 0.0:
        ellipse = hertz_elliptic(load, surface.radius_x, surface.radius_y, modulus)
        cosine, sine = math.cos(surface.angle), math.sin(surface.angle)
        x0, y0 = _center(result, step, surface, surface.radius_x, surface.radius_y, surface.angle)
        return ClosedForm(
            "Hertz",
            lambda x, y: ellipse.pressure(cosine * (x - x0) + sine * (y - y0), cosine * (y - y0) - sine * (x - x0)),
        )
    return None


def hertz_curve(result: Result) -> tuple[DoubleArray, DoubleArray] | None:
    """delta_z (mm) and P (N) of an upright sphere, up to the largest of the history; None for all else."""
    case = stored_case(result)
    sphere = _sphere(case)
    depth = float(result.history["delta_z"].max())
    tilted = any(np.any(result.history[name]) for name in ("phi_x", "phi_y"))
    if case is None or sphere is None or depth <= 0.0 or tilted:
        return None
    modulus = _compliances(case).contact_modulus
    depths = np.linspace(0.0, depth, CURVE_POINTS)
    return depths, 4.0 / 3.0 * modulus * math.sqrt(sphere.radius) * depths**1.5


def shear_form(result: Result, step: int) -> ClosedForm | None:
    """Shear of Cattaneo and Mindlin under a force in one direction, or of Lubkin under a torque.

    For a sphere on a flat, similar bodies or their coupling left out, at a normal load that is constant while the
    tangential one goes to and fro.
    """
    case = stored_case(result)
    form = _tangential_form(result, case, step) if case is not None else None
    return None if form is None else ClosedForm(form.name, form.shear)


def stick_form(result: Result, force: str) -> StickRatio | None:
    """c/a over the history: by Spence under P alone, else by Cattaneo and Mindlin or by Lubkin."""
    case = stored_case(result)
    if case is None or _sphere(case) is None or case.friction.coefficient == 0.0:
        return None
    if force == "P":
        ratio = spence_stick_ratio(case.friction.coefficient, _compliances(case).dundurs_constant)
        applies = result.coupling == "full" and not _is_sheared(result)
        return StickRatio("Spence", np.full(result.increments, ratio)) if applies else None
    forms = [_tangential_form(result, case, step) for step in range(result.increments)]
    names = {form.name for form in forms if form is not None and form.force == force}
    if not names:
        return None
    return StickRatio(names.pop(), np.array([math.nan if form is None else form.stick_ratio() for form in forms]))


def _tangential_form(result: Result, case: Case, step: int) -> TangentialForm | None:
    """What `shear_form` describes, up to `step`; None where it does not apply."""
    sphere, friction = _sphere(case), case.friction.coefficient
    P, Qx, Qy, Mz = (result.history[name][: step + 1] for name in ("P", "Qx", "Qy", "Mz"))
    load = float(P[-1])
    if sphere is None or friction == 0.0 or result.coupling == "full" or load <= 0.0:
        return None
    compliances = _compliances(case)
    center = _center(result, step, sphere, sphere.radius, sphere.radius, 0.0)
    hertz = hertz_sphere(load, sphere.radius, compliances.contact_modulus)
    nothing = SAME * friction * load
    Q, torque = np.hypot(Qx, Qy), (Mz - center[0] * Qy + center[1] * Qx) / hertz.contact_radius
    if Q.max() > nothing and np.abs(torque).max() > nothing:
        return None
    moved = np.flatnonzero(np.maximum(Q, np.abs(torque)) > nothing)
    if len(moved) and np.ptp(P[max(moved[0] - 1, 0) :]) > SAME * load:
        return None
    if np.abs(torque).max() > nothing:
        points = remembered((torque * hertz.contact_radius).tolist(), nothing * hertz.contact_radius)
        return TangentialForm(hertz, center, friction, compliances.torsional, None, points)
    largest, length = int(Q.argmax()), float(Q.max()) or 1.0
    direction = (float(Qx[largest]) / length, float(Qy[largest]) / length)
    if np.abs(direction[0] * Qy - direction[1] * Qx).max() > nothing:
        return None
    points = remembered((direction[0] * Qx + direction[1] * Qy).tolist(), nothing)
    return TangentialForm(hertz, center, friction, compliances.tangential, direction, points)


def _center(
    result: Result, step: int, surface: SphereSurface | EllipsoidSurface, radius_1: float, radius_2: float, angle: float
) -> tuple[float, float]:
    """The centre of the contact (mm): a paraboloid that is tilted rolls aside, by radius times tilt."""
    phi_x, phi_y = (float(result.history[name][step]) for name in ("phi_x", "phi_y"))
    cosine, sine = math.cos(angle), math.sin(angle)
    along, across = radius_1 * (cosine * phi_y + sine * phi_x), radius_2 * (cosine * phi_x - sine * phi_y)
    return surface.center[0] + cosine * along - sine * across, surface.center[1] + sine * along + cosine * across


def _sphere(case: Case | None) -> SphereSurface | None:
    """The sphere, where it is the only surface, and convex."""
    if case is None or len(case.surface) > 1:
        return None
    surface = case.surface[0]
    return surface if isinstance(surface, SphereSurface) and surface.radius > 0.0 else None


def _compliances(case: Case) -> Compliances:
    return derive_model(case).compliances


def _is_sheared(result: Result) -> bool:
    """Whether any tangential load is there; P may be without shear all the same."""
    load = float(result.history["P"].max())
    return any(np.abs(result.history[name]).max() > SAME * load for name in ("Qx", "Qy", "Mz"))
