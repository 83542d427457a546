"""Profiles along lines through the contact."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from command_line import invoke
from line_cases import LINE
from pictures import figure_texts, panels
from small_cases import write_case

from fretsolve import plots
from fretsolve.plots.load_history import chosen_stage_ends
from fretsolve.result import Result, open_result
from fretsolve.result.state import Zone


def test_profiles_are_the_cells_through_the_centre_with_closed_forms(results: dict[str, Result]) -> None:
    result = results["mindlin"]
    figure = plots.profiles(result, steps=[5, 32])
    axes = panels(figure)
    assert [one.get_ylabel() for one in axes[::2]] == ["pressure (MPa)", "shear traction x (MPa)", "slip x (µm)"]
    assert [one.get_title() for one in axes[:2]] == ["along x at y = 0 mm", "along y at x = 0 mm"]
    middle = len(result.y) // 2
    for one, name, factor in zip(axes[::2], ("pressure", "shear_x", "slip_x"), (1.0, 1.0, 1e3), strict=True):
        expected = factor * result.field(name, 32)[:, middle - 1 : middle + 1].mean(axis=1)
        touching = (result.field("zone", 32)[:, middle - 1 : middle + 1] != Zone.OPEN).any(axis=1)
        expected[~touching] = np.nan  # nothing is drawn beyond the contact
        line = next(line for line in one.lines if "increment 32" in str(line.get_label()))
        inside = np.isin(result.x, line.get_xdata())
        assert inside.sum() == len(line.get_xdata()) > 30
        np.testing.assert_allclose(line.get_ydata(), expected[inside], rtol=1e-9, atol=1e-12)
    assert set(figure_texts(figure)) == {
        "increment 5: $P$ = 400 N, $Q_x$ = 30 N",
        "increment 32: $P$ = 400 N, $Q_x$ = 10 N",
        "Hertz (closed form)",
        "Cattaneo-Mindlin (closed form)",
    }


def test_profiles_elsewhere_and_of_both_components(results: dict[str, Result]) -> None:
    figure = plots.profiles(results["fretting"], at=(0.1, 0.05))
    titles = [axes.get_title() for axes in panels(figure)[:2]]
    assert titles == ["along x at y = 0.05 mm", "along y at x = 0.1 mm"]
    assert panels(figure)[2].get_ylabel() == "shear traction x and y (MPa)"
    assert "y component: thin, filled markers" in figure_texts(figure)
    ends = chosen_stage_ends(results["fretting"])
    assert ends == [2, 4, 7, 10, 13, 16]
    labels = [text for text in figure_texts(figure) if text.startswith("increment")]
    assert [int(re.findall(r"\d+", text)[0]) for text in labels] == ends


def test_panels_of_a_row_show_all_of_the_pressure(results: dict[str, Result]) -> None:
    across = panels(plots.profiles(results["fretting"], at=(0.0, 0.2)))[1]  # higher than along x at y = 0.2 mm
    largest = max(np.nanmax(line.get_ydata()) for line in across.lines)
    assert across.get_ylim()[0] == 0.0
    assert across.get_ylim()[1] > largest


def test_profiles_of_a_line_have_the_slip_by_its_closed_form(tmp_path: Path) -> None:
    """Also after a reversal, under force and bulk stress in phase."""
    words = LINE.replace("points: 64", "points: 256").replace("increments: 4", "bulk_2: {xx: 142 MPa}")
    words += "  - {Qx: -18 N/mm, bulk_2: {xx: -142 MPa}}\n"
    assert invoke("run", write_case(tmp_path, words), "-q").exit_code == 0
    with open_result(tmp_path / "case.h5") as result:
        slip = panels(plots.profiles(result))[2]
        exact = [line for line in slip.lines if "closed form" in str(line.get_label())]
        found = [line for line in slip.lines if "closed form" not in str(line.get_label())]
        assert len(exact) == len(found) == 2
        for form, line in zip(exact, found, strict=True):
            there = np.interp(line.get_xdata(), form.get_xdata(), form.get_ydata())
            inside = ~np.isnan(line.get_ydata() + there)
            assert np.nanmax(np.abs(there)) == pytest.approx(0.125, rel=0.03)  # um, at the trailing edge
            np.testing.assert_allclose(line.get_ydata()[inside], there[inside], atol=0.001)
