"""Pictures of very many cycles: some lines, the range of all between, and what is said of both."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from pictures import heading, legend_texts, panels

from fretsolve.post import plots
from fretsolve.post.plots import report_page
from fretsolve.post.plots.labels import set_increment_ticks
from fretsolve.post.plots.many_lines import draw_range, drawn_lines
from fretsolve.post.plots.pictures.maps import film
from fretsolve.result import Result

HEAD, CYCLE = 5, 6
"""Increments of the result `fretting` before its cycles, and of a cycle."""


def repeated(result: Result, times: int) -> Result:
    """Return `fretting` with the last cycle of its history repeated."""
    case = json.loads(json.dumps(result.effective_case))
    case["load_path"][2]["cycle"]["times"] = times
    added = times - 2
    rows = np.concatenate([np.arange(HEAD + 2 * CYCLE), np.tile(np.arange(HEAD + CYCLE, HEAD + 2 * CYCLE), added)])
    later = np.concatenate([np.zeros(HEAD + 2 * CYCLE), np.repeat(np.arange(1, added + 1), CYCLE)])
    history: dict[str, Any] = {name: column[rows] for name, column in result.history.items()}
    work = result.history["work_total"]
    history["step"] = np.arange(len(rows))
    history["stage"] = history["stage"] + 2 * later.astype(int)
    history["work_total"] = history["work_total"] + later * (work[-1] - work[-1 - CYCLE])
    return replace(result, history=history, attributes={**result.attributes, "effective_case": json.dumps(case)})


def range_of(axes: Axes) -> np.ndarray:
    """Return the pieces of the range, (pieces, 2, 2)."""
    (found,) = [one for one in axes.collections if isinstance(one, LineCollection)]
    return np.array(found.get_segments())


def test_few_lines_are_all_drawn() -> None:
    assert drawn_lines(0) == []
    assert drawn_lines(40) == list(range(40))
    many = drawn_lines(1000)
    assert len(many) == 40
    assert many == sorted(set(many))
    assert (many[:8], many[-8:]) == ([0, 1, 2, 3, 4, 5, 6, 7], [992, 993, 994, 995, 996, 997, 998, 999])
    assert np.ptp(np.diff(many[8:-8])) <= 1  # equally far apart
    assert drawn_lines(41)[:9] == list(range(9))


def test_range_has_each_piece_once_and_none_to_what_is_not_known() -> None:
    axes = Figure().subplots()
    angle = np.tile(np.linspace(0.0, 2.0 * np.pi, 9)[:-1], 5000)
    x, y = 3.0 * np.cos(angle), 2.0 + np.sin(angle)
    draw_range(axes, x, y, color="0.8")
    pieces = range_of(axes)
    assert len(pieces) == 8
    assert pieces[..., 0].min() == pytest.approx(-3.0)
    assert pieces[..., 0].max() == pytest.approx(3.0, abs=0.01)
    assert [pieces[..., 1].min(), pieces[..., 1].max()] == pytest.approx([1.0, 3.0], abs=0.01)
    broken = Figure().subplots()
    draw_range(broken, np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.0, 1.0, np.nan, 3.0]))
    np.testing.assert_allclose(range_of(broken), [[[0.0, 0.0], [1.0, 1.0]]], atol=0.003)
    draw_range(empty := Figure().subplots(), np.array([0.0, 1.0]), np.full(2, np.nan))
    assert not empty.collections


@pytest.mark.parametrize("draw", [plots.loop, plots.stick_history])
def test_some_of_many_cycles_are_lines_and_all_between_are_a_range(
    results: dict[str, Result], draw: Callable[[Result], Figure]
) -> None:
    pieces = []
    for times in (100, 400):
        result = repeated(results["fretting"], times)
        axes = panels(draw(result))[0]
        assert legend_texts(axes)[:2] == [f"range of cycles 8 to {times - 8}, 24 of them as lines", "first loading"]
        cycles = [line for line in axes.lines if "cycle" in str(line.get_label())]
        assert len(cycles) == 39
        named = [line.get_label() for line in (cycles[0], cycles[7], cycles[-1])]
        assert named == ["cycle 1", "cycle 8", f"cycle {times}"]
        np.testing.assert_array_equal(cycles[-1].get_ydata(), cycles[-2].get_ydata())
        pieces.append(range_of(axes))
    assert np.array_equal(*pieces)  # however many cycles there are
    for axis, data in enumerate((cycles[8].get_xdata(), cycles[8].get_ydata())):
        reach = pieces[0][..., axis].min(), pieces[0][..., axis].max()
        assert reach == pytest.approx((min(data), max(data)), abs=np.ptp(data) / 500.0)


def test_closed_forms_and_error_bars_of_many_increments_say_where_they_are(results: dict[str, Result]) -> None:
    result = repeated(results["fretting"], 500)
    bars = {f"{name}_error": 0.01 * np.abs(result.history[name]) for name in ("delta_x", "Qx")}
    barred = replace(result, history={**result.history, **bars})
    axes = panels(plots.loop(barred))[0]
    assert "estimated errors, of 262 of 3005 increments" in legend_texts(axes)
    few = repeated(results["fretting"], 20)
    bars = {f"{name}_error": 0.01 * np.abs(few.history[name]) for name in ("delta_x", "Qx")}
    assert "estimated errors" in legend_texts(panels(plots.loop(replace(few, history={**few.history, **bars})))[0])


def test_films_and_pages_of_many_increments_tell_how_many_are_shown(results: dict[str, Result]) -> None:
    result = results["fretting"]
    moving = film(result, fields=["pressure"], most=5)
    moving.show(moving.steps[1])
    assert heading(moving.figure).replace("\n", " ").endswith("; one of 5 frames of 17 increments")
    whole = film(result, fields=["pressure"])
    whole.show(whole.steps[1])
    assert "frames" not in heading(whole.figure)
    page = report_page.html_page(result, {}, {}, {"one": b"", "two": b""})
    assert "Move the slider to step through 2 of the 17 increments with fields, all drawn in one scale." in page
    page = report_page.html_page(result, {}, {}, {str(step): b"" for step in result.steps})
    assert "Move the slider to step through the increments, all drawn in one scale." in page


def test_increments_that_an_eye_cannot_tell_apart_are_counted(results: dict[str, Result]) -> None:
    assert "vertical lines" in plots.convergence(results["fretting"]).axes[-1].get_xlabel()
    many = repeated(results["fretting"], 2000)
    figure = plots.convergence(many)
    inches = figure.axes[-1].bbox.width / figure.dpi
    held = many.increments / (10.0 * 25.4 * inches)
    assert figure.axes[-1].get_xlabel() == f"increment (each 0.1 mm of the axis holds about {held:.0f} of them)"


def test_increments_on_an_axis_are_whole_numbers() -> None:
    figure = Figure()
    axes = figure.subplots()
    axes.plot([9998, 9999, 10000], [0.0, 1.0, 0.0])
    set_increment_ticks(axes)
    figure.draw_without_rendering()
    shown = [label.get_text() for label in axes.get_xticklabels()]
    assert {"9998", "9999", "10000"} <= set(shown)
    assert axes.xaxis.get_offset_text().get_text() == ""


def test_profiles_say_of_how_many_stages_they_are_some(
    results: dict[str, Result], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Unless increments are asked for."""
    result = results["fretting"]
    assert "stages" not in heading(plots.profiles(result))
    monkeypatch.setattr("fretsolve.post.plots.pictures.profiles.stored_stage_ends", lambda _: list(range(5001)))
    assert "the ends of 6 of 5001 stages" in heading(plots.profiles(result))
    assert "stages" not in heading(plots.profiles(result, steps=result.steps[:2]))
