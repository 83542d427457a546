"""Pictures of sweeps: what is drawn where, and what cannot be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.collections import QuadMesh
from numpy.typing import ArrayLike
from pictures import figure_texts

from fretsolve.errors import PictureError
from fretsolve.sweep.manifest import CaseState, Manifest, ManifestRow
from fretsolve.sweep.outcome import CaseOutcome, RunningCondition
from fretsolve.sweep.plot import curve, independent_keys, running_condition_map, surface
from fretsolve.sweep.table import Column, Table, setting_column

LOADS, SHIFTS = (100, 200, 400), (1, 2)
LOAD, SHIFT, BACK = "load_path.0.P", "load_path.1.delta_x", "load_path.2.delta_x"


def table_of(points: Sequence[Mapping[str, str]] = (), work: ArrayLike = (), *more: Column, missing: int = -1) -> Table:
    """A sweep at `points`, by default three loads crossed with two displacements, where work is their product."""
    crossed = [(load, shift) for load in LOADS for shift in SHIFTS]
    points = points or [{LOAD: f"{load} N", SHIFT: f"{shift} um"} for load, shift in crossed]
    values = np.array(work if len(points) == np.size(work) else [1e-6 * load * shift for load, shift in crossed])
    rows = tuple(ManifestRow(index, f"{index:x}", point, 1.0) for index, point in enumerate(points))
    conditions: list[RunningCondition] = ["gross slip" if row.index % 2 else "partial slip" for row in rows]
    if missing >= 0:
        values[missing], conditions[missing] = np.nan, ""
    nothing = np.full(1, np.nan)
    manifest = Manifest(Path(), Path(), "a $title$", Path(), (), ("work_total",), 1, 1.0, rows)
    return Table(
        manifest,
        tuple(CaseState(row, "waiting" if row.index == missing else "complete") for row in rows),
        tuple(CaseOutcome(nothing, nothing, 1, running_condition=one) for one in conditions),
        tuple(setting_column(key, rows) for key in manifest.keys),
        (Column("work_total", "mJ", values), *more),
        (Column("work_total error", "mJ", 0.1 * values),),
    )


def test_curve_has_a_line_with_error_bars_for_each_value_of_the_other_key() -> None:
    axes = curve(table_of(), "work_total", LOAD).axes[0]
    assert len(axes.containers) == 2
    line, _, (bars,) = axes.containers[1]
    np.testing.assert_array_equal(line.get_xdata(), [100.0, 200.0, 400.0])
    np.testing.assert_allclose(line.get_ydata(), [0.2, 0.4, 0.8])  # in µJ
    np.testing.assert_allclose([np.ptp(segment[:, 1]) for segment in bars.get_segments()], [0.04, 0.08, 0.16])
    assert figure_texts(axes.figure) == [r"$\delta_x$ 1 µm", r"$\delta_x$ 2 µm"]
    assert axes.get_xscale() == "log"
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("normal force $P$ (N)", "dissipated energy (µJ)")


def test_some_of_many_lines_are_drawn_and_the_legend_says_so() -> None:
    points = [{LOAD: f"{load} N", SHIFT: f"{shift} um"} for shift in range(1, 101) for load in LOADS]
    axes = curve(table_of(points, np.arange(300.0)), "work_total", LOAD).axes[0]
    assert len(axes.containers) == 40
    first, ninth, last = (axes.containers[place][0].get_ydata().tolist() for place in (0, 8, -1))
    assert (first, ninth, last) == ([0.0, 1.0, 2.0], [24.0, 25.0, 26.0], [297.0, 298.0, 299.0])
    assert figure_texts(axes.figure) == ["40 of 100 lines: the first and\nthe last 8, and some between"]


def test_map_puts_each_case_at_its_place() -> None:
    axes = surface(table_of(missing=5), "work_total", (SHIFT, LOAD)).axes[0]
    (mesh,) = [artist for artist in axes.collections if isinstance(artist, QuadMesh)]
    values = mesh.get_array()
    np.testing.assert_allclose(values.reshape(3, 2)[:, 0], [0.1, 0.2, 0.4])
    hidden = np.ma.getmaskarray(np.ma.masked_invalid(values)).reshape(3, 2)
    assert np.argwhere(hidden).tolist() == [[2, 1]]
    (crosses,) = axes.lines
    assert (crosses.get_xdata().tolist(), crosses.get_ydata().tolist()) == ([2.0], [400.0])


def test_running_condition_marks_each_case() -> None:
    figure = running_condition_map(table_of(missing=0), (SHIFT, LOAD))
    partial, gross = figure.axes[0].lines
    assert sorted(partial.get_ydata().tolist()) == [200.0, 400.0]
    assert gross.get_xdata().tolist() == [2.0] * 3
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["partial slip", "gross slip"]
    assert figure.get_suptitle() == r"a \$title\$"


def test_what_cannot_be_drawn() -> None:
    table = table_of()
    with pytest.raises(PictureError, match=r"'P' is not a column of the sweep; it has load_path\.0\.P"):
        curve(table, "work_total", "P")
    with pytest.raises(PictureError, match="not a column"):
        curve(table, "delta_x", LOAD)
    with pytest.raises(PictureError, match=r"load_path.0.P varies as well"):
        surface(table, "work_total", (SHIFT, SHIFT))
    mixed = setting_column("title", [ManifestRow(0, "0", {"title": "a"}, 1.0)])
    assert mixed.values.tolist() == ["a"]


def test_tied_keys_are_one_axis_and_conditions_have_borders() -> None:
    table = table_of([{SHIFT: f"{d} um", BACK: f"-{d} um"} for d in (1, 2, 3)], [1.0, 2.0, 4.0])
    (bars,) = curve(table, "work_total", SHIFT).axes[0].containers
    np.testing.assert_allclose(bars[0].get_ydata(), [1.0, 2.0, 4.0])
    axes = running_condition_map(table_of(), (SHIFT, LOAD)).axes[0]
    assert axes.get_xlabel() == r"rigid displacement along x $\delta_x$ (µm)"
    borders = [path for artist in axes.collections if not artist.get_fill() for path in artist.get_paths()]
    (border,) = [path.vertices for path in borders if len(path.vertices)]
    np.testing.assert_allclose(border[:, 0], 1.5)  # half-way between 1 and 2 um, at all loads
    assert (border[:, 1].min(), border[:, 1].max()) == (100.0, 400.0)


def tied_table(*more: Column) -> Table:
    """Two tied displacements crossed with three loads."""
    points = [{SHIFT: f"{d} um", BACK: f"-{d} um", LOAD: f"{load} N"} for d in SHIFTS for load in LOADS]
    return table_of(points, np.arange(6.0), Column("energy_ratio", "1", np.linspace(0.02, 0.09, 6)), *more)


def test_maps_are_over_keys_that_vary_apart() -> None:
    table = tied_table()
    assert independent_keys(table) == [SHIFT, LOAD]
    tied = (SHIFT, BACK)
    with pytest.raises(PictureError, match=r"load_path\.0\.P varies as well"):
        running_condition_map(table, tied)
    figure = running_condition_map(table, independent_keys(table))
    assert "energy ratio" not in figure_texts(figure)  # all are below the first contour
    ticks = figure.axes[0].get_yticks()
    assert [figure.axes[0].yaxis.get_major_formatter()(tick) for tick in ticks] == ["100", "200", "400"]


INF = float("inf")


def lives_of(name: str, units: str, values: Sequence[float]) -> Table:
    """A sweep over three loads and two displacements with values of a quantity, and their errors."""
    table, found = table_of(), np.array(values)
    errors = np.where(np.isinf(found), np.nan, 0.1 * found)
    return replace(table, found=(Column(name, units, found),), errors=(Column(f"{name} error", units, errors),))


def test_run_outs_are_arrows_at_the_top_of_a_logarithmic_axis() -> None:
    figure = curve(lives_of("swt_life", "cycles", [INF, 1e7, 1e6, 2e5, INF, INF]), "swt_life", LOAD)
    (axes,) = figure.axes
    assert (axes.get_yscale(), axes.get_ylabel()) == ("log", "life by SWT (cycles)")
    arrows = [line for line in axes.lines if "arrow" in str(line.get_marker())]
    assert [line.get_xdata().tolist() for line in arrows] == [[100.0, 400.0], [400.0]]
    assert axes.get_xlim()[0] < 100.0 < 400.0 < axes.get_xlim()[1]
    assert 1e7 < axes.get_ylim()[1] < 1e9
    # the arrows of two lines at one load stand side by side, above the values
    places = [line.get_transform().transform(line.get_xydata()[-1]) for line in arrows]
    assert places[1][0] - places[0][0] > 5.0
    assert places[0][1] == places[1][1] > axes.transData.transform((400.0, 1e7))[1]
    assert figure_texts(figure) == [r"$\delta_x$ 1 µm", r"$\delta_x$ 2 µm", "run-out"]


def test_a_crack_that_goes_through_and_lives_that_are_all_endless() -> None:
    figure = curve(lives_of("crack_arrest_length", "mm", [0.0, 0.2, 0.1, 0.3, INF, INF]), "crack_arrest_length", LOAD)
    assert figure.axes[0].get_ylabel() == "length at which the crack stops (mm)"
    assert figure_texts(figure)[-1] == "goes through"
    assert figure.axes[0].get_yscale() == "linear"
    endless = curve(lives_of("crack_life", "cycles", [INF] * 6), "crack_life", LOAD)
    assert len(endless.axes[0].get_yticks()) == 0
    assert figure_texts(endless)[-1] == "run-out"


def test_map_of_lives_has_arrows_for_run_outs_and_crosses_for_what_is_missing() -> None:
    table = lives_of("swt_life", "cycles", [INF, 1e7, 1e6, 2e5, np.nan, 5e5])
    figure = surface(table, "swt_life", (SHIFT, LOAD))
    (mesh,) = [artist for artist in figure.axes[0].collections if isinstance(artist, QuadMesh)]
    assert (mesh.norm.vmin, mesh.norm.vmax) == (2e5, 1e7)
    crosses, arrows = figure.axes[0].lines
    assert (crosses.get_xydata().tolist(), arrows.get_xydata().tolist()) == ([[1.0, 400.0]], [[1.0, 100.0]])
    assert figure_texts(figure) == ["run-out"]


def test_parameters_have_their_names_and_units_on_the_axis() -> None:
    labels = {
        ("fatemi_socie_max", "1"): "largest Fatemi-Socie parameter (-)",
        ("ruiz_1_max", "MPa^2 mm"): "largest Ruiz's first parameter (MPa² mm)",
    }
    for (name, units), label in labels.items():
        assert curve(lives_of(name, units, [1.0] * 6), name, LOAD).axes[0].get_ylabel() == label
