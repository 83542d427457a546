"""Figures: axes of the user, and settings that stay as they are."""

from __future__ import annotations

import io

import matplotlib
import pytest
from command_line import python
from matplotlib.figure import Figure
from pictures import legend_texts, panels
from PIL import Image

from fretsolve import plots
from fretsolve.plots import Sheet
from fretsolve.plots.canvas import rendered
from fretsolve.result import Result


def test_on_axes_of_the_user_and_without_touching_settings(results: dict[str, Result]) -> None:
    before = dict(matplotlib.rcParams)
    figure = Figure()
    axes = figure.subplots(1, 2)
    assert plots.loop(results["fretting"], axes[0]) is figure
    assert plots.contact_map(results["fretting"], axes[1], fields=["shear"]) is figure
    assert axes[0].get_ylabel().startswith("tangential force")
    assert legend_texts(axes[1]) == ["edge of the contact", "edge of the stick zone"]
    assert figure.get_suptitle() == ""
    shown = plots.loop(results["torsion"])._repr_png_()
    assert shown.startswith(b"\x89PNG")
    assert dict(matplotlib.rcParams) == before
    code = "import sys; from fretsolve import open_result, plots; plots.loop(open_result(sys.argv[1]))"
    assert "matplotlib.pyplot" not in python(f"{code}; print(*sys.modules)", results["torsion"].path)


def test_widths_of_a_journal_and_those_asked_for(results: dict[str, Result]) -> None:
    one, two = plots.stick_history(results["torsion"]), plots.profiles(results["mindlin"])
    assert one.get_figwidth() == pytest.approx(90.0 / 25.4)
    assert two.get_figwidth() == pytest.approx(190.0 / 25.4)
    narrow = plots.profiles(results["mindlin"], Sheet(width=90.0, title=False))
    assert narrow.get_figwidth() == pytest.approx(90.0 / 25.4)
    assert (narrow.get_suptitle(), two.get_suptitle()) == ("", "mindlin.h5")
    places = [{round(axes.get_position().x0, 2) for axes in panels(figure)} for figure in (narrow, two)]
    assert [len(columns) for columns in places] == [1, 2]  # panels below each other where the sheet is narrow
    for dpi in (100, 300):
        with Image.open(io.BytesIO(rendered(narrow, "png", dpi))) as picture:
            assert picture.width == pytest.approx(dpi * 90.0 / 25.4, abs=1.0)
