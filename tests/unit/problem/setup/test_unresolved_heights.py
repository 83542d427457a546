"""Height maps that are finer than the cells: warned of, in the error bars, and no accuracy is met by them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from solving import SPHERE, build

from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.problem.setup.warnings import case_warnings
from fretsolve.simulation.accuracy.in_memory import solved
from fretsolve.simulation.error_bars.error_bars import run_with_error_bars
from fretsolve.simulation.problem_setup import set_up

SPACING, WAVE, HEIGHT = 1e-3, 0.01, 2e-4
SLOPE = 2.0 * np.pi * HEIGHT / WAVE / np.sqrt(2.0)
"""Root mean square slope of the ridges."""


def ridges(folder: Path, wave: float = WAVE, height: float = HEIGHT, **parts: Any) -> ProblemSetup:
    """Return a sphere with ridges along y, on 72 x 72 cells of 9.9 um unless `parts` say otherwise."""
    file, x = folder / "ridges.npy", np.arange(-400, 401) * SPACING
    np.save(file, np.repeat(height * np.sin(2.0 * np.pi * x / wave)[:, None], 801, axis=1))
    return set_up(build(**{"surface": surface_of(folder), "grid": {"points": 72, "size": 0.71}, **parts}))


def surface_of(folder: Path) -> list[dict[str, Any]]:
    """Return the sphere and the ridges that were saved last."""
    return [SPHERE, {"heights": {"file": str(folder / "ridges.npy"), "spacing": SPACING}}]


def warned(setup: ProblemSetup) -> list[str]:
    return [text for text in case_warnings(setup) if "height map" in text]


def missed(setup: ProblemSetup) -> float:
    """Return the flattening pressure over that of all of the slopes."""
    needed = setup.heights().flattening_pressure((setup.grid.dx, setup.grid.dy))
    return needed / (0.5 * setup.model.compliances.contact_modulus * SLOPE)


def test_waves_of_less_than_some_cells_are_missed(tmp_path: Path) -> None:
    assert missed(ridges(tmp_path)) == pytest.approx(1.0, abs=0.05)
    # Of a wave of w, points h apart see sinc(h/w) of the slope; here h is 0.5 um, and 5 um.
    half = ridges(tmp_path, grid={"points": 142, "size": 0.71})
    assert missed(half) == pytest.approx(np.sqrt(np.sinc(0.05) ** 2 - np.sinc(0.5) ** 2), rel=5e-3)
    assert missed(ridges(tmp_path, grid={"points": 360, "size": 0.71})) == 0.0
    assert missed(ridges(tmp_path, wave=0.1)) == 0.0


def test_warning_says_which_grid_would_do(tmp_path: Path) -> None:
    (text,) = warned(ridges(tmp_path))
    assert text.startswith("grid.points: 72 x 72 cells miss waves of the height map that take 4.8")
    along_x, along_y = (int(text.split("flatten; ")[1].split(" ")[place]) for place in (0, 2))
    assert 500 < along_x < 600  # 8 cells per wave
    assert along_y == 72
    assert not warned(ridges(tmp_path, grid={"points": [along_x, along_y], "size": 0.71}))
    assert not warned(ridges(tmp_path, height=1e-9))
    assert not warned(ridges(tmp_path, wave=0.1))


def test_waves_near_the_spacing_of_the_map_are_missed_too(tmp_path: Path) -> None:
    """Ridges of 25 um in a map of points 10 um apart: cells as long as the points see two and a half per wave."""
    file = tmp_path / "coarse.npy"
    heights = 1e-4 * np.sin(2.0 * np.pi * np.arange(-60, 61) * 0.01 / 0.025)
    np.save(file, np.repeat(heights[:, None], 121, axis=1))
    surface = [SPHERE, {"heights": {"file": str(file), "spacing": 0.01}}]

    def pressed(points: Any) -> ProblemSetup:
        return set_up(build(surface=surface, friction=0.0, grid={"points": points, "size": 0.75}))

    advised = set()
    for points in (48, 52, 60, 75, 100):
        (text,) = warned(pressed(points))
        advised.add(text.split("flatten; ")[1].split(" ")[0])
        assert text.endswith("as far as the map does, which has few points per wave itself")
    (count,) = advised
    assert 4.0 * 30.0 < int(count) < 8.0 * 30.0
    assert not warned(pressed([int(count), 60]))


def test_form_and_tilt_in_the_map_hide_nothing(tmp_path: Path) -> None:
    axis = np.arange(-400, 401) * SPACING
    x, y = np.meshgrid(axis, axis, indexing="ij")
    waves = 2e-5 * np.sin(2.0 * np.pi * x / WAVE)
    for name, form in {"tilt": 0.3 * x, "sphere": (x**2 + y**2) / 20.0}.items():
        file = tmp_path / f"{name}.npy"
        np.save(file, waves + form)
        heights = {"heights": {"file": str(file), "spacing": SPACING}}
        surface = [heights] if name == "sphere" else [SPHERE, heights]
        setup = set_up(build(surface=surface, grid={"points": 72, "size": 0.71}))
        assert missed(setup) == pytest.approx(0.1, rel=0.05), name
        np.save(file, form)
        smooth = set_up(build(surface=surface, grid={"points": 72, "size": 0.71}))
        assert missed(smooth) == 0.0
        assert not warned(smooth)


def test_no_accuracy_is_met_by_cells_that_miss_waves(tmp_path: Path) -> None:
    asked = {"accuracy": {"target": 0.05, "at_most": {"cells": 4000}}}
    for wave, height, met in ((WAVE, HEIGHT, False), (WAVE, 1e-9, True), (0.1, HEIGHT, True)):
        first = ridges(tmp_path, wave, height, grid={"size": 0.71}, solver=asked)
        assert first.grid.nx < 40 and not warned(first)
        last, _, known = solved(build(surface=surface_of(tmp_path), grid={"size": 0.71}, solver=asked))
        assert known is not None and known.met == met
        assert met or (known.worst > 0.5 and "at_most.cells is 4000" in known.reason), last.before


@pytest.mark.slow
def test_bars_are_not_small(tmp_path: Path) -> None:
    (state,) = run_with_error_bars(ridges(tmp_path))
    errors, summary = state.errors, state.summary
    assert errors is not None
    for name in ("delta_z", "contact_radius", "max_pressure"):
        assert getattr(errors, f"{name}_error") > 0.9 * getattr(summary, name)
    assert errors.P_error < 1e-5 * summary.P
    (state,) = run_with_error_bars(ridges(tmp_path, wave=0.1))
    assert state.errors is not None
    assert state.errors.contact_radius_error < 0.1 * state.summary.contact_radius
