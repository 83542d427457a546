"""Wear of a cylinder on a flat that is moved beyond gross slip, against the closed forms of a uniform pressure.

Every place slips as far, so that the pressure becomes uniform. A cycle between +-D dissipates 4 mu P (D - u), with the
displacement u by the shear, weighed by it: (A mu P/pi) (ln(L/2a) + 3/2), L = d exp(1/(2 (1 - nu))), for points d deep.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from command_line import invoke
from line_cases import solve_line
from scipy.integrate import solve_ivp

from fretsolve import open_result
from fretsolve.reference.hertz import HertzLine
from fretsolve.reference.worn_contact import CylinderWornByGrossSlip

POISSON, DEPTH, LIMIT, ALPHA = 0.3, 10.0, 50.0, 1e-7
A = 2.0 * (1.0 - POISSON) / (210e3 / 2.6)
STEEL = {"young_modulus": 210e3, "poisson_ratio": POISSON}
HERTZ = HertzLine(100.0, 10.0, 2.0 / A)


def scar(volume):
    return CylinderWornByGrossSlip(HERTZ, volume, DEPTH * math.exp(-0.5 / (1.0 - POISSON)))


def volume_after(cycles, motion=5e-3):
    """The worn volume (mm^3/mm) by the energy law."""

    def rate(_, volume):
        width = 2.0 * scar(max(float(volume[0]), 1e-12)).scar_radius
        logarithm = math.log(DEPTH / width) + 0.5 / (1.0 - POISSON)
        return [ALPHA * 4.0 * LIMIT * (motion - A * LIMIT / math.pi * (logarithm + 1.5))]

    return float(solve_ivp(rate, (0.0, cycles), [0.0], rtol=1e-9, atol=1e-12).y[0, -1])


def worn(cycles, name="delta_x", most=5e-3, points=64, law=None, **keys):
    """The states of a run."""
    stages = [{name: -most, "increments": 2}, {name: most, "increments": 2}]
    return solve_line(
        bodies=[STEEL, STEEL],
        friction=0.5,
        reference_depth=DEPTH,
        grid={"points": points},
        wear=law or {"law": "energy", "alpha": ALPHA},
        load_path=[{"P": 100.0}, {name: most, "increments": 2}, {"cycle": {"represents": cycles, "stages": stages}}],
        **keys,
    )


def test_closed_forms_of_the_scar():
    """Depth, width and volume are one profile; the closed form begins where nothing is worn with sqrt(3)/2 a0."""
    found = scar(7e-3)
    x = np.linspace(-found.scar_radius, found.scar_radius, 20001)
    a, p = found.scar_radius, found.mean_pressure
    with np.errstate(divide="ignore", invalid="ignore"):
        terms = [np.where(t > 0.0, t * np.log(t), 0.0) for t in (a + x, a - x)]
    sunk = A / math.pi * p * (2.0 * a - sum(terms))
    depth = (a**2 - x**2) / 20.0 + sunk[0] - sunk
    assert np.trapezoid(depth, x) == pytest.approx(7e-3, rel=1e-6)
    assert depth[10000] == pytest.approx(found.center_depth, rel=1e-9)
    assert scar(1e-12).scar_radius == pytest.approx(0.8660254 * HERTZ.half_width, rel=1e-6)


def check_scar(row):
    assert row.wear_volume == pytest.approx(ALPHA * row.work_total, rel=1e-12)
    known = scar(row.wear_volume)
    assert row.contact_radius == pytest.approx(known.scar_radius, rel=0.015)
    assert row.wear_depth_max == pytest.approx(known.center_depth, rel=5e-3)
    assert row.delta_z == pytest.approx(known.delta_z, rel=1e-3)


@pytest.mark.parametrize(("name", "most", "rig"), [("delta_x", 5e-3, None), ("actuator_x", 7.5e-3, 20e3)])
def test_gross_slip_wears_a_bowl(name, most, rig):
    """With the actuator of a rig in series, where the contact moves by D - C mu P."""
    parts = {} if rig is None else {"rig": {"stiffness_x": rig}}
    states = worn(4e4, name, most, **parts)
    last = states[-1].summary
    check_scar(last)
    assert last.delta_x == pytest.approx(5e-3, rel=1e-6)
    assert last.wear_volume == pytest.approx(volume_after(4e4), rel=5e-3)
    assert last.wear_error < 0.01 * last.wear_volume
    # uniform but for the cells that have just come into contact
    pressure = states[-1].fields.pressure[:, 0]
    inner = pressure[np.flatnonzero(pressure)[6:-6]]
    assert np.ptp(inner) < 0.1 * inner.mean()


def test_archard_wears_as_the_energy_law_with_k_over_mu():
    energy, archard = (worn(1e3, law=law)[-1].summary for law in (None, {"law": "archard", "k": 0.5 * ALPHA}))
    assert archard.wear_volume == pytest.approx(energy.wear_volume, rel=1e-3)


def test_the_cost_of_gross_slip():
    """All cells slip at once, without a search for zones."""
    states = worn(1e4, points=256)
    assert sum(state.summary.operator_applications for state in states) < 12 * len(states)


@pytest.mark.slow
def test_1e5_cycles_by_the_command_line(tmp_path):
    case = tmp_path / "cylinder.yaml"
    case.write_text(
        """
title: cylinder on a flat, gross slip
plane: strain
bodies: [{young_modulus: 210 GPa, poisson_ratio: 0.3}, {young_modulus: 210 GPa, poisson_ratio: 0.3}]
surface: {cylinder: {radius: 10 mm}}
grid: {points: 128}
friction: 0.5
reference_depth: 10 mm
wear: {law: energy, alpha: 1e-4 mm^3/J}
load_path:
  - {P: 100 N/mm}
  - {delta_x: 5 um, increments: 2}
  - cycle: {represents: 1e5, stages: [{delta_x: -5 um, increments: 2}, {delta_x: 5 um, increments: 2}]}
"""
    )
    out = tmp_path / "cylinder.h5"
    done = invoke("run", case, "-q", "-o", out)
    assert done.exit_code == 0, done.output
    with open_result(out) as result:
        last = {name: values[-1] for name, values in result.history.items()}
    assert last["cycles"] == 1e5
    assert last["wear_volume"] == pytest.approx(ALPHA * last["work_total"], rel=1e-12)
    # by the closed form 7.313757e-3 mm^3/mm, 0.484478 mm, 11.35350 um and 13.18139 um
    assert volume_after(1e5) == pytest.approx(7.313757e-3, rel=1e-6)
    assert last["wear_volume"] == pytest.approx(7.313757e-3, rel=3e-3)
    assert last["wear_error"] < 0.01 * last["wear_volume"]
    assert last["contact_radius"] == pytest.approx(0.484478, rel=1e-2)
    assert last["wear_depth_max"] == pytest.approx(11.35350e-3, rel=3e-3)
    assert last["delta_z"] == pytest.approx(13.18139e-3, rel=1e-3)
    for kind in ("wear", "loop"):
        assert invoke("plot", out, kind, "-o", tmp_path / f"{kind}.png").exit_code == 0
