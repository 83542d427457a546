"""From which thickness of a body on the half-space stands for it: what messages and the theory say, checked."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from scipy.integrate import quad

from fretsolve.case.other_names import not_modelled

POISSON = (0.0, 0.3, 0.5 - 1e-9)


def compliance(s: float, nu: float) -> float:
    """The compliance L of a layer bonded to a rigid base over the half-space's, by the formula of the theory."""
    kappa = 3.0 - 4.0 * nu
    if s > 20.0:
        return 1.0
    above = 2.0 * kappa * math.sinh(2.0 * s) - 4.0 * s
    return above / (2.0 * kappa * math.cosh(2.0 * s) + 4.0 * s**2 + 1.0 + kappa**2)


def solved_compliance(s: float, nu: float) -> float:
    """L from the general solution in plane strain: uz = sin(kx) w(z), ux = cos(kx) v(z), the thickness being 1.

    Four solutions of Navier's equations, (v, w) = e^(+-sz) (1, +-1) and e^(+-sz) (z, +-z - kappa/s), are superposed
    to u = 0 on the base at z = 0 and to a normal traction alone on the surface at z = 1, with G = 1.
    """
    kappa = 3.0 - 4.0 * nu
    rows = np.zeros((4, 4))
    for column, (sign, linear) in enumerate([(1, 0), (-1, 0), (1, 1), (-1, 1)]):
        k = sign * s

        def fields(z: float, k: float = k, linear: int = linear) -> tuple[float, float, float, float]:
            """v, w and their derivatives."""
            e = math.exp(k * z - abs(k) * (k > 0))
            if not linear:
                return e, math.copysign(1.0, k) * e, k * e, abs(k) * e
            w = math.copysign(1.0, k) * z - kappa / s
            return z * e, w * e, (1.0 + k * z) * e, (math.copysign(1.0, k) + k * w) * e

        v, w, _, _ = fields(0.0)
        rows[0, column], rows[1, column] = v, w
        v, w, dv, dw = fields(1.0)
        # ux = v cos, uz = w sin: szz = lambda (-s v + w') + 2 w', sxz = v' + s w; lambda over 2 nu/(1 - 2 nu)
        rows[2, column] = dv + s * w
        rows[3, column] = 2.0 * nu / (1.0 - 2.0 * nu) * (dw - s * v) + 2.0 * dw
    parts = np.linalg.solve(rows, [0.0, 0.0, 0.0, 1.0])
    surface = 0.0
    for part, (sign, linear) in zip(parts, [(1, 0), (-1, 0), (1, 1), (-1, 1)], strict=True):
        k = sign * s
        e = math.exp(k - abs(k) * (k > 0))
        surface += part * e * (sign if not linear else sign - kappa / s)
    return surface / ((1.0 - nu) / s)  # the half-space: (1 - nu)/(G k)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45])
@pytest.mark.parametrize("s", [0.3, 1.0, 3.0])
def test_the_compliance_of_a_layer(s: float, nu: float) -> None:
    assert solved_compliance(s, nu) == pytest.approx(compliance(s, nu), rel=1e-10)


def integral(power: int, nu: float) -> float:
    return float(quad(lambda s: (compliance(s, nu) - 1.0) * s**power, 1e-6, 20.0, limit=200)[0])


def test_the_figures_that_are_told() -> None:
    said = not_modelled("thickness")
    assert said is not None
    approach = [-4.0 * integral(0, nu) / (3.0 * math.pi) for nu in POISSON]
    pressure = [-4.0 * integral(2, nu) / (9.0 * math.pi) for nu in POISSON]
    line = [-integral(1, nu) / 4.0 for nu in POISSON]
    told = re.search(
        r"(\d+) contact radii .* by (\d) to (\d) % .* less than ([\d.]+) %; a base (\d) .* and (\d) to (\d) %", said
    )
    assert told is not None
    far, least, most, negligible, near, low, high = map(float, told.groups())
    assert [round(100.0 * value / far) for value in (min(approach), max(approach))] == [least, most]
    assert 100.0 * max(pressure) / far**3 < negligible
    assert [round(100.0 * value / near**3) for value in (min(pressure), max(pressure))] == [low, high]
    # the table of the theory
    assert [round(100.0 * value / 3.0) for value in (min(approach), max(approach))] == [17, 25]
    assert [round(100.0 * value / 1e3, 2) for value in (min(pressure), max(pressure))] == [0.03, 0.05]
    assert [round(100.0 * value / 1e2, 1) for value in (min(line), max(line))] == [0.3, 0.5]
    assert [round(100.0 * value / 9.0) for value in (min(line), max(line))] == [3, 6]
