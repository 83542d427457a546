"""Figures: axes of the user, settings that stay as they are; results that failed or are still growing."""

from __future__ import annotations

import io
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from command_line import invoke, python
from fake_states import fake_header, fake_states
from matplotlib.figure import Figure
from pictures import heading, image_of, legend_texts, panels
from PIL import Image

from fretsolve.post import plots
from fretsolve.post.plots import Sheet
from fretsolve.post.plots.canvas import rendered
from fretsolve.result import HistoryWriter, Result, open_result


@pytest.mark.slow
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
    code = "import sys; from fretsolve import open_result as read; from fretsolve.post import plots"
    assert "matplotlib.pyplot" not in python(
        f"{code}; plots.loop(read(sys.argv[1])); print(*sys.modules)", results["torsion"].path
    )


@pytest.mark.slow
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


def test_failed_and_growing_results(results: dict[str, Result], tmp_path: Path) -> None:
    figure = plots.loop(results["sliding"])
    assert heading(figure).startswith("failed with 4 increments: sliding.h5")
    np.testing.assert_allclose(panels(figure)[0].lines[0].get_ydata(), [0.0, 10.0, 20.0, 30.0], atol=1e-9)
    with HistoryWriter.open(tmp_path / "out.h5", fake_header()) as writer:
        with open_result(tmp_path / "out.h5") as empty, pytest.raises(plots.PictureError, match="no increment yet"):
            plots.loop(empty)
        done = invoke("plot", tmp_path / "out.h5", "--all", "-o", tmp_path / "pictures")
        assert (done.exit_code, done.stderr) == (2, f"{tmp_path}/out.h5: the result has no increment yet\n")
        assert not (tmp_path / "pictures").exists()
        for state in fake_states(4):
            writer.append(state)
        with open_result(tmp_path / "out.h5") as growing:
            figure = plots.contact_map(growing)
            assert heading(figure).startswith("running with 4 increments: made up")
            np.testing.assert_allclose(
                image_of(panels(figure)[0]).compressed(), growing.field("pressure").T[growing.field("zone").T > 0]
            )
            assert len(panels(plots.loop(growing))) >= 1
