"""Fits to loops of finer grids with noise and drift: bounds that hold, and derivatives against Mindlin's.

The loop is solved on 48 x 48 cells and 60 increments per half cycle, the fits on 24 x 24 cells, so that errors of the
grid count as well. Force and motion have noise of 1 % of their amplitudes, offsets and linear drifts.
"""

from __future__ import annotations

import multiprocessing
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from fitting import FIT_CASE, Array, mindlin_branch, record, write_record

from fretsolve import load_case, run
from fretsolve.sweep.fit.evaluation import Evaluator, LoopSolver
from fretsolve.sweep.fit.least_squares import fit_loop
from fretsolve.sweep.fit.plan import FitRequest, make_fit_plan
from fretsolve.sweep.fit.report import doubts, exceeded, notes

SEEDS = 20
PARTIAL = ("rig.stiffness_x",), 1.5, ("friction=0.1",)
GROSS = ("friction", "rig.stiffness_x"), 4.0, ()
TRUE = {"friction": 0.1, "rig.stiffness_x": 50.0}


def solved_branch(folder: Path, reach: float) -> tuple[Array, Array]:
    """The way down of a settled loop between `reach` and `-reach` (um): motion (mm) and force (N)."""
    path = "".join(f"  - {{actuator_x: {sign * reach} um, increments: 60}}\n" for sign in (1, -1, 1, -1))
    text = FIT_CASE.replace("points: 24", "points: 48").replace("0.14", "0.1").replace("70 kN", "50 kN")
    case = folder / "truth.yaml"
    case.write_text(text.partition("  - {actuator_x")[0] + path + "output: {fields: []}\n")
    last = [state.summary for state in run(load_case(case))][-61:]
    return np.array([one.actuator_x for one in last]), np.array([one.Qx for one in last])


def fitted(case: Path, loop: Path, names: tuple[str, ...], overrides: tuple[str, ...]) -> tuple[Array, Array]:
    """The 95 % bounds of a fit."""
    return fit_loop(make_fit_plan(FitRequest(case, overrides, loop, names))).bounds


@pytest.mark.slow
@pytest.mark.parametrize(("names", "reach", "overrides"), [PARTIAL, GROSS], ids=["partial slip", "gross slip"])
def test_bounds_hold_the_true_values(
    tmp_path: Path, names: tuple[str, ...], reach: float, overrides: tuple[str, ...]
) -> None:
    branch, case = solved_branch(tmp_path, reach), tmp_path / "case.yaml"
    case.write_text(FIT_CASE)
    loops = [
        write_record(tmp_path / f"loop{seed}.csv", record(branch, seed=seed, noise=0.01, shake=0.01))
        for seed in range(SEEDS)
    ]
    true = [TRUE[name] for name in names]
    with ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as pool:
        bounds = list(pool.map(fitted, [case] * SEEDS, loops, [names] * SEEDS, [overrides] * SEEDS))
    held = np.array([(low <= true) & (true <= high) for low, high in bounds])
    assert np.all(held.sum(axis=0) >= 18), held.sum(axis=0)
    # the bounds say something
    assert np.all([high / low < 1.07 for low, high in bounds])


@pytest.mark.slow
def test_friction_is_invisible_below_gross_slip(tmp_path: Path) -> None:
    """At 3 % of the limit the slip ring is thinner than a cell: the stiffness is known, friction is not."""
    case = tmp_path / "case.yaml"
    case.write_text(FIT_CASE)
    loop = write_record(tmp_path / "loop.csv", record(mindlin_branch(0.1, 50e3, 0.05e-3), noise=0.01))
    fit = fit_loop(make_fit_plan(FitRequest(case, (), loop, GROSS[0])))
    assert fit.values[1] == pytest.approx(50.0, rel=0.01)
    assert fit.widths[1] < 0.01
    reason = "is not determined: the loop stays below gross slip while rig.stiffness_x is free"
    assert list(doubts(fit)) == [f"friction {reason}", "the 95 % bound of friction exceeds friction itself"]


@pytest.mark.slow
def test_rig_and_layer_are_hardly_told_apart(tmp_path: Path) -> None:
    """One loop in gross slip tells friction, but not which of both in series gives how much."""
    case = tmp_path / "case.yaml"
    case.write_text(FIT_CASE + "interface: {shear_compliance: 4e-6 mm/MPa}\n")
    loop = write_record(tmp_path / "loop.csv", record(mindlin_branch(0.1, 50e3, 4e-3), noise=0.01, shake=0.01))
    names = (*GROSS[0], "interface.shear_compliance")
    fit = fit_loop(make_fit_plan(FitRequest(case, (), loop, names)))
    low, high = fit.bounds
    assert low[0] < 0.1 < high[0]
    assert fit.widths[0] < 0.05
    assert abs(fit.correlation[1, 2]) > 0.95
    assert any("rig.stiffness_x and interface.shear_compliance are" in one for one in (*notes(fit), *doubts(fit)))
    assert exceeded(fit)


@pytest.mark.slow
def test_derivatives_against_mindlin(tmp_path: Path) -> None:
    """Of the force at the motion of 36 N, by friction and by both moduli, from the elasticities of the motion.

    At a given motion d ln Q/d ln mu = 0.647632/1.647632, and d ln Q/d ln E = (2/3)/1.647632.
    """
    reach = 0.863748e-3
    time = 0.25 + np.arange(401) / 200.0
    motion = reach * np.sin(2.0 * np.pi * time)
    loop = write_record(tmp_path / "loop.csv", (time, 36.0 * np.sin(2.0 * np.pi * time + 0.1), motion), "delta_x (um)")
    case = tmp_path / "case.yaml"
    text = FIT_CASE.replace("rig: {stiffness_x: 70 kN/mm}   # from its data sheet\n", "").replace(
        "actuator_x", "delta_x"
    )
    case.write_text(text.replace("points: 24", "points: 64").replace("0.14", "0.1") + "coupling: none\n")
    names = ("friction", "bodies.0.young_modulus", "bodies.1.young_modulus")
    plan = make_fit_plan(FitRequest(case, (), loop, names, offset=False))
    evaluator = Evaluator(
        plan.models[-1], plan.loop, np.zeros((len(plan.loop.force), 0)), LoopSolver(1), lambda *_: None
    )
    start = np.zeros(3)
    evaluator.residuals(start)
    force, _ = evaluator.branches(start).at(plan.loop)
    derivatives = plan.loop.range * evaluator.central(start)
    top = int(np.argmax(force))
    assert force[top] == pytest.approx(36.0, rel=2e-3)
    by_friction, *by_moduli = derivatives[top] / force[top]
    assert by_friction == pytest.approx(0.647632 / 1.647632, rel=5e-3)
    assert sum(by_moduli) == pytest.approx((2.0 / 3.0) / 1.647632, rel=5e-3)
