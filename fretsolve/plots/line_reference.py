"""Closed-form curves for the pictures of a line contact."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fretsolve.setup.closed_forms.area_forms import ClosedForms, spence_ratio
from fretsolve.setup.closed_forms.line_forms import LineClosedForms, LineShear
from fretsolve.system.arrays import DoubleArray


@dataclass(frozen=True)
class Curve:
    """A closed form with its authors' name. at: values at points x, y (mm), (n,) or of a vector (2, n)."""

    name: str
    at: Callable[[DoubleArray, DoubleArray], DoubleArray]


def line_pressure(forms: ClosedForms, step: int, phi_y: float) -> Curve | None:
    """Return the pressure of a cylinder or a rounded punch without friction. phi_y: tilt (rad)."""
    assert isinstance(forms, LineClosedForms)
    contact, middle = forms.contacts[step], _middle(forms, phi_y)
    if contact is None or middle is None:
        return None
    return Curve(forms.source, lambda x, y: contact.pressure(x - middle))


def line_shear(forms: ClosedForms, step: int, phi_y: float) -> Curve | None:
    """Return the shear of partial slip under a force in one direction. phi_y: tilt (rad)."""
    found = _partial_slip(forms, step, phi_y)
    if found is None or not found[0].slips_one_way:
        return None
    shear, middle = found
    return _along(forms, shear, lambda x: shear.shear(x - middle))


def line_slip(forms: ClosedForms, step: int, phi_y: float) -> Curve | None:
    """Return the slip of a cylinder in partial slip under a force in one direction. phi_y: tilt (rad)."""
    found = _partial_slip(forms, step, phi_y)
    if found is None or found[0].slip(np.zeros(1)) is None:
        return None
    shear, middle = found
    return _along(forms, shear, lambda x: shear.slip(x - middle))


def line_stick(forms: ClosedForms, increments: int, force: str) -> tuple[str, DoubleArray] | None:
    """Return authors and c/a of each increment over a force or a bulk stress; None if no closed form applies.

    NaN where it does not apply.
    """
    assert isinstance(forms, LineClosedForms)
    if force == "P":
        if forms.model.moved or not forms.model.coupled or forms.widest is None or forms.case.friction_varies:
            return None
        return "Spence, one-way", np.full(increments, spence_ratio(forms.model))
    ratios = np.full(increments, math.nan)
    for step in range(increments):
        shear = forms.partial_slip(step)
        if shear is not None and (force == ("Qx", "Qy")[shear.axis] or force.startswith("bulk_")):
            ratios[step] = shear.stick_half_width / shear.contact.half_width
    return None if np.isnan(ratios).all() else (forms.shear_source, ratios)


def _partial_slip(forms: ClosedForms, step: int, phi_y: float) -> tuple[LineShear, float] | None:
    """Return the partial slip after an increment and the middle of the contact (mm); None where nothing is sheared."""
    assert isinstance(forms, LineClosedForms)
    shear, middle = forms.partial_slip(step), _middle(forms, phi_y)
    return (shear, middle) if shear is not None and middle is not None and any(shear.path) else None


def _along(forms: ClosedForms, shear: LineShear, law: Callable[[DoubleArray], DoubleArray | None]) -> Curve:
    """Return the curve of a vector that has the values of `law` along the force, and 0 across it."""
    assert isinstance(forms, LineClosedForms)

    def both(x: DoubleArray, y: DoubleArray) -> DoubleArray:
        along, across = law(x), np.zeros_like(x)
        assert along is not None
        return np.array([along, across] if shear.axis == 0 else [across, along])

    return Curve(forms.shear_source, both)


def _middle(forms: LineClosedForms, phi_y: float) -> float | None:
    """Return the middle of the contact (mm): a cylinder that is tilted rolls aside; None for a tilted punch."""
    surface = forms.case.surface[0]
    if surface.kind == "cylinder":
        return surface.center[0] + surface.radius * phi_y
    return surface.center[0] if phi_y == 0.0 else None
