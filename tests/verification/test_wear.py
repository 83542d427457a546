"""Wear of a sphere: partial and gross slip against rings (axisymmetric, independent), order in the jump, smoothness.

Without units R = E* = a0 = 1. Partial slip has c/a0 = 0.5 and counts cycles by T = 4 k mu N E* a0/R, gross slip by
T = V/V0 = k P S N/V0.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from fretsolve import run
from fretsolve.case.models import Case
from fretsolve.reference.worn_contact import WornLimit
from fretsolve.result.state import State

RADIUS, MODULUS, A0, ALPHA = 10.0, 1e5, 0.3, 1e-7
P0, D0, V0 = 4.0 / 3.0 * MODULUS * A0**3 / RADIUS, A0**2 / RADIUS, math.pi * A0**4 / (4.0 * RADIUS)
CHECKERBOARD = 0.580693
"""Least eigenvalue of the normal compliance of square cells, over dx/E*."""


def sphere(points: int, size: float | None, friction: Any, stages: list[Any]) -> Case:
    return Case.model_validate(
        {
            "bodies": ["rigid", {"young_modulus": MODULUS, "poisson_ratio": 0.0}],
            "surface": {"sphere": {"radius": RADIUS}},
            "grid": {"points": points, "size": "auto" if size is None else size * A0},
            "coupling": "none",
            "friction": friction,
            "wear": {"law": "energy", "alpha": ALPHA},
            "load_path": stages,
        }
    )


def cycle(name: str, most: float, cycles: float, jump: float | str = "auto") -> dict[str, Any]:
    stages = [{name: -most, "increments": 2}, {name: most, "increments": 2}]
    return {"cycle": {"represents": round(cycles), "jump": jump, "stages": stages}}


def partial_slip(
    held: str, time: float, points: int, jumps: int = 0, size: float | None = 2.7, c: float = 0.5
) -> list[State]:
    mu = 0.2
    cycles = round(time / (4.0 * ALPHA * mu**2 * MODULUS * A0 / RADIUS))
    name, most = ("Qx", mu * P0 * (1.0 - c**3)) if held == "P" else ("delta_x", mu * D0 * (1.0 - c**2))
    press = {"P": P0} if held == "P" else {"delta_z": D0}
    jump = -(-cycles // jumps) if jumps else "auto"
    return list(run(sphere(points, size, mu, [press, {name: most, "increments": 4}, cycle(name, most, cycles, jump)])))


def gross_slip(time: float, points: int, size: float, jump: float | str = "auto", friction: Any = 0.01) -> list[State]:
    most = 0.01
    cycles = time * V0 / (ALPHA * 0.01 * P0 * 4.0 * most)
    stages = [{"P": P0}, {"delta_x": most, "increments": 1}, cycle("delta_x", most, cycles, jump)]
    return list(run(sphere(points, size, friction, stages)))


@pytest.mark.parametrize(
    ("held", "time", "volume", "load", "approach"),
    [
        ("P", 0.1, 0.01182, 1.0, 1.00321),
        ("P", 1.0, 0.13139, 1.0, 1.03158),
        ("d", 0.1, 0.01175, 0.99524, 1.0),
        ("d", 1.0, 0.12334, 0.95361, 1.0),
    ],
)
def test_partial_slip_wears_as_rings_do(held, time, volume, load, approach):
    last = partial_slip(held, time, 48)[-1].summary
    assert last.wear_volume / V0 == pytest.approx(volume, rel=0.01)
    assert last.delta_z / D0 == pytest.approx(approach, rel=1e-3)
    assert pytest.approx(load * P0, rel=1e-3) == last.P
    assert last.wear_error < 0.01 * last.wear_volume
    assert last.stick_radius == pytest.approx(0.5 * A0, rel=0.02)  # it is conserved


@pytest.mark.parametrize(
    ("time", "size", "approach", "radius", "middle"),
    [(1.0, 2.8, 1.1538, 1.2135, 0.31907), (10.0, 4.1, 1.9799, 1.8385, 1.5010)],
)
def test_gross_slip_wears_as_rings_do(time, size, approach, radius, middle):
    last = gross_slip(time, 47, size)[-1]
    row = last.summary
    worn = row.wear_volume / V0
    assert worn == pytest.approx(time, rel=0.01)
    # by the law of gross slip, d grows by about 2 T^0.5 dT/2T: compare at the volume that is worn
    shift = math.sqrt(worn / time)
    assert row.delta_z / D0 == pytest.approx(approach * shift, rel=0.005)
    assert row.contact_radius / A0 == pytest.approx(radius, rel=0.005)
    assert last.fields.wear_depth[23, 23] / D0 == pytest.approx(middle * shift, rel=0.01)


@pytest.mark.parametrize(("held", "size"), [("P", 3.6), ("d", 3.0)])
@pytest.mark.parametrize("points", [32, pytest.param(48, marks=pytest.mark.slow)])
def test_wear_ends_at_the_worn_limit(held, size, points):
    """Cells stick as a whole, so that volume and load are those of the limit for a stick radius within a cell."""
    last = partial_slip(held, 100.0, points, 10, size)[-1].summary
    c = brentq(lambda c: WornLimit(c, last.delta_z, RADIUS, MODULUS).load - last.P, 0.3 * A0, 0.8 * A0)
    assert c == pytest.approx(0.5 * A0, abs=0.25 * size * A0 / points)
    assert last.wear_volume == pytest.approx(WornLimit(c, last.delta_z, RADIUS, MODULUS).volume, rel=5e-3)


@pytest.mark.parametrize(("time", "radius"), [(10.0, 1.76), (30.0, 2.48)])
def test_automatic_size_holds_the_scar_around_a_small_stick_zone(time, radius):
    """The less sticks, the faster wear grows: at c = a0/5 the volume is four times that at the first rate."""
    last = partial_slip("P", time, 32, 15, None, 0.2)[-1]
    cell_area = last.summary.wear_volume / float(last.fields.wear_depth.sum())
    half_side = 0.5 * 32 * math.sqrt(cell_area)
    assert last.summary.contact_radius / A0 == pytest.approx(radius, rel=0.05)
    assert half_side > 1.1 * radius * A0


@pytest.mark.slow
def test_the_error_falls_with_the_second_power_of_the_jump():
    exact = partial_slip("P", 1.0, 32, 80)[-1].summary.wear_volume
    found = [partial_slip("P", 1.0, 32, jumps)[-1].summary for jumps in (3, 6, 12)]
    errors = [abs(row.wear_volume / exact - 1.0) for row in found]
    assert errors[0] < 5e-3 and errors[1] < 0.35 * errors[0] and errors[2] < 0.35 * errors[1]
    assert all(error * exact < row.wear_error for error, row in zip(errors, found, strict=True))


def test_no_checkerboard_grows_at_30_times_the_limit_of_explicit_jumps():
    dx, jump = 4.1 * A0 / 47, 300_000.0
    explicit = jump * ALPHA * 0.01 * 4.0 * 0.01  # depth of an explicit jump over the pressure
    assert explicit > 30.0 * 2.0 * CHECKERBOARD * dx / MODULUS
    states = gross_slip(10.0, 47, 4.1, jump)
    pressure = next(state for state in states if state.summary.jump > 1.0).fields.pressure
    # the part of the pressure that alternates from cell to cell, in the middle of the contact
    sign = np.where(np.add.outer(np.arange(10), np.arange(10)) % 2, 1.0, -1.0)
    alternating = (sign * pressure[18:28, 18:28]).mean()
    assert abs(alternating) < 1e-3 * pressure[23, 23]


def test_friction_runs_in_by_the_energy_of_all_cycles():
    friction = {"initial": 0.01, "final": 0.02, "energy": 100.0}
    states = gross_slip(0.5, 24, 2.8, friction=friction)
    before, last = states[-2], states[-1]
    mu = 0.02 - 0.01 * np.exp(-before.fields.wear_depth / ALPHA / 100.0)
    cell = (2.8 * A0 / 24) ** 2
    assert last.summary.Qx == pytest.approx(float((mu * last.fields.pressure).sum()) * cell, rel=1e-6)
    assert mu.max() > 0.0195


def test_a_line_contact_wears_by_pressure_times_path():
    from fretsolve.case.line_case import LineCase

    case = LineCase.model_validate(
        {
            "plane": "strain",
            "coupling": "none",
            "bodies": ["rigid", {"young_modulus": MODULUS, "poisson_ratio": 0.0}],
            "surface": {"cylinder": {"radius": RADIUS}},
            "grid": {"points": 128, "size": 1.2},
            "friction": 0.01,
            "wear": {"law": "archard", "k": 1e-9, "share": [0.0, 1.0]},
            "load_path": [{"P": 300.0}, {"Qx": 1.5, "increments": 1}, cycle("Qx", 1.5, 1e6)],
            "output": {"fields": ["wear_depth", "wear_depth_1", "wear_depth_2"]},
        }
    )
    states = list(run(case))
    last = states[-1]
    assert last.summary.cycles == 1e6
    assert last.summary.wear_volume == pytest.approx(1e-7 * last.summary.work_total, rel=1e-9)
    np.testing.assert_array_equal(last.fields.wear_depth_2, last.fields.wear_depth)
    assert not last.fields.wear_depth_1.any()
    first = next(state.summary for state in states if state.summary.stage == 2)
    assert last.summary.stick_radius == pytest.approx(first.stick_radius, rel=0.05)
