"""Profiles along lines through the contact, and the picture of wear."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from command_line import invoke
from line_cases import LINE
from pictures import figure_texts, heading, panels
from small_cases import WORN, write_case

from fretsolve.errors import PictureError
from fretsolve.post import plots
from fretsolve.post.plots.load_history import chosen_stage_ends
from fretsolve.post.plots.pictures.histories import stick_history
from fretsolve.post.plots.pictures.profiles import VISIBLE, profile_steps, wear
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


def test_scar_volume_and_depth(worn: Path) -> None:
    with open_result(worn) as result:
        history, last = result.history, result.increments - 1
        figure = wear(result)
        scar, plan, volume, depth = panels(figure)
        steps = profile_steps(result)
        assert steps[-1] == max(steps)
        assert len(scar.lines) == len(steps)
        middle = np.mean(np.asarray(result.field("wear_depth", steps[-1]))[:, 11:13], axis=1)
        np.testing.assert_allclose(scar.lines[-1].get_ydata(), 1e3 * middle)
        assert scar.get_ylim()[0] > scar.get_ylim()[1]  # depth points down
        assert scar.get_ylabel().startswith("worn depth (")
        named = figure_texts(figure)[-3:]
        assert named == ["after 10000 cycles", "edge of the contact", "edge of the stick zone"]
        assert plan.images[-1].get_array().max() == pytest.approx(1e3 * result.field("wear_depth", last).max())
        grown = np.flatnonzero(np.diff(history["cycles"]) > 0.0) + 1
        np.testing.assert_allclose(volume.lines[-1].get_xdata()[1:], history["cycles"][grown])
        np.testing.assert_allclose(volume.lines[-1].get_ydata()[1:], history["wear_volume"][grown])
        np.testing.assert_allclose(depth.lines[-1].get_ydata()[-1], 1e3 * history["wear_depth_max"][-1])
        assert f"after 10000 cycles: worn volume {history['wear_volume'][-1]:.4g}" in heading(figure)


def test_stick_zones_are_those_of_solved_cycles(worn: Path) -> None:
    """The changes of the surfaces between them are no states of the loading."""
    with open_result(worn) as result:
        history = result.history
        ratio = history["stick_radius"] / history["contact_radius"]
        solved = set(np.round(ratio[history["jump"] == 0.0], 9))
        (axes,) = panels(stick_history(result))
        drawn = {value for line in axes.lines[:2] for value in np.round(np.asarray(line.get_ydata()), 9)}
    assert len(solved) < len(ratio)
    assert drawn <= solved


@pytest.mark.parametrize(("jumps", "visible"), [("1e4, jump: 5000", False), ("4e5, jump: 1e5", True)])
def test_an_error_that_can_be_seen_has_a_band(tmp_path: Path, jumps: str, visible: bool) -> None:
    path = write_case(tmp_path, WORN.replace("1e4, jump: 5000", jumps))
    assert invoke("run", path, "-q").exit_code == 0
    with open_result(path.with_suffix(".h5")) as result:
        share = result.history["wear_error"][-1] / result.history["wear_volume"][-1]
        assert (share > VISIBLE) == visible
        assert ("estimated error" in panels(wear(result))[2].get_legend_handles_labels()[1]) == visible


def test_a_line_contact_has_no_map(tmp_path: Path) -> None:
    head = LINE.partition("load_path:")[0]
    path = write_case(
        tmp_path,
        f"{head}wear: {{law: energy, alpha: 1e-4 mm^3/J}}\n"
        "load_path: [{P: 100 N/mm}, {Qx: 8 N/mm, increments: 1},"
        " {cycle: {represents: 100, jump: 50, stages: [{Qx: -8 N/mm, increments: 1}, {Qx: 8 N/mm, increments: 1}]}}]\n",
    )
    assert invoke("run", path, "-q").exit_code == 0
    with open_result(path.with_suffix(".h5")) as result:
        assert len(panels(wear(result))) == 3
        assert panels(wear(result))[1].get_ylabel() == "worn volume (mm³/mm)"


def test_results_without_wear(results: dict[str, Result]) -> None:
    with pytest.raises(PictureError, match="nothing is worn, since the case has no wear"):
        wear(results["fretting"])
