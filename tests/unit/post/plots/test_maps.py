"""Maps of fields and films of them, streamlines and slip angles."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from command_line import invoke
from matplotlib.animation import FFMpegWriter
from pictures import figure_texts, heading, image_of, panels
from PIL import Image, ImageSequence

from fretsolve.post import plots
from fretsolve.post.plots.pictures.directions import angle_of
from fretsolve.post.plots.snapshot import Snapshot
from fretsolve.result import Result
from fretsolve.result.state import Zone


def test_map_shows_the_fields_zoomed_to_the_contact(results: dict[str, Result]) -> None:
    result = results["fretting"]
    figure = plots.contact_map(result)
    axes = panels(figure)
    titles = [one.get_title() for one in axes]
    assert titles == ["pressure (MPa)", "shear traction (MPa)", "slip (µm)", "zone", "dissipated energy (mJ/mm²)"]
    assert [one.get_ylabel() for one in axes] == ["y (mm)", "", "y (mm)", "", "y (mm)"]  # once a row
    shear = np.hypot(result.field("shear_x"), result.field("shear_y"))
    expected = [result.field("pressure"), shear, None, result.field("zone"), result.field("work_density")]
    for one, values in zip(axes, expected, strict=True):
        assert one.get_aspect() == 1.0
        assert one.get_xlabel() == "x (mm)"
        if values is not None:
            shown = image_of(one)
            hidden = np.ma.getmaskarray(shown)
            np.testing.assert_allclose(shown.data[~hidden], values.T[~hidden])
            assert not values.T[hidden].any()
    left, right = axes[0].get_xlim()
    radius = result.history["contact_radius"][-1]
    assert -1.4 * radius < left < -radius and radius < right < 1.4 * radius
    assert "increment 16 (stage 6): $P$ = 400 N, $Q_x$ = 36 N" in heading(figure)
    assert figure_texts(figure) == ["edge of the contact", "edge of the stick zone"]


def test_map_of_chosen_fields_and_increment(results: dict[str, Result]) -> None:
    result = results["fretting"]
    figure = plots.contact_map(result, step=-13, fields=["gap", "shear"])
    gap, shear = panels(figure)
    np.testing.assert_allclose(image_of(gap), 1e3 * result.field("gap", 4).T)
    assert gap.get_title() == "gap (µm)"
    (arrows,) = [item for item in shear.collections if type(item).__name__ == "Quiver"]
    assert np.hypot(arrows.U, arrows.V) == pytest.approx(1.0)
    assert (arrows.U > 0.9).mean() > 0.5  # along the load
    assert "increment 4 (stage 2)" in heading(figure)


def test_animation(result_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "film.gif"
    done = invoke("plot", result_folder / "torsion.h5", "animate", "-o", out, "--field", "shear")
    assert done.exit_code == 0, done.stderr
    with Image.open(out) as film:
        assert (film.format, film.n_frames) == ("GIF", 4)
        frames = [np.asarray(frame.convert("L"), float) for frame in ImageSequence.Iterator(film)]
    assert all(np.abs(one - other).max() > 50 for one, other in itertools.pairwise(frames))
    monkeypatch.setattr(FFMpegWriter, "isAvailable", classmethod(lambda cls: False))
    done = invoke("plot", result_folder / "torsion.h5", "animate", "-o", tmp_path / "film.mp4")
    assert (done.exit_code, done.output.count("\n")) == (2, 1)
    assert "mp4 needs ffmpeg, which is not on the path: install it, or write a .gif" in done.stderr


def test_streamlines(results: dict[str, Result]) -> None:
    shear, slip = panels(plots.streamlines(results["torsion"]))
    assert (shear.get_title(), slip.get_title()) == ("shear traction (MPa)", "slip (µm)")
    lines = slip.collections[0]
    points = np.concatenate(lines.get_segments())
    assert len(points) > 100
    assert np.hypot(*points.T).min() > 0.15  # nothing slips inside of Lubkin's circle of 0.209 mm


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
