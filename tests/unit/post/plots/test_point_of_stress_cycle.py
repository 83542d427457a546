"""Stresses over a cycle at a point: which point, and on or below the surface."""

import numpy as np
import pytest
from command_line import refused, result_of
from line_cases import LINE
from pictures import heading
from small_cases import LOOP, write_case

from fretsolve import open_result
from fretsolve.post.plots import stress_cycle
from fretsolve.post.stress.influence import COMPONENTS


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A line contact without a cycle in its load path, and a sphere with one."""
    folder = tmp_path_factory.mktemp("points")
    result_of(write_case(folder, LINE, "line.yaml"))
    result_of(write_case(folder, LOOP, "loop.yaml"))
    return folder


def test_stress_below_the_middle_of_a_pressed_line_is_that_of_hertz(folder):
    with open_result(folder / "line.h5") as result:
        half, largest = float(result.history["contact_radius"][0]), float(result.history["max_pressure"][0])
        figure = stress_cycle(result, at=(0.0, 0.0, 0.1))
        x = float(result.x[np.abs(result.x).argmin()])
    drawn = dict(zip(COMPONENTS, (line.get_ydata()[0] for line in figure.axes[0].lines), strict=True))
    # on the axis of Hertz's line, before any shear; x is at most half a cell beside it
    root = np.hypot(half, 0.1)
    assert drawn["zz"] == pytest.approx(-largest * half / root, rel=3e-3)
    assert drawn["xx"] == pytest.approx(-largest / half * ((half**2 + 2 * 0.01) / root - 0.2), rel=2e-2)
    assert abs(x) <= 0.28 / 64
    assert f"at x = {x:.4g}, y = 0 mm, depth = 0.1 mm; over the whole load path" in heading(figure).replace("\n", " ")


def test_the_default_is_the_point_of_largest_tension_which_is_said(folder):
    with open_result(folder / "loop.h5") as result:
        by_default, by_name = stress_cycle(result), stress_cycle(result, at="tension")
        other = stress_cycle(result, at=(0.0, 0.0))
    said = heading(by_default).replace("\n", " ")
    assert said == heading(by_name).replace("\n", " ")
    assert "mm, on the surface, where the tension is largest; over cycle 1" in said
    assert "tension" not in heading(other)
    tension = [figure.axes[1].lines[1].get_ydata().max() for figure in (by_default, other)]
    assert tension[0] > tension[1]


def test_points_that_are_refused(folder, tmp_path):
    plot = ("plot", folder / "loop.h5")
    out = ("-o", tmp_path / "a.png")
    assert "depth 0.001 mm: 0 or at least half a cell" in refused(2, *plot, "stress-cycle", "--at", "0,0,.001", *out)
    assert "depth -1 mm: 0 or at least" in refused(2, *plot, "stress-cycle", "--at", "0,0,-1", *out)
    for point in ("tension", "0,0,0.1"):
        message = "profiles: shows lines on the surface: --at X,Y is needed"
        assert message in refused(2, *plot, "profiles", "--at", point, *out)
    for text in ("nan,0", "1", "0,0,0,0"):
        message = f"{text!r} is not a point; two numbers in mm such as 0.1,-0.05 are needed, the depth as a third, or"
        assert message in refused(2, *plot, "stress-cycle", "--at", text, *out)
