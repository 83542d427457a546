"""From which thickness on the half-space stands for a body: the figures of the message and of the theory."""

from __future__ import annotations

import math
import re

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
