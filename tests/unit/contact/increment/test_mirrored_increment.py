"""Increments that are mirror images of themselves, solved on one half of the grid."""

from __future__ import annotations

import numpy as np
import pytest
from solving import DISSIMILAR, LOAD, SIMILAR, build

import fretsolve
from fretsolve.contact.increment.increment import IncrementSolver
from fretsolve.contact.increment.mirrored_increment import MirroredIncrementSolver
from fretsolve.problem.surface.separation import is_mirrored
from fretsolve.simulation.problem_setup import set_up
from fretsolve.simulation.simulation import increment_solver


def setup_of(load_path, **parts):
    load_path = [{"increments": 1} | stage for stage in load_path]
    return set_up(build(**{"bodies": DISSIMILAR, "grid": {"points": 26, "size": 0.8}, "load_path": load_path} | parts))


def both(load_path, monkeypatch, **parts):
    """The states solved on one half, and on the whole grid."""
    setup = setup_of(load_path, **parts)
    half = list(fretsolve.run(setup))
    monkeypatch.setattr("fretsolve.simulation.simulation.is_mirrored", lambda *_: False)
    return half, list(fretsolve.run(setup))


@pytest.fixture
def solved_whole(monkeypatch):
    """Collects the steps that the whole grid has solved."""
    steps, solve = [], IncrementSolver.solve

    def watched(self, increment, start):
        if isinstance(self, MirroredIncrementSolver):
            steps.append(increment.step)
        return solve(self, increment, start)

    monkeypatch.setattr(IncrementSolver, "solve", watched)
    return steps


PATHS = {
    "mode I": [{"P": LOAD, "increments": 3}, {"Qx": 30.0, "increments": 3}, {"Qx": -30.0, "increments": 4}],
    "mode II": [{"P": LOAD, "increments": 4}, {"P": 0.4 * LOAD, "increments": 3}],
    "displacements": [{"delta_z": 0.008}, {"delta_x": 4e-4, "increments": 2}, {"phi_y": 1e-3, "increments": 2}],
    "bulk stress": [{"P": LOAD}, {"Qx": 20.0, "bulk_2": {"xx": 60.0, "yy": 10.0}, "increments": 3}, {"Qx": -20.0}],
    "rocking": [{"P": LOAD}, {"My": 8.0, "Qx": 10.0, "increments": 3}],
}


@pytest.mark.parametrize(
    ("path", "bodies"), [*((path, DISSIMILAR) for path in PATHS), ("mode I", SIMILAR), ("bulk stress", SIMILAR)]
)
def test_histories_are_those_of_the_whole_grid(path, bodies, monkeypatch):
    half, whole = both(PATHS[path], monkeypatch, bodies=bodies)
    assert len(half) == len(whole) > 3
    for one, other in zip(half, whole, strict=True):
        assert max(v for k, v in vars(one.summary).items() if k.startswith("residual")) <= 1e-6
        for name in ("P", "My", "Qx", "max_pressure", "contact_radius", "stick_radius"):
            expected = getattr(other.summary, name)
            tiny = 1e-5 * LOAD if name in ("P", "My", "Qx") else 0.0
            assert getattr(one.summary, name) == pytest.approx(expected, rel=2e-5, abs=tiny), name
        for name in ("delta_z", "delta_x", "phi_y"):
            assert getattr(one.summary, name) == pytest.approx(getattr(other.summary, name), rel=1e-5, abs=1e-9), name
        assert one.summary.work == pytest.approx(other.summary.work, rel=1e-4, abs=1e-9)
        for name in ("pressure", "shear", "slip", "gap"):
            expected = getattr(other.fields, name)
            largest = float(np.abs(expected).max())
            assert getattr(one.fields, name) == pytest.approx(expected, abs=1e-4 * largest), name


