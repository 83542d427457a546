"""Closed-form curves for the pictures of a result, from its effective case and its history."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fretsolve.case.history import BULK
from fretsolve.problem.setup.closed_forms import ClosedForms, spence_ratio
from fretsolve.problem.setup.line_forms import LineClosedForms
from fretsolve.problem.setup.problem import closed_forms_of, model_of_forms
from fretsolve.problem.setup.wear_warnings import only_worn_cycle
from fretsolve.reference.cyclic_loading import SAME, CyclicLoading
from fretsolve.reference.hertz import HertzContact
from fretsolve.reference.line_slip import LineShear
from fretsolve.reference.worn_contact import WornLimit
from fretsolve.result import Result
from fretsolve.system.arrays import DoubleArray


@dataclass(frozen=True)
class Curve:
    """A closed form with its authors' name. at: values at points x, y (mm), (n,) or of a vector (2, n)."""

    name: str
    at: Callable[[DoubleArray, DoubleArray], DoubleArray]


def hertz_pressure(result: Result, step: int, forms: ClosedForms | None) -> Curve | None:
    """Return the pressure of a sphere, an ellipsoid, or in a line contact a cylinder or a rounded punch, without
    friction; forms: `closed_forms` of the result."""
    if isinstance(forms, LineClosedForms):
        contact, middle = forms.contacts[step], _middle(result, step, forms)
        if contact is None or middle is None:
            return None
        return Curve(forms.source, lambda x, y: contact.pressure(x - middle))
    if forms is None or (form := forms.hertz[step]) is None:
        return None
    x0, y0 = _center(result, step, forms, form)
    return Curve("Hertz", lambda x, y: form.pressure(x - x0, y - y0))


def hertz_curve(result: Result) -> tuple[DoubleArray, DoubleArray] | None:
    """Return delta_z (mm) and P (N) of an upright sphere, up to the largest of the history; None for all else."""
    forms, depth = closed_forms(result), float(result.history["delta_z"].max())
    tilted = any(np.any(result.history[name]) for name in ("phi_x", "phi_y"))
    if forms is None or forms.largest is None or not forms.largest.is_circle or depth <= 0.0 or tilted:
        return None
    depths = np.linspace(0.0, depth, 200)
    found = [forms.hertz_under("delta_z", deep) for deep in depths.tolist()]
    return depths, np.array([form.load if form is not None else 0.0 for form in found])


def worn_limit(result: Result) -> WornLimit | None:
    """Return the worn limit of partial slip that the only cycle which stands for others leads to; None without one."""
    cycle = only_worn_cycle(result)
    return None if cycle is None else cycle.limit


def shear_form(result: Result, step: int, forms: ClosedForms | None) -> Curve | None:
    """Return the shear of partial slip under a force in one direction, or of Lubkin under a torque."""
    if isinstance(forms, LineClosedForms):
        found = _partial_slip(result, step, forms)
        if found is None or not found[0].slips_one_way:
            return None
        shear, middle = found
        return _along(forms.shear_source, shear, lambda x: shear.shear(x - middle))
    form = _shear(result, step, forms) if forms is not None else None
    return None if form is None else Curve(form.source, form.shear)


def slip_form(result: Result, step: int, forms: ClosedForms | None) -> Curve | None:
    """Return the slip of a cylinder of a line contact in partial slip under a force in one direction."""
    found = _partial_slip(result, step, forms) if isinstance(forms, LineClosedForms) else None
    if not isinstance(forms, LineClosedForms) or found is None or found[0].slip(np.zeros(1)) is None:
        return None
    shear, middle = found
    return _along(forms.shear_source, shear, lambda x: shear.slip(x - middle))


