"""Figures: axes of the user, and settings that stay as they are."""

from __future__ import annotations

import matplotlib
from command_line import python
from matplotlib.figure import Figure
from pictures import legend_texts

from fretsolve import plots
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
