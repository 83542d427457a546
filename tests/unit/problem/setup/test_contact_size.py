from __future__ import annotations

import math

import pytest
from solving import DISSIMILAR, HERTZ, LOAD, MATERIAL, A, build

from fretsolve.errors import CaseError
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.problem.setup.picked_settings import AREA_MARGIN, room_for_coarse_runs
from fretsolve.reference.hertz import hertz_elliptic, love_cone
from fretsolve.simulation.error_bars.error_bars import run_with_error_bars
from fretsolve.simulation.problem_setup import contact_size, set_up
from fretsolve.simulation.simulation import run


def load(p=LOAD, mx=None, my=None):
    return LoadControl((True, mx is not None, my is not None), (p, mx or 0.0, my or 0.0))


def size(surface, *loads, center=(0.0, 0.0), first=1.0):
    surfaces = build(surface=surface, grid={"points": 8}).surface
    return contact_size(surfaces, MATERIAL, loads or [load()], center, first)


SPHERE = {"sphere": {"radius": 10.0}}
CELL = 0.06
"""Of the extent: trial grids are coarse."""


MOVED = LoadControl((False, False, False), (HERTZ.delta_z, 0.0, 0.0))
ASIDE = {"sphere": {"radius": 10.0, "center": [0.4, 0.0]}}
SLIM = {"ellipsoid": {"radius_x": 5.0, "radius_y": 30.0}}


@pytest.mark.parametrize(
    ("surface", "loads", "first", "half"),
    [
        *((SPHERE, [load()], first, (A, A)) for first in (1e-5, 1e4)),
        (SPHERE, [load(50.0), load(), load(0.0)], 1.0, (A, A)),  # the largest load counts
        (SPHERE, [MOVED], 1.0, (A, A)),
        (SPHERE, [load(my=LOAD * 0.2)], 1.0, (A + 0.2, A)),
        (ASIDE, [load()], 1.0, (A + 0.4, A)),  # off the centre it needs twice its distance
        (SLIM, [load()], 1.0, hertz_elliptic(LOAD, 5.0, 30.0, MATERIAL.contact_modulus).semi_axes),
        (
            {"cone": {"angle": 0.02}},
            [load()],
            1.0,
            (love_cone(LOAD, 0.02, MATERIAL.contact_modulus).contact_radius,) * 2,
        ),
        ({"punch": {"radius": 0.4}}, [load()], 1.0, (0.4, 0.4)),  # where everything ends the surface is the size
    ],
)
def test_size_holds_the_contact_with_a_margin(surface, loads, first, half):
    assert size(surface, *loads, first=first) == pytest.approx([2 * AREA_MARGIN * extent for extent in half], rel=CELL)


def test_nothing_pressed():
    with pytest.raises(CaseError, match="no contact"):
        size(SPHERE, load(0.0))
    with pytest.raises(CaseError, match="no contact"):
        size(SPHERE, LoadControl((False, False, False), (-1e-3, 0.0, 0.0)))


def test_a_sphere_has_its_closed_form():
    grid = set_up(build(grid={"points": [12, 24]}, load_path=[{"P": 100.0}, {"P": LOAD}, {"P": 50.0}])).grid
    assert grid.size == pytest.approx((2 * AREA_MARGIN * A,) * 2, rel=1e-12)
    assert (grid.nx, grid.ny) == (12, 24)


UNLIKE_BODIES = [{"young_modulus": 200e3, "poisson_ratio": 0.06}, {"young_modulus": 200e3, "poisson_ratio": 0.42}]


@pytest.mark.parametrize(
    ("friction", "moved"),
    [(3.0, {"Qx": 2.97 * LOAD}), (10.0, {"Qx": 6.0 * LOAD, "Qy": -6.0 * LOAD}), (10.0, {"delta_x": -0.05})],
)
def test_auto_holds_a_contact_that_shear_moves(friction, moved):
    """Friction above 1 on unlike bodies moves the contact by up to its own radius."""
    path = [{"P": LOAD, "increments": 1}, {**moved, "increments": 4}]
    case = build(bodies=UNLIKE_BODIES, friction=friction, grid={"points": 32}, load_path=path)
    states = list(run(case))
    assert len(states) == 5
    pressure = states[-1].fields.pressure
    assert not pressure[[0, -1]].any() and not pressure[:, [0, -1]].any()


@pytest.mark.parametrize(
    "parts",
    [
        {"bodies": DISSIMILAR, "friction": 0.3, "load_path": [{"P": 400.0}, {"Qx": 108.0, "increments": 2}]},
        {"surface": {"punch": {"radius": 0.5, "edge_radius": 0.4}}, "load_path": [{"P": 200.0}]},
        {"plane": "strain", "surface": {"cylinder": {"radius": 10.0, "axis": "y"}}, "load_path": [{"P": 200.0}]},
    ],
    ids=["sheared sphere", "rounded punch", "line contact"],
)
@pytest.mark.parametrize("points", [16, 30])
def test_auto_leaves_room_for_the_coarse_runs_of_error_bars(parts, points):
    without, with_bars = (
        set_up(build(**parts, grid={"points": points}, solver={"error_bars": asked})) for asked in (False, True)
    )
    wider = with_bars.grid.size[0] / without.grid.size[0]
    assert wider == pytest.approx({16: 8 / 6 / 1.2, 30: 10 / 8 / 1.2}[points])
    assert all(math.isfinite(state.errors.max_pressure_error) for state in run_with_error_bars(with_bars))
    assert room_for_coarse_runs(34) == room_for_coarse_runs(200) == 1.0
