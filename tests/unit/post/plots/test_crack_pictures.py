"""Pictures of cracks: stress intensity beside the threshold, and lives, of which some do not end."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_hex
from pictures import heading, legend_texts

from fretsolve.post.crack.crack_file import BodyCrack
from fretsolve.post.plots.pictures.cracks import crack_figure

INF, NAN = np.inf, np.nan
LENGTHS = np.array([0.01, 0.1, 1.0, 10.0, 100.0])


def crack_of(verdict="arrests", lives=True, **values: float) -> BodyCrack:
    """A crack whose range is closed at its last length; cracks below 0.1 mm stop, and 1 mm takes 1e5 cycles more."""
    columns = {"range": np.array([2.0, 1.0, 4.0, 5.0, -1.0]), "range_error": np.full(5, 0.5)}
    if verdict:
        columns["threshold"] = np.array([1.0, 2.0, 2.0, 2.0, 2.0])
    if lives:
        columns |= {
            "initiation_life": np.array([1e3, 1e4, 1e6, INF, INF]),
            "propagation_life": np.array([INF, INF, 1e5, 1e4, NAN]),
            "total_life": np.array([INF, INF, 1.1e6, INF, NAN]),
        }
    return BodyCrack(
        Path("c.crack.h5"), -0.1076, 0.0, np.arange(2), LENGTHS, np.zeros(0, int), columns, verdict, values
    )


@pytest.fixture(scope="module")
def drawn():
    """A crack that may stop, with lives."""
    known = {"arrest_length": 0.05, "arrest_length_error": 0.002, "final_length": 50.0}
    life = {"life": 1.1e6, "life_error": 2e5, "initiation_length": 1.0, "crossing_length": 0.5}
    return crack_figure({2: crack_of(**known, **life)}, "a title")


def test_range_with_its_band_stands_beside_the_threshold(drawn):
    axes = drawn.axes[0]
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    value, threshold, arrest = axes.lines
    np.testing.assert_array_equal(value.get_ydata(), [2.0, 1.0, 4.0, 5.0, NAN])
    np.testing.assert_array_equal(threshold.get_ydata(), [1.0, 2.0, 2.0, 2.0, 2.0])
    assert arrest.get_xdata()[0] == 0.05
    band = axes.collections[0].get_paths()[0].vertices
    assert (band[:, 1].min(), band[:, 1].max()) == (0.5, 5.5) or axes.get_ylim()[0] > 0.5
    assert legend_texts(axes) == [r"$\Delta K$", "its error", "threshold", "closed, no range", "arrests at 0.05 mm"]
    assert "crack at $x$ = -0.1076 mm, arrests at $b$ = 0.05 ± 0.002 mm, life ends at $b_f$ = 50 mm" in heading(
        drawn
    ).replace("\n", " ")
    assert axes.get_xlim() == (0.01, 50.0)


def test_lives_leave_the_picture_where_they_do_not_end(drawn):
    axes = drawn.axes[1]
    top = axes.get_ylim()[1]
    assert 1.1e6 < top < INF
    upwards = {tuple(line.get_xdata()) for line in axes.lines if len(line.get_ydata()) and top in line.get_ydata()}
    assert upwards == {(1.0, 1.0)}  # initiation beyond 1 mm, propagation and total on both sides
    assert all(np.isfinite(np.array(line.get_ydata(), float)).all() for line in axes.lines)
    assert legend_texts(axes) == [
        "initiation",
        "propagation",
        "total",
        "run-out",
        "shortest: 1.1e+06 at 1 mm",
        "equal parts at 0.5 mm",
    ]
    (cross,) = [line for line in axes.lines if line.get_marker() == "x"]
    # half-way in decades: initiation has 1e4 at 0.1 mm and 1e6 at 1 mm
    assert cross.get_ydata()[0] == pytest.approx(1e4 * 100.0 ** np.log10(5.0))


def test_what_is_not_known_is_left_out():
    (axes,) = crack_figure({2: crack_of(None, lives=False)}, "a title").axes
    assert legend_texts(axes) == [r"$\Delta K$", "its error", "closed, no range"]
    both = crack_figure({1: crack_of("no crack", lives=False), 2: crack_of("goes through")}, "t")
    titles = [axes.get_title() for axes in both.axes]
    assert titles == [
        "body 2, range of stress intensity",
        "body 2, life",
        "body 1, range of stress intensity",
        "body 1, life",
    ]
    assert [text.get_text() for text in both.axes[3].texts] == ["no life is known"]
    text = heading(both).replace("\n", " ")
    assert text.index("goes through") < text.index("no crack")
    in_doubt = crack_figure({2: crack_of(lives=False, arrest_length=0.05, arrest_length_error=INF)}, "t")
    assert "0.05 mm, but may go through" in heading(in_doubt).replace("\n", " ")


def test_a_life_that_never_ends_is_said():
    one = crack_of("no crack")
    one.columns["total_life"][:] = INF
    axes = crack_figure({2: one}, "t").axes[1]
    assert "total: run-out at all lengths" in legend_texts(axes)
    assert len({to_hex(line.get_color()) for line in axes.lines}) >= 3
