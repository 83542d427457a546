"""Pictures: what is drawn is what the result holds, and what cannot be drawn is one line that says why."""

from __future__ import annotations

import itertools
import re
import shutil
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from command_line import finish, invoke, python, write_case
from fake_states import fake_header, fake_states
from matplotlib.animation import FFMpegWriter
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image, ImageSequence

from fretsolve import plots
from fretsolve.errors import FileError
from fretsolve.plots.directions import angle_of
from fretsolve.plots.labels import readable
from fretsolve.plots.load_history import chosen_stage_ends, cycles, moved_pairs
from fretsolve.plots.reference import hertz_pressure, shear_form
from fretsolve.plots.snapshot import Snapshot
from fretsolve.result import HistoryWriter, Result, open_result
from fretsolve.result.state import Zone

TITLE = "Fretting <mode> $I$ & $\\\\mathbf"
BODIES = {
    "similar": "[{young_modulus: 200 GPa, poisson_ratio: 0.3}, {young_modulus: 200 GPa, poisson_ratio: 0.3}]",
    "dissimilar": "[{young_modulus: 200 GPa, poisson_ratio: 0.06}, {young_modulus: 200 GPa, poisson_ratio: 0.42}]",
}
CASES = {
    "fretting": f"""\
title: "{TITLE}"
bodies: {BODIES["dissimilar"]}
surface: {{sphere: {{radius: 10 mm}}}}
grid: {{points: 32}}
friction: 0.1
load_path:
  - {{P: 400 N, increments: 3}}
  - {{Qx: 36 N, increments: 2}}
  - cycle: {{times: 2, stages: [{{Qx: -36 N, increments: 3}}, {{Qx: 36 N, increments: 3}}]}}
output: {{fields: [pressure, shear, slip, work_density, zone, gap]}}
""",
    "mindlin": f"""\
bodies: {BODIES["similar"]}
surface: {{sphere: {{radius: 10 mm}}}}
grid: {{points: 48}}
friction: 0.1
coupling: none
load_path:
  - {{P: 400 N}}
  - {{Qx: 36 N, increments: 6}}
  - {{Qx: -36 N, increments: 12}}
  - {{Qx: 36 N, increments: 12}}
  - {{Qx: 10 N, increments: 2}}
output: {{every: 6}}
""",
    "torsion": f"""\
title: "{TITLE}"
bodies: {BODIES["similar"]}
surface: {{sphere: {{radius: 10 mm}}}}
grid: {{points: 32}}
friction: 0.1
load_path:
  - {{P: 400 N}}
  - {{Mz: 5 N*mm, Qx: 0 N, Qy: 0 N, increments: 3}}
""",
    "hertz": f"""\
bodies: {BODIES["similar"]}
surface: {{ellipsoid: {{radius_x: 10 mm, radius_y: 20 mm, angle: 30 deg, center: [0.03 mm, 0 mm]}}}}
grid: {{points: 40}}
load_path: [{{P: 100 N}}, {{P: 400 N, phi_y: 2e-3 rad}}]
output: {{fields: [pressure, zone]}}
""",
    "sliding": f"""\
bodies: {BODIES["similar"]}
surface: {{sphere: {{radius: 10 mm}}}}
grid: {{points: 24}}
friction: 0.1
load_path: [{{P: 400 N}}, {{Qx: 60 N, increments: 6}}]
""",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the results of `CASES` are."""
    place = tmp_path_factory.mktemp("plots")
    for name, text in CASES.items():
        done = invoke("run", write_case(place, text, f"{name}.yaml"), "-q")
        assert done.exit_code == (3 if name == "sliding" else 0), done.stderr
    return place


@pytest.fixture
def results(folder: Path) -> Iterator[dict[str, Result]]:
    """The results of `CASES`, open."""
    opened = {name: open_result(folder / f"{name}.h5") for name in CASES}
    yield opened
    for result in opened.values():
        result.close()


def panels(figure: Figure) -> list[Axes]:
    """The axes with something on them, without colour bars."""
    return [axes for axes in figure.axes if axes.axison]


def legend_texts(axes: Axes) -> list[str]:
    legend = axes.get_legend()
    return [text.get_text() for text in legend.get_texts()] if legend is not None else []


def figure_texts(figure: Figure) -> list[str]:
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def heading(figure: Figure) -> str:
    return figure.get_suptitle()


def area(xy: np.ndarray) -> float:
    x, y = xy.T
    return 0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))


def image_of(axes: Axes) -> np.ndarray:
    return axes.images[-1].get_array()


def test_loop_is_the_history_cycle_by_cycle(results: dict[str, Result]) -> None:
    result = results["fretting"]
    history = result.history
    figure = plots.loop(result)
    tangential, normal = panels(figure)
    assert tangential.get_xlabel() == r"rigid displacement along x $\delta_x$ (µm)"
    assert tangential.get_ylabel() == r"tangential force along x $Q_x$ (N)"
    assert normal.get_xlabel() == r"normal approach $\delta_z$ (µm)"
    parts = [slice(0, 5), slice(4, 11), slice(10, 17)]
    assert len(tangential.lines) == len(parts)
    for line, part in zip(tangential.lines, parts, strict=True):
        np.testing.assert_allclose(line.get_xdata(), 1e3 * history["delta_x"][part])
        np.testing.assert_allclose(line.get_ydata(), history["Qx"][part])
    looks = {(line.get_linestyle(), line.get_marker(), line.get_color()) for line in tangential.lines}
    assert len({look[:2] for look in looks}) == 3
    np.testing.assert_allclose(normal.lines[0].get_ydata(), history["P"])
    assert legend_texts(normal) == ["first loading", "Hertz (closed form)"]
    assert f"{1e3 * history['work_total'][-1]:.4g} µJ" in heading(figure)
    assert heading(figure).startswith("Fretting <mode> $I$ & $\\mathbf")


@pytest.mark.parametrize(("increments", "marked", "told"), [(40, 41, ""), (120, 41, ", one in 3 increments marked")])
def test_each_increment_of_a_loop_is_marked_or_it_is_said(
    increments: int, marked: int, told: str, results: dict[str, Result]
) -> None:
    result = results["fretting"]
    case = result.effective_case
    case["load_path"] = [{"P": 400.0}, {"Qx": 36.0}]
    result = _with_path(result, case, loads=np.linspace(0.0, 36.0, increments + 1).tolist())
    line = panels(plots.loop(result))[0].lines[0]
    first, every = line.get_markevery()
    assert len(line.get_xdata()[first::every]) == marked
    assert str(line.get_label()) == f"first loading{told}"


def test_work_of_closed_cycles_is_shaded_and_labelled(results: dict[str, Result]) -> None:
    history = results["fretting"].history
    axes = panels(plots.loop(results["fretting"]))[0]
    work = 1e3 * np.diff(history["work_total"][[4, 10, 16]])
    labels = [f"{value:.4g} µJ dissipated in cycle {k}" for k, value in enumerate(work, start=1)]
    assert legend_texts(axes) == ["first loading", "cycle 1", "cycle 2", *labels]
    for patch, part in zip(axes.patches, (slice(4, 11), slice(10, 17)), strict=True):
        expected = np.column_stack([1e3 * history["delta_x"][part], history["Qx"][part]])
        np.testing.assert_allclose(patch.get_xy()[: len(expected)], expected)


def test_shaded_area_is_the_work_in_the_limit_of_small_increments(results: dict[str, Result]) -> None:
    history = results["mindlin"].history
    (patch,) = panels(plots.loop(results["mindlin"]))[0].patches
    work = 1e3 * (history["work_total"][30] - history["work_total"][6])
    assert area(patch.get_xy()) == pytest.approx(work, rel=0.01)  # N times µm is µJ


def test_many_cycles_have_a_colour_bar(results: dict[str, Result]) -> None:
    result = results["fretting"]
    case = result.effective_case
    case["load_path"] = [{"P": 400.0}, {"cycle": {"times": 9, "stages": [{"Qx": -36.0}, {"Qx": 36.0}]}}]
    (pair, *_) = moved_pairs(_with_path(result, case, loads=[0.0, *[-36.0, 36.0] * 9]))
    assert [cycle.closed for cycle in cycles(result, pair)] == [False] + [True] * 8 + [False]
    axes = panels(plots.loop(result))[0]
    assert len(axes.child_axes) == 1
    assert axes.child_axes[0].get_ylabel() == "cycle (0: first loading)"
    assert [text for text in legend_texts(axes) if text.startswith("cycle")] == []
    assert len(axes.patches) == 1
    assert legend_texts(axes)[-1].endswith("dissipated in cycle 8")


def _with_path(result: Result, case: dict[str, object], loads: list[float]) -> Result:
    """`result` with a history of one increment a stage, of the loads Qx."""
    import json

    count = len(loads)
    result.attributes = {**result.attributes, "effective_case": json.dumps(case)}
    result.history = {name: np.resize(column, count) for name, column in result.history.items()}
    result.history |= {
        "Qx": np.array(loads),
        "delta_x": 1e-5 * np.array(loads),
        "stage": np.arange(1, count + 1),
        "step": np.arange(count),
        "work_total": 1e-3 * np.arange(count),
    }
    return result


def test_errors_are_drawn_where_the_result_has_them(results: dict[str, Result]) -> None:
    result = results["fretting"]
    assert not panels(plots.loop(result))[0].containers
    count = result.increments
    result.history = {**result.history, "delta_x_error": np.full(count, 2e-5), "work_total_error": np.full(count, 3e-5)}
    figure = plots.loop(result)
    (container,) = panels(figure)[0].containers
    (bars,) = container[2]
    lengths = [float(np.ptp(segment[:, 0])) for segment in bars.get_segments()]
    np.testing.assert_allclose(lengths, 2 * 1e3 * 2e-5)
    assert re.search(r" \d+\.\d{3} ± 0\.030 µJ", heading(figure))
    assert "estimated errors" in legend_texts(panels(figure)[0])


def test_torsion_is_a_loop_of_moment_over_rotation(results: dict[str, Result]) -> None:
    result = results["torsion"]
    (axes,) = panels(plots.loop(result))
    assert axes.get_xlabel() == r"rotation about the z axis $\varphi_z$ (mrad)"
    assert axes.get_ylabel() == r"torsional moment $M_z$ (N·mm)"
    np.testing.assert_allclose(axes.lines[0].get_xdata(), 1e3 * result.history["phi_z"])
    np.testing.assert_allclose(axes.lines[0].get_ydata(), result.history["Mz"])


def test_profiles_are_the_cells_through_the_centre_with_closed_forms(results: dict[str, Result]) -> None:
    result = results["mindlin"]
    figure = plots.profiles(result, steps=[5, 32])
    axes = panels(figure)
    assert [one.get_ylabel() for one in axes[::2]] == ["pressure (MPa)", "shear traction x (MPa)", "slip x (µm)"]
    assert [one.get_title() for one in axes[:2]] == ["along x at y = 0 mm", "along y at x = 0 mm"]
    middle = len(result.y) // 2
    for one, name, factor in zip(axes[::2], ("pressure", "shear_x", "slip_x"), (1.0, 1.0, 1e3), strict=True):
        expected = factor * result.field(name, 32)[:, middle - 1 : middle + 1].mean(axis=1)
        line = next(line for line in one.lines if "increment 32" in str(line.get_label()))
        inside = np.isin(result.x, line.get_xdata())
        assert inside.sum() == len(line.get_xdata()) > 30
        np.testing.assert_allclose(line.get_ydata(), expected[inside], rtol=1e-9, atol=1e-12)
    assert set(figure_texts(figure)) == {
        "increment 5: P = 400 N, Qx = 30 N",
        "increment 32: P = 400 N, Qx = 10 N",
        "Hertz (closed form)",
        "Cattaneo-Mindlin (closed form)",
    }


@pytest.mark.parametrize("step", [5, 11, 17, 23, 29, 32])
def test_closed_form_of_the_shear_remembers_the_turning_points(results: dict[str, Result], step: int) -> None:
    result = results["mindlin"]
    form = shear_form(result, step)
    assert form is not None
    x, y = np.meshgrid(result.x, result.y, indexing="ij")
    exact = form.at(x.ravel(), y.ravel()).reshape(2, *x.shape)
    assert not exact[1].any()
    off = np.abs(exact[0] - result.field("shear_x", step))[np.hypot(x, y) < 0.28]
    assert np.median(off) < 1e-3 * 210.6
    assert np.percentile(off, 90) < 1e-2 * 210.6  # the rest lies in cells at the edges of stick zones


def test_closed_form_of_torsion(results: dict[str, Result]) -> None:
    result = results["torsion"]
    form = shear_form(result, 3)
    assert form is not None and form.name == "Lubkin"
    inside = np.abs(result.x) < 0.15
    exact = form.at(result.x[inside], np.zeros(inside.sum()))
    middle = len(result.y) // 2
    found = result.field("shear_y", 3)[inside, middle - 1 : middle + 1].mean(axis=1)
    np.testing.assert_allclose(exact[1], found, atol=0.02 * 210.6)
    assert shear_form(results["fretting"], 4) is None  # pressure and shear act on each other


def test_hertz_of_a_turned_tilted_ellipsoid(results: dict[str, Result]) -> None:
    result = results["hertz"]
    form = hertz_pressure(result, 1)
    assert form is not None
    x, y = np.meshgrid(result.x, result.y, indexing="ij")
    off = form.at(x.ravel(), y.ravel()).reshape(x.shape) - result.field("pressure")
    inside = result.field("pressure") > 500.0
    assert np.abs(off)[inside].max() < 0.03 * result.history["max_pressure"][1]


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


def test_map_shows_the_fields_zoomed_to_the_contact(results: dict[str, Result]) -> None:
    result = results["fretting"]
    figure = plots.contact_map(result)
    axes = panels(figure)
    assert [one.get_title() for one in axes] == ["pressure", "shear traction", "slip", "zone", "dissipated energy"]
    labels = [one.child_axes[0].get_ylabel() for one in axes]
    assert labels == ["pressure (MPa)", "shear traction (MPa)", "slip (µm)", "", "dissipated energy (mJ/mm²)"]
    shear = np.hypot(result.field("shear_x"), result.field("shear_y"))
    expected = [result.field("pressure"), shear, None, result.field("zone"), result.field("work_density")]
    for one, values in zip(axes, expected, strict=True):
        assert one.get_aspect() == 1.0
        assert (one.get_xlabel(), one.get_ylabel()) == ("x (mm)", "y (mm)")
        if values is not None:
            shown = image_of(one)
            hidden = np.ma.getmaskarray(shown)
            np.testing.assert_allclose(shown.data[~hidden], values.T[~hidden])
            assert not values.T[hidden].any()
    left, right = axes[0].get_xlim()
    radius = result.history["contact_radius"][-1]
    assert -1.4 * radius < left < -radius and radius < right < 1.4 * radius
    assert "increment 16 (stage 6): P = 400 N, Qx = 36 N" in heading(figure)
    assert figure_texts(figure) == ["edge of the contact", "edge of the stick zone"]


def test_map_of_chosen_fields_and_increment(results: dict[str, Result]) -> None:
    result = results["fretting"]
    figure = plots.contact_map(result, step=-13, fields=["gap", "shear"])
    gap, shear = panels(figure)
    np.testing.assert_allclose(image_of(gap), 1e3 * result.field("gap", 4).T)
    assert gap.child_axes[0].get_ylabel() == "gap (µm)"
    (arrows,) = [item for item in shear.collections if type(item).__name__ == "Quiver"]
    assert np.hypot(arrows.U, arrows.V) == pytest.approx(1.0)
    assert (arrows.U > 0.9).mean() > 0.5  # along the load
    assert "increment 4 (stage 2)" in heading(figure)


def test_streamlines(results: dict[str, Result]) -> None:
    shear, slip = panels(plots.streamlines(results["torsion"]))
    assert (shear.get_title(), slip.get_title()) == ("shear traction", "slip")
    lines = slip.collections[0]
    points = np.concatenate(lines.get_segments())
    assert len(points) > 100
    assert np.hypot(*points.T).min() > 0.15  # nothing slips inside of Lubkin's circle of 0.209 mm
    assert slip.child_axes[0].get_ylabel() == "slip (µm)"


def test_slip_angle(results: dict[str, Result]) -> None:
    along, reference = angle_of(Snapshot(results["mindlin"], 11))
    assert reference == "the load"
    assert np.nanmax(np.abs(along)) < 1e-3  # without cross influence, slip is along the load
    around, reference = angle_of(Snapshot(results["torsion"], 3))
    assert reference == "the motion of body 1"
    assert np.nanmean(np.abs(around)) < 0.1
    result = results["fretting"]
    degrees, _ = angle_of(Snapshot(result, 13))  # Qx falls
    slipping = result.field("zone", 13) == Zone.SLIP
    np.testing.assert_array_equal(np.isfinite(degrees), slipping)
    slip_x, slip_y = (result.field(name, 13) - result.field(name, 12) for name in ("slip_x", "slip_y"))
    expected = np.degrees(np.arctan2(-slip_y, -slip_x))
    np.testing.assert_allclose(degrees[slipping], expected[slipping], atol=0.05)
    (axes,) = panels(plots.slip_angle(result, step=13))
    np.testing.assert_allclose(image_of(axes).compressed(), degrees.T[slipping.T])
    assert f"at most {np.nanmax(np.abs(degrees)):.3g}°" in axes.get_title()


def test_stick_history(results: dict[str, Result]) -> None:
    result = results["mindlin"]
    (axes,) = panels(plots.stick_history(result))
    ratio = result.history["stick_radius"] / result.history["contact_radius"]
    np.testing.assert_allclose(axes.lines[0].get_xdata(), result.history["Qx"][:7])
    np.testing.assert_allclose(axes.lines[0].get_ydata(), ratio[:7])
    form = next(line for line in axes.lines if line.get_label() == "Cattaneo-Mindlin (closed form)")
    np.testing.assert_allclose(form.get_ydata(), ratio, atol=0.03)
    assert axes.get_ylabel() == "stick radius over contact radius, c/a (1)"
    (twisted,) = panels(plots.stick_history(results["torsion"]))
    assert legend_texts(twisted)[-1] == "Lubkin (closed form)"
    np.testing.assert_allclose(twisted.lines[-1].get_ydata(), twisted.lines[0].get_ydata(), atol=0.04)


def test_convergence(results: dict[str, Result]) -> None:
    result = results["fretting"]
    counts, residuals = panels(plots.convergence(result))
    assert legend_texts(counts) == ["normal iterations", "tangential iterations", "staggered iterations"]
    for line, name in zip(counts.lines, ("iterations_normal", "iterations_tangential", "alternations"), strict=False):
        np.testing.assert_array_equal(line.get_ydata(), result.history[name])
    assert legend_texts(residuals) == ["gap", "stick", "slip", "friction limit", "load", "tolerance 1e-06"]
    np.testing.assert_allclose(residuals.lines[0].get_ydata(), np.maximum(result.history["residual_gap"], 1e-10))
    tolerance = next(line for line in residuals.lines if line.get_label() == "tolerance 1e-06")
    np.testing.assert_allclose(tolerance.get_ydata(), 1e-6)
    assert residuals.get_yscale() == "log"


def test_no_module_hides_a_public_function() -> None:
    for kind in plots.KINDS.values():
        assert callable(kind.draw)  # imports its module
    assert [name for name in plots.__all__ if not callable(getattr(plots, name))] == ["KINDS"]


def test_units_keep_numbers_short() -> None:
    lengths = [readable("mm", values) for values in ([2e-3, -0.05, np.inf], 0.2, 5e-6, 0.0)]
    assert [(unit.text, unit.factor) for unit in lengths] == [("µm", 1e3), ("mm", 1.0), ("nm", 1e6), ("mm", 1.0)]
    assert (readable("rad", 1e-3).text, readable("N mm", 5.0).text, readable("mJ/mm^2", 1.0).text) == (
        "mrad",
        "N·mm",
        "mJ/mm²",
    )


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


def test_files_by_their_suffix(folder: Path, tmp_path: Path) -> None:
    for suffix, start in (("png", b"\x89PNG"), ("pdf", b"%PDF"), ("SVG", b"<?xml")):
        out = tmp_path / f"loop.{suffix}"
        done = invoke("plot", folder / "torsion.h5", "-o", out)
        assert (done.exit_code, done.output) == (0, f"{out}\n")
        assert out.read_bytes().startswith(start)
        assert 3_000 < out.stat().st_size < 300_000
    with Image.open(tmp_path / "loop.png") as picture:
        assert picture.size >= (600, 500)
    first = (tmp_path / "loop.SVG").read_bytes()
    invoke("plot", folder / "torsion.h5", "loop", "-o", tmp_path / "loop.SVG")
    assert (tmp_path / "loop.SVG").read_bytes() == first  # the same result, the same file


def test_names_by_default(folder: Path, tmp_path: Path) -> None:
    shutil.copy(folder / "torsion.h5", tmp_path / "case.h5")
    done = invoke("plot", tmp_path / "case.h5", "stick-history", "convergence")
    assert done.exit_code == 0
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["case.convergence.png", "case.h5", "case.stick-history.png"]


def test_animation(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "film.gif"
    done = invoke("plot", folder / "torsion.h5", "animate", "-o", out, "--field", "shear")
    assert done.exit_code == 0, done.stderr
    with Image.open(out) as film:
        assert (film.format, film.n_frames) == ("GIF", 4)
        frames = [np.asarray(frame.convert("L"), float) for frame in ImageSequence.Iterator(film)]
    assert all(np.abs(one - other).max() > 50 for one, other in itertools.pairwise(frames))
    monkeypatch.setattr(FFMpegWriter, "isAvailable", classmethod(lambda cls: False))
    done = invoke("plot", folder / "torsion.h5", "animate", "-o", tmp_path / "film.mp4")
    assert (done.exit_code, done.output.count("\n")) == (2, 1)
    assert "mp4 needs ffmpeg, which is not on the path: install it, or write a .gif" in done.stderr


class _Pictures(HTMLParser):
    """What a page shows."""

    def __init__(self) -> None:
        super().__init__()
        self.sources: list[str] = []
        self.tags: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.sources += [value or "" for name, value in attrs if name in ("src", "href")]


def test_all_kinds_and_a_report(folder: Path, tmp_path: Path) -> None:
    done = invoke("plot", folder / "torsion.h5", "--all", "-o", tmp_path / "out")
    assert done.exit_code == 0, done.stderr
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {*(f"{kind}.png" for kind in plots.KINDS if kind != "animate"), "animate.gif", "index.html"}
    text = (tmp_path / "out" / "index.html").read_text(encoding="utf-8")
    page = _Pictures()
    page.feed(text)
    assert len(page.sources) == len(plots.KINDS)
    assert all(source.startswith("data:image/") for source in page.sources)
    assert "mode" not in page.tags
    assert "Fretting &lt;mode&gt; $I$ &amp;" in text
    assert "dissipated energy" in text and "<h2>Left out</h2>" not in text


def test_report_says_what_is_left_out(folder: Path, tmp_path: Path) -> None:
    done = invoke("plot", folder / "hertz.h5", "--all", "-o", tmp_path)
    assert done.exit_code == 0
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "<li>stick-history: nothing sticks or slips without friction and shear traction</li>" in text
    assert "left out: streamlines: the field 'shear' is not stored, only pressure, zone" in done.stdout
    assert not (tmp_path / "streamlines.png").exists()


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


ERRORS = {
    ("fretting", "loop", "-o", "x.jpg"): "x.jpg: not a name for loop; one ending in .png, .pdf, .svg is needed",
    ("fretting", "loop", "-o", "x"): "x: not a name for loop; one ending in .png, .pdf, .svg is needed",
    ("fretting", "animate", "-o", "x.png"): "not a name for animate; one ending in .gif, .mp4 is needed",
    ("fretting", "loop", "map", "-o", "x.png"): "one file cannot hold 2 pictures: name a folder",
    ("fretting", "loop", "--step", "1"): "--step has no effect on loop; leave it out",
    ("fretting", "map", "--step", "99"): "map: there is no increment 99; there are 0 to 16",
    ("fretting", "map", "--step", "1", "--step", "2"): "map: shows one increment, not 2: give --step once",
    ("fretting", "map", "--field", "sheer"): "map: there is no field 'sheer'; stored are pressure, shear, slip,",
    ("fretting", "profiles", "--at", "3,0"): "profiles: x = 3 mm is off the grid, whose cells lie from -0.35 to 0.35",
    ("fretting", "profiles", "--at", "here"): "'here' is not a point; two numbers in mm such as 0.1,-0.05 are needed",
    ("fretting", "slip-angle", "--step", "2"): "slip-angle: no tangential load changes in increment 2, so that",
    ("fretting", "loup"): "'loup' is not one of 'loop', 'profiles',",
    ("fretting", "loop", "--all"): "--all takes all kinds; leave KIND out.",
    ("fretting", "--all", "-o", "x.pdf"): "x.pdf: --all writes many files; the name of a folder is needed",
    ("mindlin", "map", "--step", "6"): "map: the fields of increment 6 are not stored (output.every); the nearest",
    ("hertz", "streamlines"): "streamlines: the field 'shear' is not stored, only pressure, zone; output.fields",
    ("hertz", "slip-angle"): "slip-angle: the field 'shear' is not stored, only pressure, zone; output.fields",
    ("hertz", "stick-history"): "stick-history: nothing sticks or slips without friction and shear traction",
    ("torsion", "slip-angle", "--step", "0"): "slip-angle: nothing slips in increment 0",
    ("torsion", "streamlines", "--step", "0"): "streamlines: shear and slip are 0 everywhere in increment 0",
}


@pytest.mark.parametrize("words", ERRORS, ids=" ".join)
def test_what_cannot_be_drawn_is_one_line(
    words: tuple[str, ...], folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    done = invoke("plot", folder / f"{words[0]}.h5", *words[1:])
    assert done.exit_code == 2
    assert ERRORS[words] in done.stderr
    assert done.output.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_picture_that_cannot_be_written(folder: Path, tmp_path: Path) -> None:
    done = invoke("plot", folder / "torsion.h5", "-o", tmp_path / "missing" / "x.svg")
    assert done.exit_code == FileError.exit_code
    assert done.stderr == f"{tmp_path}/missing/x.svg: cannot be written: No such file or directory\n"
    (tmp_path / "taken").touch()
    done = invoke("plot", folder / "torsion.h5", "--all", "-o", tmp_path / "taken")
    assert (done.exit_code, done.output.count("\n")) == (4, 1)
    assert invoke("plot", tmp_path / "no.h5").exit_code == 4


def test_without_matplotlib(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    done = invoke("plot", folder / "torsion.h5")
    assert (done.exit_code, done.output.count("\n")) == (2, 1)
    assert done.stderr.endswith("pip install '.[plot]' in a clone of fretsolve\n")


def test_letters_that_the_font_lacks_are_no_warning(folder: Path, tmp_path: Path) -> None:
    text = CASES["hertz"].replace("bodies:", "title: 微动 接触\nbodies:").replace("points: 40", "points: 12")
    assert invoke("run", write_case(tmp_path, text), "-q").exit_code == 0
    code, output, messages = finish("plot", tmp_path / "case.h5", "loop")
    assert (code, output, messages) == (0, f"{tmp_path}/case.loop.png\n", "")
    with Image.open(tmp_path / "case.loop.png") as picture:
        picture.verify()


def test_a_folder_for_several_pictures_is_made(folder: Path, tmp_path: Path) -> None:
    result = folder / "fretting.h5"
    made = tmp_path / "with.dots" / "pictures"
    done = invoke("plot", result, "loop", "convergence", "-o", made)
    assert (done.exit_code, len(list(made.iterdir()))) == (0, 2)
    done = invoke("plot", result, "loop", "-o", f"{tmp_path / 'v1.0'}/")
    assert [path.name for path in (tmp_path / "v1.0").iterdir()] == ["fretting.loop.png"]
    (tmp_path / "taken").write_text("a file")
    done = invoke("plot", result, "loop", "-o", f"{tmp_path / 'taken'}/")
    assert done.exit_code == 4
    assert "cannot be made a folder" in done.stderr
