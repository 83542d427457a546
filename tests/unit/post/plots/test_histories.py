"""Pictures of the history: loops, stick zones and iterations."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from command_line import invoke
from line_cases import LINE
from pictures import figure_texts, heading, legend_texts, panels
from small_cases import write_case

from fretsolve.errors import PictureError
from fretsolve.post import plots
from fretsolve.post.plots.load_history import load_texts
from fretsolve.result import Result, open_result

SPHERE = """\
bodies: [{young_modulus: 200 GPa, poisson_ratio: 0.3}, {young_modulus: 200 GPa, poisson_ratio: 0.3}]
surface: {sphere: {radius: 10 mm}}
grid: {points: 16}
friction: 0.1
load_path: [{P: 400 N}, {Qx: 30 N, increments: 3}]
"""


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
    assert heading(figure).startswith(r"Fretting <mode> \$I\$ & \$\mathbf")  # letters, not formulas


def test_work_of_closed_cycles_is_shaded_and_labelled(results: dict[str, Result]) -> None:
    history = results["fretting"].history
    axes = panels(plots.loop(results["fretting"]))[0]
    work = 1e3 * np.diff(history["work_total"][[4, 10, 16]])
    labels = [f"{value:.4g} µJ dissipated in cycle {k}" for k, value in enumerate(work, start=1)]
    assert legend_texts(axes) == ["first loading", "cycle 1", "cycle 2", *labels]
    for patch, part in zip(axes.patches, (slice(4, 11), slice(10, 17)), strict=True):
        expected = np.column_stack([1e3 * history["delta_x"][part], history["Qx"][part]])
        np.testing.assert_allclose(patch.get_xy()[: len(expected)], expected)


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


def test_stick_history(results: dict[str, Result]) -> None:
    result = results["mindlin"]
    (axes,) = panels(plots.stick_history(result))
    ratio = result.history["stick_radius"] / result.history["contact_radius"]
    np.testing.assert_allclose(axes.lines[0].get_xdata(), result.history["Qx"][:7])
    np.testing.assert_allclose(axes.lines[0].get_ydata(), ratio[:7])
    form = next(line for line in axes.lines if line.get_label() == "Cattaneo-Mindlin (closed form)")
    parts = -(-200 // result.increments)  # a curve, which meets the increments
    assert len(form.get_xdata()) == (result.increments - 1) * parts + 1 >= 200
    np.testing.assert_allclose(form.get_xdata()[::parts], result.history["Qx"], atol=1e-9)
    np.testing.assert_allclose(form.get_ydata()[::parts], ratio, atol=0.03)
    between = slice(parts, 2 * parts)  # of the first increment with shear
    closed = np.cbrt(1.0 - form.get_xdata()[between] / (0.1 * 400.0))
    np.testing.assert_allclose(form.get_ydata()[between], closed, rtol=1e-6)
    assert axes.get_ylabel() == "stick radius over contact radius, c/a"
    (twisted,) = panels(plots.stick_history(results["torsion"]))
    assert legend_texts(twisted)[-1] == "Lubkin (closed form)"
    increments = slice(None, None, -(-200 // len(results["torsion"].history["step"])))
    np.testing.assert_allclose(twisted.lines[-1].get_ydata()[increments], twisted.lines[0].get_ydata(), atol=0.04)


def test_displacement_control_joins_no_values_of_closed_forms(tmp_path: Path) -> None:
    case = SPHERE.replace("{Qx: 30 N, increments: 3}", "{delta_x: 1 um, increments: 2}, {delta_x: 5 um}")
    assert invoke("run", write_case(tmp_path, case), "-q").exit_code == 0
    with open_result(tmp_path / "case.h5") as result:
        (axes,) = panels(plots.stick_history(result))
        form = next(line for line in axes.lines if line.get_label() == "Cattaneo-Mindlin (closed form)")
        assert form.get_linestyle() == "None"
        slides = result.history["stick_radius"] == 0.0
        assert slides.any() and np.array_equal(np.isnan(form.get_ydata()), slides)


def test_a_rig_has_the_loop_at_the_actuator_beside_the_loop_at_the_contact(tmp_path: Path) -> None:
    path = "{Qx: 30 N, increments: 3}, {actuator_x: -1 um, increments: 3}, {actuator_x: 1 um, increments: 3}"
    case = SPHERE.replace("{Qx: 30 N, increments: 3}", path) + "rig: {stiffness_x: 20 kN/mm}\n"
    assert invoke("run", write_case(tmp_path, case), "-q").exit_code == 0
    with open_result(tmp_path / "case.h5") as result:
        tangential, *_ = panels(plots.loop(result))
        lines = {line.get_label(): line for line in tangential.lines}
        assert list(lines) == ["at the actuator", "first loading, at the contact", "cycle 1, at the contact"]
        assert legend_texts(tangential)[:3] == list(lines)
        way = result.history["delta_x"] + result.history["Qx"] / 20e3
        np.testing.assert_allclose(lines["at the actuator"].get_xdata(), 1e3 * way, rtol=1e-6)
        np.testing.assert_array_equal(lines["at the actuator"].get_ydata(), result.history["Qx"])
        at_contact = lines["cycle 1, at the contact"].get_xdata()
        np.testing.assert_allclose(at_contact, 1e3 * result.history["delta_x"][3:])
        assert tangential.get_xlabel() == r"rigid displacement along x $\delta_x$, $D_x$ (µm)"
        assert load_texts(result, [6]) == ["$P$ = 400 N, $D_x$ = \N{MINUS SIGN}1 µm"]
        (axes,) = panels(plots.stick_history(result))
        assert axes.get_xlabel() == "displacement of the actuator along x $D_x$ (µm)"


BULK_ALONE = LINE.replace("{Qx: 18 N/mm, increments: 4}", "{bulk_2: {xx: 300 MPa}}") + "  - {bulk_2: {xx: -300 MPa}}\n"


def test_bulk_stress_alone_is_what_its_case_is_drawn_over(tmp_path: Path) -> None:
    assert invoke("run", write_case(tmp_path, BULK_ALONE), "-q").exit_code == 0
    with open_result(tmp_path / "case.h5") as result:
        axes = panels(plots.stick_history(result))[0]
        assert axes.get_xlabel() == r"bulk stress xx in body 2 $\sigma_{xx,2}$ (MPa)"
        lines = {str(line.get_label()): line for line in axes.lines}
        exact, found = lines["Hills-Nowell (closed form)"], lines["cycle 1"]
        np.testing.assert_allclose(found.get_xdata()[[0, -1]], [300.0, -300.0])
        parts = (len(exact.get_xdata()) - 1) // (result.increments - 1)
        np.testing.assert_allclose(found.get_ydata(), exact.get_ydata()[::parts][-11:], atol=0.03)
        texts = figure_texts(plots.profiles(result))
        assert texts[1:3] == [
            rf"increment {step}: $P$ = 100 N/mm, $\sigma_{{xx,2}}$ = {stress} MPa"
            for step, stress in ((10, "300"), (20, "−300"))
        ]
        assert result.history["bulk_2_yy"][[10, 20]] == pytest.approx([90.0, -90.0])  # plane strain
        assert load_texts(result, [20], plain=True) == ["P = 100 N/mm, bulk_2_xx = -300 MPa"]


def test_bulk_stress_has_no_loop_of_its_own(tmp_path: Path) -> None:
    words = BULK_ALONE.replace("plane: strain\n", "").replace("/mm", "").replace("cylinder", "sphere")
    words = words.replace("points: 64, size: 0.28 mm", "points: 16").replace("300 MPa", "300 MPa, yy: 300 MPa")
    assert invoke("run", write_case(tmp_path, words), "-q").exit_code == 0
    with open_result(tmp_path / "case.h5") as result:
        assert "xx" in panels(plots.stick_history(result))[0].get_xlabel()
        assert len(panels(plots.stick_history(result))) == 1  # yy goes with it
        with pytest.raises(PictureError, match="bulk stress has no displacement of its own; stick-history"):
            plots.loop(result)
