"""Streamlines and slip angles."""

from __future__ import annotations

import numpy as np
from pictures import image_of, panels

from fretsolve import plots
from fretsolve.plots.pictures import directions
from fretsolve.plots.pictures.directions import angle_of
from fretsolve.plots.snapshot import Snapshot
from fretsolve.result import Result
from fretsolve.result.state import Zone


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


def test_a_ring_of_one_cell_is_too_narrow_for_lines() -> None:
    x, y = np.meshgrid(np.arange(-9, 10), np.arange(-9, 10))
    radius = np.hypot(x, y)
    assert directions._is_narrow((radius < 8.0) & (radius > 6.5))
    assert not directions._is_narrow((radius < 8.0) & (radius > 3.0))
