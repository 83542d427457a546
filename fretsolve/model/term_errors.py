"""What leaving a term of the model out costs in accuracy, before anything is solved.

Sphere on flat. With m = |Dundurs' constant|, mu the coefficient of friction and r = m/mu:

- What shear does to pressure is second order in m at full stick and first order in mu below it, so its errors go as
  m min(m, k mu), whatever the other constants. The factors come from the study.
- What pressure does to shear depends on r alone (Spence's scaling: pressing uses up a part of the friction bound that
  only r decides), as r^2 for small r, since an error odd in m would change with the sign of the load, and no more than
  what full slip leaves for large r: k r^2/(s + r^2). Beside it stands what the changed pressure does, k m^2.
- The stick radius of pressing alone is Spence's, less by k m^2.
- Without ux from qy and uy from qx a torque meets A + 3B/4 where A + B is right (the mean of the direct influence over
  the directions), which makes B/4(A + B) of its rotation; a force errs by n^2/(1 + n) with n = B/A.

The factors are fitted to ``python benchmarks/terms.py``, which prints how far they hold: mostly within a factor of two
for a sphere, a load of nine tenths of sliding, Dundurs' constants of 0.003 to 0.5 and friction of 0.1 to 0.6. Errors
of the pressure are those of pressing; they are smaller after a force or a torque. Smaller loads move less: their errors
of displacement are smaller, that of the work, which is little then, is larger.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from fretsolve.model.materials import Compliances
from fretsolve.reference.closed_forms import spence_stick_ratio

Drive = Literal["pressing", "force", "torque"]
"""What moves the contact: P alone, or with it Qx and Qy (or their displacements), or Mz (or its rotation)."""

PRESSURE = {"delta_z": (0.15, 1.0), "contact_radius": (0.25, 1.0), "max_pressure": (1.0, 3.2)}
"""k and the factor of mu in k m min(m, factor mu): errors of pressing, over the value."""


@dataclass(frozen=True)
class _Saturating:
    """k r^2/(s + r^2) + c m^2."""

    k: float
    s: float
    c: float

    def __call__(self, m: float, friction: float) -> float:
        ratio = (m / friction) ** 2
        return min(self.k * ratio / (self.s + ratio) + self.c * m**2, 1.0)


MOTION = {"force": _Saturating(0.2, 1.0, 0.25), "torque": _Saturating(0.22, 0.8, 1.2)}
"""Errors of the tangential displacement or the rotation, over the value."""

STICK = {"force": _Saturating(0.3, 0.8, 0.3), "torque": _Saturating(0.5, 2.0, 0.5)}
"""Errors of the stick radius, over the contact radius."""

STICK_PRESSED = 0.5
"""The factor of m^2 beside Spence's radius, who leaves out what the shear does to the pressure."""

WORK = {"force": _Saturating(0.9, 0.6, 0.5), "torque": _Saturating(0.8, 0.8, 1.0)}
"""Errors of the work from no load to the first peak, over the value; of pressing alone all of it is missed."""

CROSS_FORCE = {"motion": 0.007, "stick_radius": 0.006, "work_total": 0.03}
"""Factors of n^2/(1 + n) without ux from qy and uy from qx under a force: errors over the value, the stick radius's
over the contact radius."""


FIELDS = 4.0
"""Largest change of a cell's shear over the largest friction bound, or of its pressure over the largest, in units of
m max(mu, 1/mu): 1.5 on 24 x 24 cells, 3 on 64 x 64; at the edges, where the fields rise steeply, it grows slowly."""


@dataclass(frozen=True)
class TermError:
    """The expected error of a quantity of the history over its value, of the stick radius over the contact radius."""

    quantity: str
    share: float

    def __str__(self) -> str:
        of = "the contact radius in stick_radius" if self.quantity == "stick_radius" else self.quantity
        return f"{_percent(self.share)} of {of}"


def coupling_errors(material: Compliances, friction: float, drive: Drive, motion: str = "") -> Iterator[TermError]:
    """Errors without the coefficients between pressure and shear; friction > 0; motion: the one that is driven."""
    m = abs(material.dundurs_constant)
    for name, (k, factor) in PRESSURE.items():
        yield TermError(name, k * m * min(m, factor * friction))
    if drive == "pressing":
        slipping = 1.0 - spence_stick_ratio(friction, m)
        yield TermError("stick_radius", min(slipping + STICK_PRESSED * m**2, 1.0))
        yield TermError("work_total", 1.0 if m else 0.0)
        return
    yield TermError(motion, MOTION[drive](m, friction))
    yield TermError("stick_radius", STICK[drive](m, friction))
    yield TermError("work_total", WORK[drive](m, friction))


def cross_errors(material: Compliances, drive: Drive, motion: str) -> Iterator[TermError]:
    """Errors without ux from qy and uy from qx, under a force or a torque."""
    if drive == "torque":
        share = 0.25 * abs(material.B) / material.torsional
        yield TermError(motion, share)
        yield TermError("work_total", share)
        return
    ratio = material.B / material.A
    for name, factor in CROSS_FORCE.items():
        yield TermError(motion if name == "motion" else name, factor * ratio**2 / (1.0 + ratio))


def negligible_coupling(material: Compliances, friction: float, tolerance: float) -> bool:
    """Whether what pressure and shear do to each other stays below `tolerance` in every field, pointwise.

    Pressing causes a shear of up to m times the pressure, r of the friction bound; a tangential force shifts the
    contact by m mu of its radius, which shows most at its edge. Scalars of the history change by the square of these.
    """
    m = abs(material.dundurs_constant)
    return m == 0.0 or FIELDS * m * max(friction, 1.0 / friction) <= tolerance


def _percent(share: float) -> str:
    percent = 100.0 * share
    return f"{percent:.2g} %" if percent < 99.5 else "100 %"
