"""Error bars hold on height maps: waves that cells miss or hardly show, ridges and facets, and holes.

The true values are those of runs with more points per side.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bars import ends_of_stages
from solving import LOAD, SPHERE, A, build

from fretsolve.result.state import ESTIMATED
from fretsolve.setup.problem_setup import set_up
from fretsolve.simulation.error_bars.coarse_runs import values_of
from fretsolve.simulation.error_bars.error_bars import run_with_error_bars
from fretsolve.simulation.error_bars.least_errors.least_errors import LeastErrors
from fretsolve.simulation.error_bars.shear_path import ShearPath
from fretsolve.simulation.simulation import run


def wavy(file: Path, waves: int, height: float, shortest: float, step: float) -> dict[str, Any]:
    """Return a map of `waves` in all directions, in five lengths from `shortest` on."""
    x, y = np.meshgrid(*2 * [np.arange(-180, 181) * 2e-3], indexing="ij")
    heights = np.zeros_like(x)
    for wave in range(waves):
        along = x * np.cos(0.97 * wave) + y * np.sin(0.97 * wave)
        heights += height * np.sin(2.0 * np.pi * along / (shortest + step * (wave % 5)) + 2.4 * wave**2)
    np.save(file, heights)
    return {"heights": {"file": str(file), "spacing": 2e-3}}


def test_bars_hold_on_four_cells_per_wave(tmp_path: Path) -> None:
    surface = [SPHERE, wavy(tmp_path / "rough.npy", 12, 6e-6, 0.08, 0.008)]
    path = [{"P": 300.0}, {"Qx": 60.0, "increments": 2}]
    case = build(surface=surface, friction=0.3, grid={"points": 36, "size": 0.71}, load_path=path)
    summary, errors = ends_of_stages(case)[2]
    truth = {"delta_z": 7.4844e-3, "contact_radius": 0.27371, "max_pressure": 1972.7, "delta_x": 1.41506e-3}
    for name, true in (truth | {"stick_radius": 0.18963, "work_total": 5.0125e-3}).items():
        found, bar = getattr(summary, name), getattr(errors, f"{name}_error")
        assert abs(found - true) <= bar < 0.1 * true, f"{name} {found:.5g} +- {bar:.2g}, truly {true:.5g}"


def test_bars_hold_the_moment_of_unlike_bodies_sheared_on_a_rough_map(tmp_path: Path) -> None:
    waves = (  # length in mm, direction, phase
        (0.489, 1.4067, 3.6312),
        (0.3101, 2.6055, 0.6061),
        (0.4823, 3.066, 2.4827),
        (0.5138, 1.8423, 4.6239),
        (0.3549, 3.0892, 0.8551),
        (0.4405, 1.3386, 0.343),
    )
    x, y = np.meshgrid(*2 * [np.linspace(-1.32072, 1.32072, 257)], indexing="ij")
    phases = (2.0 * np.pi * (x * np.cos(turn) + y * np.sin(turn)) / length + phase for length, turn, phase in waves)
    np.save(tmp_path / "rough.npy", 3.7267e-5 * sum(np.sin(phase) for phase in phases))
    map_of_it = {"heights": {"file": str(tmp_path / "rough.npy"), "spacing": 0.010318125}}
    case = build(
        bodies=["rigid", {"young_modulus": 16800.0, "poisson_ratio": 0.31}],
        surface=[{"sphere": {"radius": 11.006}}, map_of_it],
        friction=1.108,
        grid={"points": 36, "size": [1.8213, 1.9129]},
        load_path=[
            {"P": 465.9, "increments": 8},
            {"delta_x": 0.0169, "increments": 8},
            {"delta_x": -0.0169, "increments": 16},
        ],
    )
    ends = ends_of_stages(case)
    # Qx has a bar of 2.1 %: pressing moves the bodies sideways, so that its error by the increments counts 4 times
    for stage, truth in ((2, {"My": -18.501, "Qx": 268.37}), (3, {"My": 18.356, "Qx": -274.75})):
        summary, errors = ends[stage]
        for name, true in truth.items():
            found, bar = getattr(summary, name), getattr(errors, f"{name}_error")
            assert abs(found - true) <= bar < 0.025 * abs(true), f"{name} {found:.5g} +- {bar:.2g}, truly {true:.5g}"


def test_bars_hold_the_peaks_of_a_map_finer_than_the_cells(tmp_path: Path) -> None:
    """Twenty waves of 18 to 23 um in all directions, on cells of 20 um."""
    surface = [SPHERE, wavy(tmp_path / "waves.npy", 20, 4e-6, 0.018, 0.0012)]
    summary, errors = ends_of_stages(build(surface=surface, friction=0.0, grid={"points": 36, "size": 0.71}))[1]
    for name, true in {"max_pressure": 2860.0, "delta_z": 9.06593e-3, "contact_radius": 0.30036}.items():
        found, bar = getattr(summary, name), getattr(errors, f"{name}_error")
        assert abs(found - true) <= bar < 0.3 * true, f"{name} {found:.5g} +- {bar:.2g}, truly {true:.5g}"


@pytest.mark.parametrize(("waves", "seeds"), [(1, range(12)), (6, range(12, 24))])
def test_bars_hold_the_peaks_of_waves_of_some_cells(tmp_path: Path, waves: int, seeds: range) -> None:
    """Coarse grids may agree by chance on a largest pressure that is 10 % off."""
    axis = np.linspace(-1.0, 1.0, 401)
    x, y = np.meshgrid(axis, axis, indexing="ij")
    surface = [SPHERE, {"heights": {"file": str(tmp_path / "map.npy"), "spacing": 5e-3}}]
    parts = {"surface": surface, "friction": 0.0, "load_path": [{"P": 400.0}]}
    ratios = []
    for seed in seeds:
        rng, heights = np.random.default_rng(seed), np.zeros_like(x)
        for turn, length, phase in zip(*(rng.uniform(*ends, waves) for ends in ((0, 3), (4, 8), (0, 6))), strict=True):
            heights += np.sin(2.0 * np.pi * 36.0 / length * (x * np.cos(turn) + y * np.sin(turn)) + phase)
        np.save(tmp_path / "map.npy", 2.5e-4 / math.sqrt(waves) * heights)
        (bars,) = run_with_error_bars(set_up(build(**parts, grid={"points": 36, "size": 1.0})))
        (fine,) = run(build(**parts, grid={"points": 144, "size": 1.0}))
        assert bars.errors is not None
        error = bars.summary.max_pressure - fine.summary.max_pressure
        ratios.append(abs(error) / bars.errors.max_pressure_error)
    assert max(ratios) < 1.1


@pytest.mark.parametrize(("rim", "size"), [(0.31, 0.86), (0.33, 0.86), (0.36, 0.8)])
def test_bars_hold_the_radius_of_a_contact_beside_a_hole(tmp_path: Path, rim: float, size: float) -> None:
    """A sphere whose map ends in NaN within a cell of the contact, whose edge no gap shows."""
    x = np.arange(-45, 46) * 0.01
    square = x[:, None] ** 2 + x**2
    np.save(tmp_path / "sphere.npy", np.where(square < rim**2, square / 20.0, np.nan))
    surface = [{"heights": {"file": str(tmp_path / "sphere.npy"), "spacing": 0.01}}]
    case = build(surface=surface, grid={"points": 24, "size": size}, load_path=[{"P": LOAD, "increments": 2}])
    summary, errors = ends_of_stages(case)[1]
    assert abs(summary.contact_radius - A) <= errors.contact_radius_error < 0.04 * A


@pytest.mark.parametrize(("rim", "unbounded"), [(0.25, True), (0.4, False)])
def test_the_largest_pressure_has_no_bound_where_a_map_ends_within_the_contact(
    tmp_path: Path, rim: float, unbounded: bool
) -> None:
    """A rim of NaN ends the body sharply, as a sharp punch does; beyond the contact it changes nothing."""
    x = np.arange(-80, 81) * 0.005
    beyond = np.maximum(abs(x[:, None]), abs(x)) > rim
    np.save(tmp_path / "sphere.npy", np.where(beyond, np.nan, (x[:, None] ** 2 + x**2) / 20.0))
    surface = [{"heights": {"file": str(tmp_path / "sphere.npy"), "spacing": 0.005}}]
    case = build(surface=surface, grid={"points": 48, "size": 0.78}, load_path=[{"P": LOAD, "increments": 2}])
    summary, errors = ends_of_stages(case)[1]
    assert math.isinf(errors.max_pressure_error) == unbounded
    assert errors.contact_radius_error > 0.2 * 0.78 / 48 if unbounded else abs(summary.contact_radius - A) < 1e-3 * A


def test_heights_that_cells_miss_count_once_in_half_widths_and_middles(tmp_path: Path) -> None:
    """By the share of the contact radius by which they change that."""
    surface = [SPHERE, wavy(tmp_path / "waves.npy", 20, 4e-6, 0.018, 0.0012)]
    setup = set_up(build(surface=surface, friction=0.0, grid={"points": 36, "size": 0.71}))
    least = LeastErrors.of(setup)
    (state,) = run(setup)
    largest = np.abs(values_of(state.summary))
    with_heights, without = (one.values(state, largest, ShearPath()) for one in (least, replace(least, flattening=0.0)))
    added = dict(zip(ESTIMATED, with_heights - without, strict=True))
    assert added["contact_radius"] > 1e-3 * state.summary.contact_radius
    for name in ("contact_half_width_x", "contact_half_width_y", "contact_center_x", "stick_center_y"):
        assert added[name] == pytest.approx(added["contact_radius"]), name


@pytest.mark.parametrize(("spacing", "finest", "radius"), [(0.05, 1880.6, 0.18955), (0.1, 3264.5, 0.30279)])
def test_bars_hold_the_ridges_and_facets_of_a_coarse_map(
    tmp_path: Path, spacing: float, finest: float, radius: float
) -> None:
    """A sphere as a map of few points, whose facets meet at ridges; compared with cells a sixteenth as long."""
    x = spacing * (np.arange(13) - 6)
    np.save(tmp_path / "map.npy", (x[:, None] ** 2 + x**2) / 20.0)
    surface = {"heights": {"file": str(tmp_path / "map.npy"), "spacing": spacing}}
    grid, load = ({"points": 25, "size": 0.55}, 100.0) if spacing == 0.05 else ({"points": 25, "size": 0.75}, 400.0)
    summary, errors = ends_of_stages(build(surface=surface, friction=0.0, grid=grid, load_path=[{"P": load}]))[1]
    assert abs(summary.max_pressure - finest) <= errors.max_pressure_error < 0.4 * finest
    assert abs(summary.contact_radius - radius) <= errors.contact_radius_error < 0.1 * radius


@pytest.mark.parametrize("points", [28, 32, 40])
@pytest.mark.parametrize(
    ("end", "moment", "tilt"), [("groove", -1.995, 4.772e-4), ("hole", -0.5422, 1.3396e-4), ("edge", -10.02, 4.206e-3)]
)
def test_bars_hold_the_moments_and_tilts_of_a_contact_with_a_hole(
    tmp_path: Path, end: str, moment: float, tilt: float, points: int
) -> None:
    """Against 224 points. All grids round the hole to their cells; bars were up to 2.9 times too small."""
    x, y = np.meshgrid(*2 * [np.linspace(-0.75, 0.75, 501)], indexing="ij")
    gone = {"groove": abs(x - 0.1) < 0.05, "hole": np.hypot(x - 0.12, y - 0.05) < 0.07, "edge": x > 0.15}[end]
    np.save(tmp_path / "map.npy", np.where(gone, np.nan, 0.0))
    surface = [SPHERE, {"heights": {"file": str(tmp_path / "map.npy"), "spacing": 0.003}}]
    for path, name, true in (({"P": LOAD}, "My", moment), ({"P": LOAD, "My": 0.0}, "phi_y", tilt)):
        case = build(surface=surface, friction=0.2, grid={"points": points, "size": 0.9}, load_path=[path])
        summary, errors = ends_of_stages(case)[1]
        bar = getattr(errors, f"{name}_error")
        assert abs(getattr(summary, name) - true) <= bar, name
        assert bar < {"My": 0.1 * LOAD * A, "phi_y": 0.1 * summary.delta_z / A}[name], name


@pytest.mark.parametrize("points", [32, 40, 48])
def test_bars_hold_what_slips_at_the_corners_of_a_map(tmp_path: Path, points: int) -> None:
    """Of a flat triangle that settles on an unlike body, against 200 points. Bars were up to 10 times too small."""
    x, y = np.meshgrid(*2 * [np.linspace(-0.5, 0.5, 481)], indexing="ij")
    np.save(tmp_path / "map.npy", np.where((y < -0.2) | (y > 0.3 - 2.0 * abs(x + 0.03)), np.nan, 0.0))
    case = build(
        bodies=[{"young_modulus": 200e3, "poisson_ratio": 0.3}, {"young_modulus": 70e3, "poisson_ratio": 0.2}],
        surface={"heights": {"file": str(tmp_path / "map.npy"), "spacing": 1.0 / 480.0}},
        friction=0.4,
        grid={"points": points, "size": 0.8},
        load_path=[{"P": 250.0, "Mx": 0.0, "My": 0.0, "increments": 2}, {"Qx": 40.0, "increments": 2}],
    )
    summary, errors = ends_of_stages(case)[2]
    assert abs(summary.work_total - 1.29e-3) <= errors.work_total_error < 2e-3
