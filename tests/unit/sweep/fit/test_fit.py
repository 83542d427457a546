"""Fits to loops of Cattaneo and Mindlin, whose closed form takes the place of the solver: what is found and said."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command_line import invoke, refused
from fitting import FIT_CASE, mindlin_branch, mindlin_branches, record, write_record
from numpy.typing import NDArray
from scipy.signal import lfilter
from small_cases import write_case

from fretsolve.case.loading import load_case
from fretsolve.errors import CaseError
from fretsolve.sweep.fit import least_squares
from fretsolve.sweep.fit.least_squares import Fit, covariance, fit_loop
from fretsolve.sweep.fit.model_loop import LoopModel
from fretsolve.sweep.fit.plan import FitRequest, make_fit_plan
from fretsolve.sweep.fit.report import doubts, exceeded, hardly_apart, undetermined_words

TRUE = np.array([0.1, 50.0])
BOTH = ("friction", "rig.stiffness_x")
GROSS, PARTIAL, SMALL = (mindlin_branch(0.1, 50e3, reach) for reach in (4e-3, 1.5e-3, 0.05e-3))


@pytest.fixture(autouse=True)
def closed_form(monkeypatch: pytest.MonkeyPatch) -> None:
    """The closed form in place of the solver."""
    monkeypatch.setattr(LoopModel, "branches", mindlin_branches)


def fit(
    folder: Path,
    branch: tuple[NDArray[np.float64], NDArray[np.float64]],
    names: tuple[str, ...] = BOTH,
    *,
    overrides: tuple[str, ...] = (),
    offset: bool = True,
    **options: float | bool,
) -> Fit:
    loop = write_record(folder / "loop.csv", record(branch, **options))
    request = FitRequest(write_case(folder, FIT_CASE), overrides, loop, names, offset=offset)
    return fit_loop(make_fit_plan(request))


def test_gross_slip_tells_friction_and_stiffness(tmp_path: Path) -> None:
    found = fit(tmp_path, GROSS)
    np.testing.assert_allclose(found.values, [0.1, 50.0], rtol=1e-3)
    assert found.rms < 1e-3 * 80.0
    assert found.branches.slides
    measured, fitted = found.energies
    assert measured == pytest.approx(fitted, rel=1e-3)
    # the record has an offset of 4 N, and a drift of 2 N over a cycle
    assert np.ptp(found.drift) == pytest.approx(2.0, rel=0.02)


def test_white_noise_leaves_no_doubts(tmp_path: Path) -> None:
    assert list(doubts(fit(tmp_path, GROSS, noise=0.01, shake=0.01))) == []


def held(folder: Path, **options: float | bool) -> NDArray[np.int_]:
    """In how many of twenty records friction and stiffness are within the bounds."""
    bounds = [fit(folder, GROSS, noise=0.01, shake=0.01, seed=seed, **options).bounds for seed in range(20)]
    return np.sum([(low <= TRUE) & (high >= TRUE) for low, high in bounds], axis=0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("start", "cycles"), [(0.2, 1.0), (0.24, 1.0), (0.25, 1.0), (0.26, 1.0), (0.25, 1.02), (0.5, 1.0)]
)
def test_bounds_hold_where_a_single_drifting_cycle_is_closed(tmp_path: Path, start: float, cycles: float) -> None:
    assert np.all(held(tmp_path, start=start, cycles=cycles) >= 18)


@pytest.mark.slow
@pytest.mark.parametrize("slow", [0.0, 0.5, 0.9])
def test_bounds_hold_with_slow_noise(tmp_path: Path, slow: float) -> None:
    assert np.all(held(tmp_path, slow=slow) >= 18)


def test_slow_noise_is_told(tmp_path: Path) -> None:
    (said,) = doubts(fit(tmp_path, GROSS, noise=0.01, slow=0.9))
    assert said.startswith("the residual is correlated along the loop, 0.")
    assert said.endswith("the noise is slow, or the model misses something; the bounds are wider for it")


def test_search_that_ends_too_early_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(least_squares, "STEPS", 1)
    found = fit(tmp_path, GROSS, noise=0.01)
    assert any(said.startswith("the search stopped after ") for said in doubts(found))


def test_parameter_at_the_limit_of_the_search_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(least_squares, "FARTHEST", 0.2)
    found = fit(tmp_path, GROSS, noise=0.01)
    assert found.values[0] == pytest.approx(0.14 * np.exp(-0.2), rel=1e-3)
    assert "friction went as far from its start, 0.14, as the search does" in list(doubts(found))


def test_bound_above_twice_the_value_exceeds(tmp_path: Path) -> None:
    found = fit(tmp_path, SMALL, noise=0.01)
    for factor, exceeds in ((1.9, False), (2.1, True)):
        spread = np.diag([(np.log(factor) / found.quantile) ** 2, 1e-6])
        assert exceeded(replace(found, covariance=spread)) is exceeds
        assert len(list(replace(found, covariance=spread).undetermined)) == exceeds


def test_partial_slip_of_known_friction_tells_the_stiffness(tmp_path: Path) -> None:
    found = fit(tmp_path, PARTIAL, ("rig.stiffness_x",), overrides=("friction=0.1",))
    np.testing.assert_allclose(found.values, [50.0], rtol=2e-3)
    assert not found.branches.slides


def test_starts_far_off(tmp_path: Path) -> None:
    for overrides in (("friction=0.5", "rig.stiffness_x=500 kN/mm"), ("friction=0.02", "rig.stiffness_x=10 kN/mm")):
        found = fit(tmp_path, GROSS, overrides=overrides)
        np.testing.assert_allclose(found.values, [0.1, 50.0], rtol=2e-3)


def test_without_offset_a_centred_record_is_fitted_as_it_is(tmp_path: Path) -> None:
    found = fit(tmp_path, GROSS, offset=False, drifts=False)
    np.testing.assert_allclose(found.values, [0.1, 50.0], rtol=2e-3)
    assert not found.drift.any()


def test_bounds_shrink_with_the_noise(tmp_path: Path) -> None:
    wide, narrow = (fit(tmp_path, GROSS, noise=noise, seed=2).widths for noise in (0.02, 0.005))
    np.testing.assert_allclose(wide / narrow, 4.0, rtol=0.3)


def test_noise_of_the_motion_counts_in_noise_and_bounds(tmp_path: Path) -> None:
    still, shaken = (fit(tmp_path, GROSS, noise=0.01, shake=shake, seed=4) for shake in (0.0, 0.01))
    assert shaken.noise == pytest.approx(shaken.rms, rel=0.25)
    assert still.noise == pytest.approx(still.rms, rel=0.25)
    assert np.all(shaken.widths > 1.5 * still.widths)


def test_friction_below_gross_slip_is_not_determined(tmp_path: Path) -> None:
    found = fit(tmp_path, SMALL, noise=0.01)
    assert exceeded(found)
    said = list(doubts(found))
    reason = "is not determined: the loop stays below gross slip while rig.stiffness_x is free"
    assert said == [f"friction {reason}", "the 95 % bound of friction exceeds friction itself"]


def test_moduli_of_two_bodies_are_not_determined_apart(tmp_path: Path) -> None:
    found = fit(
        tmp_path, GROSS, ("bodies.0.young_modulus", "bodies.1.young_modulus"), overrides=("friction=0.1",), noise=0.01
    )
    said = list(doubts(found))
    assert said[0].startswith("bodies.0.young_modulus and bodies.1.young_modulus are not determined apart; 2 times")
    assert said[0].endswith("gives the same loop within the residual")
    assert "0.5 times" in said[0]
    assert exceeded(found)
    assert found.correlation[0, 1] == pytest.approx(-1.0, abs=1e-3)


def test_words_on_directions() -> None:
    names = ["friction", "rig.stiffness_x", "interface.shear_compliance"]
    apart = (
        "rig.stiffness_x and interface.shear_compliance are not determined apart; 2 times rig.stiffness_x with"
        " 1.5 times interface.shear_compliance gives the same loop within the residual"
    )
    # below gross slip as well, where friction has no part in it
    for slides in (False, True):
        assert undetermined_words(names, np.log([1.01, 2.0, 1.5]), slides) == apart
    hidden = "the loop stays below gross slip while rig.stiffness_x and interface.shear_compliance are free"
    assert undetermined_words(names, np.log([2.0, 1.01, 1.01]), False) == f"friction is not determined: {hidden}"
    assert undetermined_words(names, np.log([2.0, 1.01, 1.01]), True) == "friction is not determined"


def test_parameters_that_are_hardly_told_apart() -> None:
    found = np.array([[1.0, 0.987, 0.2], [0.987, 1.0, -0.3], [0.2, -0.3, 1.0]])
    said = "rig.stiffness_x are hardly told apart (correlation 0.987): fix one of them if it is known"
    names = ["interface.shear_compliance", "rig.stiffness_x", "friction"]
    assert list(hardly_apart(names, found)) == [f"interface.shear_compliance and {said}"]


def test_backlash_ends_in_a_misfit(tmp_path: Path) -> None:
    motion, force = GROSS
    loose = motion - 1.5e-3 * (force < 0.0) + 0.75e-3, force
    found = fit(tmp_path, loose, noise=0.005)
    said = next(doubts(found))
    assert said.startswith("the model does not explain the loop: residual ")
    assert "of the range, noise is 0." in said
    low, high = found.bounds
    assert np.all((low < TRUE) & (high > TRUE))


def test_force_that_is_larger_one_way_ends_in_a_misfit(tmp_path: Path) -> None:
    time, force, motion = record(GROSS, noise=0.005, drifts=False)
    force = np.where(np.gradient(motion) > 0.0, force + 15.0 * np.sin(3e3 * motion), force)
    loop = write_record(tmp_path / "loop.csv", (time, force, motion))
    found = fit_loop(make_fit_plan(FitRequest(write_case(tmp_path, FIT_CASE), (), loop, BOTH)))
    assert any(said.startswith("the model does not explain the loop") for said in doubts(found))


LINE = np.linspace(-1.0, 1.0, 2001)[:, None]
NOTHING = np.zeros((2001, 0))


def test_records_that_no_contact_gives_are_refused(tmp_path: Path) -> None:
    """The case has P = 400 N."""
    motion, force = GROSS
    with pytest.raises(
        CaseError, match=r"force and motion run against each other, so that a cycle gains .* mJ; is the"
    ):
        fit(tmp_path, (motion, -force))
    with pytest.raises(CaseError, match=r"the force reaches 4.*e.04 N, 10. times P; is its unit right"):
        fit(tmp_path, (motion, 1e3 * force))


def test_few_points_and_long_ways_are_told(tmp_path: Path) -> None:
    found = fit(tmp_path, GROSS, points=30, cycles=1.4)
    said = list(doubts(replace(found, plan=replace(found.plan, side=1e-3))))
    assert any("hides its noise and the errors of the model; record 100 points or more" in one for one in said)
    assert any(one.endswith("um to and fro is more than the contact; is its unit right?") for one in said)


def test_covariance_of_a_straight_line() -> None:
    """A slope with residuals of one size: sigma^2 / sum(x^2), up to the leverage of the points."""
    residual = 0.1 * np.where(np.arange(2001) % 2, 1.0, -1.0)
    found, neighbours = covariance(LINE, NOTHING, residual, NOTHING)
    assert found[0, 0] == pytest.approx(0.01 / np.sum(LINE**2), rel=5e-3)
    assert neighbours == 0.0
    # an error of half the slope that all points share, which the residuals cannot tell from the slope
    shared, _ = covariance(LINE, 0.5 * LINE, residual, NOTHING)
    # beside what is known before, 7 either way
    assert shared[0, 0] == pytest.approx(1.0 / (1.0 / 0.25 + 1.0 / 49.0), rel=5e-3)


def test_covariance_of_slow_noise() -> None:
    """Noise whose neighbours have the correlation r counts as (1 + r)/(1 - r) times white noise of its size."""
    white = np.random.default_rng(5).standard_normal(2001)
    slow = lfilter([1.0], [1.0, -0.8], white)
    found, neighbours = covariance(LINE, NOTHING, slow, NOTHING)
    assert neighbours == pytest.approx(0.8, abs=0.03)
    assert found[0, 0] == pytest.approx(25.0 / np.sum(LINE**2), rel=0.25)


def test_parameter_without_effect_leaves_the_bounds_of_others() -> None:
    residual = 0.1 * np.where(np.arange(2001) % 2, 1.0, -1.0)
    alone, _ = covariance(LINE, NOTHING, residual, NOTHING)
    both, _ = covariance(np.hstack([1e-14 * LINE**2, LINE]), NOTHING, residual, NOTHING)
    assert both[1, 1] == pytest.approx(alone[0, 0], rel=1e-2)
    # as little is known of it as before
    assert both[0, 0] == pytest.approx(7.0**2, rel=1e-2)


def test_command_and_its_files(tmp_path: Path) -> None:
    loop = write_record(tmp_path / "loop.csv", record(GROSS, noise=0.01))
    case = write_case(tmp_path, FIT_CASE)
    done = invoke("fit", case, "--loop", loop, "--for", "friction,rig.stiffness_x")
    assert (done.exit_code, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert lines[:2] == [
        "fitting friction from 0.14, rig.stiffness_x from 70 kN/mm",
        f"{loop}: the last whole cycle has 201 points",
    ]
    assert any(line.startswith("residual: ") and "noise along the branches" in line for line in lines)
    files = ", ".join(str(tmp_path / f"loop.fit{ending}") for ending in (".csv", ".yaml", ".png"))
    assert lines[-1] == f"written: {files}"
    with (tmp_path / "loop.fit.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(row["parameter"], row["unit"], row["start"]) for row in rows] == [
        ("friction", "", "0.14"),
        ("rig.stiffness_x", "kN/mm", "70.0"),
    ]
    for row, true in zip(rows, (0.1, 50.0), strict=True):
        assert float(row["lower_95"]) < float(row["value"]) < float(row["upper_95"])
        assert float(row["value"]) == pytest.approx(true, rel=0.02)
    assert float(rows[0]["correlation friction"]) == pytest.approx(1.0)
    assert (tmp_path / "loop.fit.png").read_bytes()[1:4] == b"PNG"
    # the case that was found keeps its comments
    text = (tmp_path / "loop.fit.yaml").read_text()
    assert text.startswith("# Found by fretsolve fit: friction = 0.")
    assert "kN/mm}   # from its data sheet" in text
    assert load_case(tmp_path / "loop.fit.yaml").friction.coefficient == pytest.approx(
        float(rows[0]["value"]), rel=1e-5
    )
    # again, over the own files
    assert invoke("fit", case, "--loop", loop, "--for", "friction", "-q").exit_code == 0


def test_found_case_with_a_value_that_the_file_lacks(tmp_path: Path) -> None:
    loop = write_record(tmp_path / "loop.csv", record(GROSS, noise=1e-4))
    text = (
        FIT_CASE.replace("rig: {stiffness_x: 70 kN/mm}   # from its data sheet\n", "")
        .replace("actuator_x", "Qx")
        .replace("4 um", "4 N")
    )
    words = ("--loop", loop, "--for", "rig.stiffness_x", "--set", "friction=0.1", "--set", "rig.stiffness_x=70 kN/mm")
    done = invoke("fit", write_case(tmp_path, text), *words, "-q", "-o", tmp_path / "found")
    assert (done.exit_code, done.output) == (0, "")
    case = load_case(tmp_path / "found.yaml")
    assert case.rig is not None
    assert case.rig.stiffness_x == pytest.approx(50e3, rel=2e-3)
    assert case.friction.coefficient == 0.1


def test_exit_codes(tmp_path: Path) -> None:
    loop = write_record(tmp_path / "loop.csv", record(SMALL, noise=0.01))
    case = write_case(tmp_path, FIT_CASE)
    words = ("fit", case, "--loop", loop, "--for")
    undetermined = invoke(*words, "friction,rig.stiffness_x", "-q")
    assert undetermined.exit_code == 1
    assert f"{loop}: warning: the 95 % bound of friction exceeds friction itself" in undetermined.stderr
    assert refused(2, *words, "mu").startswith("--for mu: is no key of the case; ")
    assert "is not a list of names" in refused(2, *words, "friction,,")
    assert "is not two headings" in refused(2, *words, "friction", "--columns", "Qx")
    assert "would replace the measured loop" in refused(2, *words, "friction", "-o", tmp_path / "loop")
    assert refused(3, *words, "friction", "--set", "friction=1e-4", "-q") == "nothing holds it\n"
    loop.unlink()
    assert refused(4, *words, "friction") == f"{loop}: cannot be read: No such file or directory\n"


def test_other_files_stay(tmp_path: Path) -> None:
    loop = write_record(tmp_path / "loop.csv", record(GROSS))
    (tmp_path / "loop.fit.yaml").write_text("my own")
    said = refused(4, "fit", write_case(tmp_path, FIT_CASE), "--loop", loop, "--for", "friction")
    assert said.startswith(f"{tmp_path / 'loop.fit.yaml'}: is not the case file of a fit of fretsolve, so it is not")