def stick_form(result: Result, force: str, parts: int = 1, count: int | None = None) -> tuple[str, DoubleArray] | None:
    """Return authors and c/a of each increment, NaN where it does not apply; None if no closed form applies.

    count: of the first increments alone.
    By Spence under P alone, else by Cattaneo and Mindlin or by Lubkin, without a layer. parts: see `along_path`, by
    which the forces go from one increment to the next.
    """
    forms = closed_forms(result, parts, count)
    if forms is None or not forms.model.friction or (force == "P" and forms.case.friction_varies):
        return None
    if forms.model.compliances.layer_shear:
        return None
    steps = range(len(forms.loads))
    if isinstance(forms, LineClosedForms):
        if force == "P":
            known = not forms.model.moved and forms.model.coupled and forms.widest is not None
            return ("Spence, one-way", np.full(len(steps), spence_ratio(forms.model))) if known else None
        ratios = np.full(len(steps), math.nan)
        for step in steps:
            shear = forms.partial_slip(step)
            if shear is not None and (force == ("Qx", "Qy")[shear.axis] or force.startswith("bulk_")):
                ratios[step] = shear.stick_half_width / shear.contact.half_width
        return None if np.isnan(ratios).all() else (forms.shear_source, ratios)
    if force == "P":
        nothing = SAME * float(result.history["P"].max())
        loaded = any(np.abs(result.history[name]).max() > nothing for name in ("Qx", "Qy", "Mz"))
        if loaded or result.coupling != "full" or forms.largest is None or not forms.largest.is_circle:
            return None
        return "Spence", np.full(len(steps), spence_ratio(forms.model))
    found = [_shear(result, step, forms, parts) for step in steps]
    names = {form.source for form in found if form is not None and form.component == force}
    if not names:
        return None
    return names.pop(), np.array(
        [math.nan if form is None else form.stick_radius / form.hertz.contact_radius for form in found]
    )


def along_path(values: DoubleArray, parts: int) -> DoubleArray:
    """Return values (n,) with `parts` - 1 more of them, on a straight line, between each two.

    The first of these is just after the increment, since all sticks as soon as a load turns back.
    """
    after = np.linspace(0.0, 1.0, parts, endpoint=False)
    after[1:2] = 1e-3
    increments = np.arange(len(values))
    places = np.append((increments[:-1, None] + after).ravel(), increments[-1])
    return np.asarray(np.interp(places, increments, values))


def closed_forms(result: Result, parts: int = 1, count: int | None = None) -> ClosedForms | None:
    """Return the closed forms for the forces of each increment, and between them; a tilt only moves them aside.

    parts, count: see `stick_form`.
    None with wear, which changes the shape of the surfaces.
    """
    case = result.case
    if case is None or case.wear is not None:
        return None
    names = ("P", "Qx", "Qy", "Mz", *BULK[1], *BULK[2])
    columns = {
        name: along_path(result.history[name][:count], parts).tolist() for name in names if name in result.history
    }
    loads = tuple(dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True))
    return closed_forms_of(case, model_of_forms(case), loads)


def _shear(result: Result, step: int, forms: ClosedForms, parts: int = 1) -> CyclicLoading | None:
    form = forms.hertz[step]
    return None if form is None else forms.tangential(step, _center(result, step // parts, forms, form))


def _center(result: Result, step: int, forms: ClosedForms, form: HertzContact) -> tuple[float, float]:
    """Return the centre of the contact (mm): a paraboloid that is tilted rolls aside, by radius times tilt."""
    x, y = forms.case.surface[0].center
    phi_x, phi_y = (float(result.history[name][step]) for name in ("phi_x", "phi_y"))
    cosine, sine = math.cos(form.angle), math.sin(form.angle)
    along = form.radii[0] * (cosine * phi_y + sine * phi_x)
    across = form.radii[1] * (cosine * phi_x - sine * phi_y)
    return x + cosine * along - sine * across, y + sine * along + cosine * across


def _partial_slip(result: Result, step: int, forms: LineClosedForms) -> tuple[LineShear, float] | None:
    """Return the partial slip after an increment and the middle of the contact (mm); None where nothing is sheared."""
    shear, middle = forms.partial_slip(step), _middle(result, step, forms)
    return (shear, middle) if shear is not None and middle is not None and any(shear.path) else None


def _along(source: str, shear: LineShear, law: Callable[[DoubleArray], DoubleArray | None]) -> Curve:
    """Return the curve of a vector that has the values of `law` along the force, and 0 across it."""

    def both(x: DoubleArray, y: DoubleArray) -> DoubleArray:
        along, across = law(x), np.zeros_like(x)
        assert along is not None
        return np.array([along, across] if shear.axis == 0 else [across, along])

    return Curve(source, both)


def _middle(result: Result, step: int, forms: LineClosedForms) -> float | None:
    """Return the middle of the contact (mm): a cylinder that is tilted rolls aside; None for a tilted punch."""
    surface, phi_y = forms.case.surface[0], float(result.history["phi_y"][step])
    if surface.kind == "cylinder":
        return surface.center[0] + surface.radius * phi_y
    return surface.center[0] if phi_y == 0.0 else None