@pytest.mark.parametrize(
    ("friction", "steps"),
    [
        ({"expression": "0.1 + 0.1*(r < 0.1)"}, []),
        ({"coefficient": 0.1, "shear_limit": 150.0}, []),
        ({"expression": "0.1 + 0.1*(y > 0.1)"}, [0, 1, 2, 3]),
    ],
    ids=str,
)
def test_friction_that_varies(friction, steps, monkeypatch, solved_whole):
    path = [{"P": LOAD}, {"Qx": 20.0, "increments": 2}, {"Qx": 0.0}]
    half = list(fretsolve.run(setup_of(path, friction=friction)))
    assert solved_whole == steps
    monkeypatch.setattr("fretsolve.simulation.simulation.is_mirrored", lambda *_: False)
    whole = list(fretsolve.run(setup_of(path, friction=friction)))
    for one, other in zip(half, whole, strict=True):
        assert one.summary.delta_x == pytest.approx(other.summary.delta_x, rel=1e-5, abs=1e-9)
        largest = float(np.abs(other.fields.shear).max())
        assert one.fields.shear == pytest.approx(other.fields.shear, abs=1e-4 * largest)


def test_fields_are_mirror_images_to_the_last_bit():
    *_, last = fretsolve.run(setup_of(PATHS["mode I"]))
    for field in (last.fields.pressure, last.fields.gap, last.fields.zone, last.fields.shear[0], last.fields.slip[0]):
        assert np.array_equal(field, field[:, ::-1])
        assert field.any()
    for field in (last.fields.shear[1], last.fields.slip[1]):
        assert np.array_equal(field, -field[:, ::-1])
        assert field.any()
    assert all(getattr(last.summary, name) == 0.0 for name in ("Mx", "Qy", "Mz", "phi_x", "delta_y", "phi_z"))


@pytest.mark.parametrize(
    ("last", "steps"),
    [
        ({"Qy": 5.0}, [2]),
        ({"Mx": 2.0}, [2]),
        ({"bulk_2": {"xx": 20.0}}, []),
        ({"bulk_2": {"xy": 20.0}}, [2]),
        ({"phi_x": 1e-4}, [2]),
    ],
    ids=str,
)
def test_what_is_no_mirror_image_is_solved_on_the_whole_grid(last, steps, solved_whole):
    states = list(fretsolve.run(setup_of([{"P": LOAD}, {"Qx": 10.0}, last])))
    assert len(states) == 3
    assert solved_whole == steps


def test_an_increment_back_to_a_mirror_image_stays_on_the_whole_grid(solved_whole):
    """Its start is none: slip along y has left shear along y."""
    list(fretsolve.run(setup_of([{"P": LOAD}, {"Qy": 20.0}, {"Qy": 0.0}])))
    assert solved_whole == [1, 2]


@pytest.mark.parametrize(
    ("parts", "expected"),
    [
        ({}, True),
        ({"grid": {"points": 25, "size": 0.8}}, False),
        ({"grid": {"points": [25, 26], "size": 0.8}}, True),
        ({"grid": {"points": 26, "size": 0.8, "center": [0.01, 0.0]}}, True),
        ({"grid": {"points": 26, "size": 0.8, "center": [0.0, 0.01]}}, False),
        ({"surface": {"cylinder": {"radius": 10.0, "axis": "y", "length": 0.4}}}, True),
        ({"surface": {"ellipsoid": {"radius_x": 10.0, "radius_y": 5.0}}}, True),
    ],
    ids=str,
)
def test_surfaces_that_are_mirror_images(parts, expected):
    setup = setup_of([{"P": 10.0}], **parts)
    assert is_mirrored(setup.grid, setup.separation()) is expected
    assert isinstance(increment_solver(setup, setup.separation(), 1), MirroredIncrementSolver) is expected


def test_a_resumed_run_gives_the_same_bits():
    setup = setup_of(PATHS["mode I"], grid={"points": 34, "size": 0.8})
    states = list(fretsolve.run(setup))
    for at in (0, 4, 7):
        history = [state.summary for state in states[: at + 1]]
        resumed = list(fretsolve.run(setup, states[at], history))
        assert len(resumed) == len(states) - at - 1
        for one, other in zip(resumed, states[at + 1 :], strict=True):
            assert np.array_equal(one.fields.pressure, other.fields.pressure)
            assert np.array_equal(one.fields.shear, other.fields.shear)
            assert one.summary.delta_x == other.summary.delta_x


