"""The verdict on a run by its error bars."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fretsolve.result.state import ERROR_SUFFIX
from fretsolve.result.verdict import SCALED, Verdict, verdict_of, why_no_bars

MEASURED = tuple(name for name in SCALED if not name.startswith(("actuator", "spring", "wear")))


def verdict(
    accuracy: dict[str, object], columns: dict[str, np.ndarray], points: tuple[int, ...] = ()
) -> Verdict | None:
    """Judge columns of a history. accuracy: of the case, a target alone or with the quantities `of`."""
    target = accuracy.get("accuracy")
    asked = {} if target is None else {"accuracy": {"target": target, "of": accuracy.get("of", ())}}
    return verdict_of({"solver": asked, "grid": {"points": list(points)}}, columns, lambda: None)


def history(**changes: object) -> dict[str, np.ndarray]:
    """Of two stages with two increments each; all values 2, all bars 0.01, but those of `changes`."""
    columns = {name: np.full(4, 2.0) for name in MEASURED}
    columns |= {name + ERROR_SUFFIX: np.full(4, 0.01) for name in MEASURED}
    columns["stage"] = np.array([1, 1, 2, 2])
    return columns | {name: np.asarray(values, float) for name, values in changes.items()}


def test_verdict_is_of_the_worst_bar_at_the_ends_of_stages() -> None:
    bars = history(delta_x_error=[9.0, 0.02, 9.0, 0.05])
    found = verdict({"accuracy": 0.01}, bars)
    assert (found.quantity, found.stage, found.worst, found.met) == ("delta_x", 2, 0.025, False)
    assert str(found).endswith("delta_x at the end of stage 2 is known to 2.5 % of the largest tangential displacement")
    assert verdict({"accuracy": 0.05}, bars).met


def test_an_unbounded_bar_is_named_and_proves_nothing() -> None:
    bars = history(max_pressure_error=[0.1, 0.1, math.inf, math.inf])
    asked = {"of": ("delta_z", "max_pressure")}
    unproved, missed = (verdict({"accuracy": accuracy, **asked}, bars) for accuracy in (0.05, 0.001))
    assert not unproved.met
    assert str(unproved) == "accuracy 5 % is not proved: max_pressure is unbounded"
    assert not missed.met
    assert str(missed).startswith("accuracy 0.1 % is not met: delta_z at the end of stage 1 is known to 0.5 % of")


def test_a_named_quantity_counts_over_itself_however_small_it_is() -> None:
    """Unnamed it counts over a least scale, which is told."""
    small = history(work_total=np.full(4, 1e-4), work_total_error=np.full(4, 1e-5))
    usual, named = (verdict({"accuracy": 0.01, "of": of}, small) for of in ((), ("work_total",)))
    assert usual.met
    assert str(usual).endswith("; work_total is next to nothing, and counts over a thousandth of what presses")
    assert (named.met, named.worst) == (False, pytest.approx(0.1))


@pytest.mark.parametrize("name", ["delta_x", "Qy", "phi_z", "My", "Mz"])
def test_a_value_that_is_nothing_but_rounding_does_not_count(name: str) -> None:
    """By symmetry it is 0, and so is its error; ten parts in a million are a value."""
    assert verdict({"accuracy": 0.01}, history(**{name: np.full(4, 4e-13), name + ERROR_SUFFIX: np.full(4, 1.0)})).met
    small = history(**{name: np.full(4, 2e-5), name + ERROR_SUFFIX: np.full(4, 1.0)})
    assert verdict({"accuracy": 0.01}, small).quantity == name


def test_an_accuracy_of_nothing_that_counts_is_not_proved() -> None:
    found = verdict({"accuracy": 0.01, "of": ("Mz",)}, history(Mz=np.zeros(4)))
    assert not found.met
    assert str(found) == "accuracy 1 % is not proved: all that it is about is 0"


@pytest.mark.parametrize(("bar", "named"), [(1e-6, True), (1e-12, False)])
def test_an_energy_that_no_cell_shows_does_not_count_and_is_named(bar: float, named: bool) -> None:
    """Where the value is 0 and its bar is not, but for rounding."""
    bars = history(work_total=np.zeros(4), work_total_error=np.full(4, bar))
    found = verdict({"accuracy": 0.05}, bars)
    assert found.met
    assert found.unseen == named
    assert str(found).endswith("; no cell slips, so that work_total is not known and does not count") == named
    assert not verdict({"accuracy": 0.05}, history(work_total=[0.0, 0.0, 0.0, 2.0])).unseen


def test_advice_is_on_what_the_bar_comes_from() -> None:
    bars = history(delta_x_error=[9.0, 0.02, 9.0, 0.05])
    points = verdict({"accuracy": 0.01}, bars, (30, 60))
    assert points.advice == "grid.points=[60,120]"  # 2.5^(1/1.4) times as many, in multiples of 6
    assert str(points).endswith("; --set 'grid.points=[60,120]' may do")
    corrected = {f"delta_x_corrected{end}": bars[f"delta_x{end}"] for end in ("", "_error")}
    bars["delta_x_error"] = 1.8 * bars["delta_x_error"]  # of values as run; a bar by the increments alone is twice
    increments = verdict({"accuracy": 0.01}, bars | corrected, (30, 60))
    assert increments.advice == "stage.2.increments=5"
    assert verdict({"accuracy": 0.05}, bars, (30, 60)).advice == ""


def test_what_no_refinement_within_reach_would_do_is_not_advised() -> None:
    bars = history(delta_x_error=[9.0, 0.02, 9.0, 0.3])
    points = verdict({"accuracy": 0.01}, bars, (30, 60))
    assert points.advice == ""
    assert str(points).endswith(
        "is known to 15 % of the largest tangential displacement; more than 4 times the points would be needed"
    )
    corrected = {f"delta_x_corrected{end}": bars[f"delta_x{end}"] for end in ("", "_error")}
    bars["delta_x_error"] = 1.8 * bars["delta_x_error"]
    increments = verdict({"accuracy": 0.01}, bars | corrected, (30, 60))
    assert str(increments).endswith("; more than 4 times the increments of stage 2 would be needed")


def test_displacements_that_are_not_known_are_not_judged() -> None:
    """As `delta_x` of a line contact whose constant is free, while `delta_z` is known."""
    unknown = np.full(4, np.nan)
    found = verdict({"accuracy": 0.01}, history(delta_x=unknown, delta_x_error=unknown))
    assert found is not None and found.met
    assert found.quantity != "delta_x"


def test_verdict_without_bars() -> None:
    unknown = verdict({"accuracy": 0.01}, history(work_total_error=[0.0, 0.0, math.nan, math.nan]))
    assert not unknown.met
    assert str(unknown) == "accuracy 1 % is not proved: there is no error bar of work_total at the end of stage 2"
    columns = {name: values for name, values in history().items() if not name.endswith(ERROR_SUFFIX)}
    assert verdict({"accuracy": 0.01}, columns) is None
    assert verdict({}, history()) is None


def test_it_is_told_from_where_on_there_are_no_bars() -> None:
    told = why_no_bars(history(P_error=[0.0, 0.0, math.nan, math.nan]))
    assert told.startswith(
        "no error bars from increment 2 (stage 2) on: a coarse run has no solution there; lower loads near "
    )
    assert "\n" not in told
    assert why_no_bars(history()) == ""
    assert why_no_bars({name: values for name, values in history().items() if not name.endswith(ERROR_SUFFIX)}) == ""


def test_by_default_zones_and_the_largest_pressure_are_not_judged() -> None:
    wide = {f"{name}_error": np.full(4, 1.0) for name in ("stick_radius", "max_pressure", "stick_half_width_x")}
    assert verdict({"accuracy": 0.01}, history(**wide)).met
    for name in ("stick_radius", "max_pressure", "stick_half_width_x"):
        found = verdict({"accuracy": 0.01, "of": ("Qx", name)}, history(**wide))
        assert (found.quantity, found.worst, found.met) == (name, 0.5, False)


def test_quantities_of_cycles_are_judged_in_their_cycles() -> None:
    columns = {"cycle": np.array([1, 2, 3]), "energy_ratio": np.array([0.4, 0.5, 0.5])}
    columns["energy_ratio_error"] = np.array([0.002, 0.01, 0.004])
    case = {"solver": {"accuracy": {"target": 0.01, "of": ["energy_ratio"]}}}
    found = verdict_of(case, history(), lambda: columns)
    assert (found.quantity, found.cycle, found.met) == ("energy_ratio", 2, False)
    assert found.worst == pytest.approx(0.02)
