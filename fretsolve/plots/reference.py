"""Closed-form curves for the pictures of a result, from its effective case and its history."""

from __future__ import annotations

import math

import numpy as np

from fretsolve.case.history import BULK
from fretsolve.plots.line_reference import Curve, line_pressure, line_shear, line_slip, line_stick
from fretsolve.reference.cyclic_loading import SAME, CyclicLoading
from fretsolve.reference.hertz import HertzContact
from fretsolve.reference.worn_contact import WornLimit
from fretsolve.result import Result
from fretsolve.setup.closed_forms.area_forms import ClosedForms, spence_ratio
from fretsolve.setup.problem_setup import closed_forms_of, model_of_forms
from fretsolve.setup.worn_volume import only_worn_cycle
from fretsolve.system.arrays import DoubleArray

JUST_AFTER = 1e-3
"""Part of an increment after its beginning at which a curve has its first point."""


def hertz_pressure(result: Result, step: int) -> Curve | None:
    """Return the pressure of a sphere or an ellipsoid without friction."""
    forms = _closed_forms(result)
    if forms is not None and forms.model.line:
        return line_pressure(forms, step, float(result.history["phi_y"][step]))
    if forms is None or (form := forms.hertz[step]) is None:
        return None
    x0, y0 = _center(result, step, forms, form)
    return Curve("Hertz", lambda x, y: form.pressure(x - x0, y - y0))


def hertz_curve(result: Result) -> tuple[DoubleArray, DoubleArray] | None:
    """Return delta_z (mm) and P (N) of an upright sphere, up to the largest of the history; None for all else."""
    forms, depth = _closed_forms(result), float(result.history["delta_z"].max())
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


def shear_form(result: Result, step: int) -> Curve | None:
    """Return the shear of Cattaneo and Mindlin under a force in one direction, or of Lubkin under a torque."""
    forms = _closed_forms(result)
    if forms is not None and forms.model.line:
        return line_shear(forms, step, float(result.history["phi_y"][step]))
    form = _shear(result, step, forms) if forms is not None else None
    return None if form is None else Curve(form.source, form.shear)


def slip_form(result: Result, step: int) -> Curve | None:
    """Return the slip of a line contact in partial slip."""
    forms = _closed_forms(result)
    if forms is None or not forms.model.line:
        return None
    return line_slip(forms, step, float(result.history["phi_y"][step]))


def stick_form(result: Result, force: str, parts: int = 1) -> tuple[str, DoubleArray] | None:
    """Return authors and c/a of each increment, NaN where it does not apply.

    By Spence under P alone, else by Cattaneo and Mindlin or by Lubkin; None if none of them applies. parts: see
    `along_path`, by which the forces go from one increment to the next.
    """
    forms = _closed_forms(result, parts)
    if forms is None or not forms.model.friction:
        return None
    if forms.model.line:
        return line_stick(forms, len(forms.loads), force)
    if force == "P" and forms.case.friction_varies:
        return None
    if force == "P":
        nothing = SAME * float(result.history["P"].max())
        loaded = any(np.abs(result.history[name]).max() > nothing for name in ("Qx", "Qy", "Mz"))
        if loaded or result.coupling != "full" or forms.largest is None or not forms.largest.is_circle:
            return None
        return "Spence", np.full(len(forms.loads), spence_ratio(forms.model))
    found = [_shear(result, step, forms, parts) for step in range(len(forms.loads))]
    names = {form.source for form in found if form is not None and form.component == force}
    if not names:
        return None
    ratios = [math.nan if form is None else form.stick_radius / form.hertz.contact_radius for form in found]
    return names.pop(), np.array(ratios)


def along_path(values: DoubleArray, parts: int) -> DoubleArray:
    """Return values (n,) with `parts` - 1 more of them, on a straight line, between each two.

    The first of these is just after the increment, since all sticks as soon as a load turns back.
    """
    after = np.linspace(0.0, 1.0, parts, endpoint=False)
    after[1:2] = JUST_AFTER
    increments = np.arange(len(values))
    places = np.append((increments[:-1, None] + after).ravel(), increments[-1])
    return np.asarray(np.interp(places, increments, values))


def _closed_forms(result: Result, parts: int = 1) -> ClosedForms | None:
    """Return the closed forms for the forces of each increment, and between them; a tilt only moves them aside.

    None with wear, which changes the shape of the surfaces.
    """
    case = result.case
    if case is None or case.wear is not None:
        return None
    names = ("P", "Qx", "Qy", "Mz", *BULK[1], *BULK[2])
    columns = {name: along_path(result.history[name], parts).tolist() for name in names if name in result.history}
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