def test_the_reason_of_a_failure_is_told_of_the_whole_grid():
    with pytest.raises(fretsolve.errors.NoSolutionError, match=r"-x, \+x, -y, \+y"):
        list(fretsolve.run(setup_of([{"P": LOAD}], grid={"points": 26, "size": 0.4})))
    with pytest.raises(fretsolve.errors.NoSolutionError, match="gross slip under Qx = 50 N"):
        list(fretsolve.run(setup_of([{"P": LOAD}, {"Qx": 50.0}])))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("precision", "threads", "compiled"),
    [("double", 3, "0"), ("double", 3, "1"), ("single", 1, "0"), ("single", 3, "1")],
)
def test_as_on_a_large_grid(precision, threads, compiled, monkeypatch):
    """Active regions, coarse grids, fast transforms in blocks, passes in parts, memory given back."""
    monkeypatch.setenv("FRETSOLVE_NUMBA", compiled)
    for place, value in {
        "contact.increment.active_region.FEWEST_POINTS": 8,
        "contact.increment.grid_hierarchy.FEWEST_COARSE_POINTS": 8,
        "contact.increment.increment.LARGE_GRID": 50,
        "elastic.mirrored_operator.MOST_PRODUCTS": 0,
        "elastic.fftw.CACHE_BYTES": 4096,
        "elastic.thread_team.PART_CELLS": 100,
    }.items():
        monkeypatch.setattr(f"fretsolve.{place}", value)
    path = [{"P": LOAD}, {"Qx": 30.0, "increments": 3}, {"Mz": 1.0, "increments": 2}]
    solver = {"precision": precision, "tolerance": 1e-6 if precision == "double" else 1e-4}
    setup = setup_of(path, grid={"points": 42, "size": 1.2}, solver=solver)
    half = list(fretsolve.run(setup, threads=threads))
    monkeypatch.setattr("fretsolve.simulation.simulation.is_mirrored", lambda *_: False)
    whole = list(fretsolve.run(setup, threads=threads))
    for one, other in zip(half, whole, strict=True):
        near = {"rel": 20 * solver["tolerance"], "abs": 1e-9}
        assert one.summary.delta_x == pytest.approx(other.summary.delta_x, **near)
        assert one.summary.delta_z == pytest.approx(other.summary.delta_z, **near)
        largest = float(np.abs(other.fields.shear).max())
        assert one.fields.shear == pytest.approx(other.fields.shear, abs=100 * solver["tolerance"] * largest)
    if threads > 1:
        alone = list(fretsolve.run(setup))
        monkeypatch.setattr("fretsolve.simulation.simulation.is_mirrored", lambda *_: True)
        for one, other in zip(fretsolve.run(setup), half, strict=True):
            assert np.array_equal(one.fields.shear, other.fields.shear)
        for one, other in zip(alone, whole, strict=True):
            assert np.array_equal(one.fields.shear, other.fields.shear)


def test_contact_away_from_the_middle_and_lift_off(monkeypatch):
    """A ring, lifted off and pressed again."""
    ring = [{"sphere": {"radius": -200.0}}, {"punch": {"radius": 0.3, "edge_radius": 0.1}}]
    path = [{"P": 100.0}, {"Qx": 3.0}, {"P": 0.0, "Qx": 0.0, "increments": 2}, {"P": 100.0}]
    half, whole = both(path, monkeypatch, surface=ring)
    for one, other in zip(half, whole, strict=True):
        assert one.summary.contact_cells == other.summary.contact_cells
        assert one.summary.delta_z == pytest.approx(other.summary.delta_z, rel=1e-5, abs=1e-9)
        assert one.fields.pressure == pytest.approx(other.fields.pressure, abs=1e-3)
    middle = half[0].fields.pressure[13, 13]
    assert middle < 0.9 * half[0].summary.max_pressure
