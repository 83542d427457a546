"""Least errors of the zones; `tests/verification/test_bars_hold.py` compares bars with true errors."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from line_cases import HERTZ as LINE_HERTZ
from line_cases import LOAD, SHEAR_FORCE, line_case
from solving import DISSIMILAR, SIMILAR, build

from fretsolve.result.state import ESTIMATED, State, Zone
from fretsolve.setup.problem_setup import ProblemSetup, set_up
from fretsolve.simulation.error_bars.error_bars import run_with_error_bars
from fretsolve.simulation.error_bars.least_errors.least_errors import LeastErrors
from fretsolve.simulation.error_bars.least_errors.zone_errors import (
    AT_LIMIT,
    BELOW_LARGEST,
    CONTACT_EDGE,
    EARLIER_EDGE,
    FEW_STICK,
    FEW_STICK_LIKE,
    HELD_EDGE,
    OPENED_STICK,
    UNLIKE_EDGE,
    ZoneErrors,
)
from fretsolve.simulation.error_bars.quantity_estimates import CONTACT, STICK, STICK_EXTENTS, room
from fretsolve.simulation.error_bars.shear_path import ShearPath, StickEdges
from fretsolve.simulation.simulation import run

PATH = [{"P": 400.0}, {"Qx": 20.0, "increments": 1}]
VARIED: dict[str, Any] = {
    "grid": {"points": 24},
    "load_path": PATH,
    "friction": {"coefficient": 0.1, "shear_limit": 300.0},
}


@pytest.fixture(scope="module")
def sheared() -> tuple[ProblemSetup, State]:
    setup = set_up(build(grid={"points": 24}, load_path=PATH))
    return setup, list(run(setup))[-1]


MOVES_ON = ShearPath(at=(0.6, 0.0, 0.0), way=(0.6, 0.0, 0.0))


def stick_errors(setup: ProblemSetup, state: State, path: ShearPath = MOVES_ON) -> tuple[float, float]:
    """Return the least errors of the stick radius and of the stick zone's half-widths."""
    least = LeastErrors.of(setup).values(state, np.ones(len(ESTIMATED)), path)
    return float(least[STICK]), float(least[STICK_EXTENTS].min())


@pytest.mark.parametrize(
    ("apart", "largest", "added"),
    [(0.1, 0.8, EARLIER_EDGE), (-1.1, 0.8, EARLIER_EDGE), (1.3, 0.8, BELOW_LARGEST), (0.1, 0.5, 0.0)],
)
def test_an_earlier_edge_of_the_stick_zone_beside_it(
    sheared: tuple[ProblemSetup, State], apart: float, largest: float, added: float
) -> None:
    """Like bodies' stick radii within BESIDE cells of an earlier one and others, unless the shear is at its largest."""
    setup, state = sheared
    assert not setup.model.coupled
    path = ShearPath(at=(0.5, 0.0, 0.0), largest=largest)
    path = replace(path, edges=StickEdges(smallest=state.summary.stick_radius - apart * setup.grid.dx))
    found, without = (
        float(LeastErrors.of(setup).values(state, np.ones(len(ESTIMATED)), one)[STICK])
        for one in (path, ShearPath(at=(0.5, 0.0, 0.0), largest=0.5))
    )
    assert found == pytest.approx(math.hypot(without, added * setup.grid.dx), rel=1e-9)
    turned = replace(path, edges=StickEdges(turned=path.edges.smallest))
    assert LeastErrors.of(setup).values(state, np.ones(len(ESTIMATED)), turned)[STICK] == found


@pytest.mark.parametrize("back", [17.6, 20.0, 22.5])
def test_an_annulus_that_a_turn_makes_is_seen_as_one(back: float) -> None:
    """A force taken back a little slips in an annulus thinner than a cell, in which all cells may stick."""
    path = [{"P": 100.0}, {"Qx": 24.0, "increments": 3}, {"Qx": back, "increments": 4}]
    case = line_case(grid={"points": 24, "size": 2.2 * LINE_HERTZ.half_width}, load_path=path)
    *_, last = run_with_error_bars(case)
    assert last.errors is not None
    exact = LINE_HERTZ.half_width * math.sqrt(1.0 - 0.5 * (24.0 - back) / 30.0)
    assert abs(last.summary.stick_radius - exact) <= last.errors.stick_radius_error < 0.1 * exact


def test_the_edge_of_like_bodies_is_known_better(sheared: tuple[ProblemSetup, State]) -> None:
    """Than that of unlike ones, and than where friction varies."""
    setup, state = sheared
    unlike = set_up(build(bodies=DISSIMILAR, grid={"points": 24}, load_path=PATH))
    assert unlike.model.coupled
    for other in (unlike, replace(setup, case=build(**VARIED))):
        assert stick_errors(other, state)[0] > 1.5 * stick_errors(setup, state)[0]


@pytest.mark.parametrize(("bodies", "least"), [(SIMILAR, FEW_STICK_LIKE), (DISSIMILAR, FEW_STICK)])
def test_the_edge_of_a_stick_zone_of_few_cells(bodies: Any, least: float) -> None:
    """It goes with h^2/c of its radius c, and no more once that is less than a cell; all else does not depend on c."""
    setup = set_up(build(bodies=bodies, grid={"points": 24}, load_path=PATH))
    *_, state = run(setup)
    side = setup.grid.dx
    radii = (0.4, 0.8, 2.0, 4.0)
    summaries = [replace(state.summary, stick_radius=cells * side) for cells in radii]
    smallest, small, few, more = (stick_errors(setup, replace(state, summary=one))[0] ** 2 for one in summaries)
    assert smallest == pytest.approx(small, rel=1e-12)
    assert small - few == pytest.approx((least * side) ** 2 * (1.0 - 1.0 / 4.0), rel=1e-6)
    assert few - more == pytest.approx((least * side) ** 2 * (1.0 / 4.0 - 1.0 / 16.0), rel=1e-6)


def with_shear_in(state: State, cells: Any, share: float, friction: float) -> State:
    """Return the state with so much of the friction limit in some of its cells."""
    shear = state.fields.shear.copy()
    shear[0][cells], shear[1][cells] = share * friction * state.fields.pressure[cells], 0.0
    return replace(state, fields=replace(state.fields, shear=shear))


def test_cells_that_stick_at_the_friction_limit_may_slip(sheared: tuple[ProblemSetup, State]) -> None:
    setup, state = sheared
    friction, sticks = setup.model.friction, state.fields.zone == Zone.STICK
    below = with_shear_in(state, sticks, 0.5, friction)
    rows = sticks & (setup.grid.y[None, :] > 0.0)
    held = np.count_nonzero(rows) / np.count_nonzero(sticks)
    assert 0.3 < held < 0.7
    at_limit = with_shear_in(below, rows, 1.0 - 0.9 * AT_LIMIT, friction)
    before, after = stick_errors(setup, below), stick_errors(setup, at_limit)
    added = room(setup.model) * (1.0 - math.sqrt(1.0 - held)) * state.summary.stick_radius
    assert after[0] == pytest.approx(before[0] + added + HELD_EDGE * setup.grid.dx, rel=1e-12)
    assert after[1] >= after[0]
    assert stick_errors(setup, with_shear_in(below, rows, 1.0 - 1.1 * AT_LIMIT, friction)) == before


def test_half_widths_are_uncertain_down_to_the_cells_that_surely_stick(sheared: tuple[ProblemSetup, State]) -> None:
    """Few cells at the limit add little to the radius, but all of their distance to the half-width."""
    setup, state = sheared
    sticks = state.fields.zone == Zone.STICK
    columns = np.flatnonzero(sticks.any(axis=1))
    middle = np.abs(np.arange(len(sticks)) - 0.5 * (columns[0] + columns[-1])) < 1.5
    below = with_shear_in(state, sticks, 0.5, setup.model.friction)
    held = with_shear_in(below, sticks & ~middle[:, None], 1.0, setup.model.friction)
    outside = columns[-1] - columns[0] + 1 - np.count_nonzero(middle)
    assert stick_errors(setup, held)[1] >= 0.5 * outside * setup.grid.dx > stick_errors(setup, below)[1]


@pytest.mark.parametrize("way", [0.0, -0.1])
def test_cells_at_the_limit_stick_where_the_shear_is_held_or_goes_back(
    sheared: tuple[ProblemSetup, State], way: float
) -> None:
    setup, state = sheared
    held = with_shear_in(state, state.fields.zone == Zone.STICK, 1.0, setup.model.friction)
    assert stick_errors(setup, held)[0] > 0.99 * state.summary.stick_radius
    assert stick_errors(setup, held, replace(MOVES_ON, way=(way, 0.0, 0.0)))[0] < 0.1 * state.summary.stick_radius


def test_cells_that_slip_add_nothing(sheared: tuple[ProblemSetup, State]) -> None:
    setup, state = sheared
    slips = state.fields.zone == Zone.SLIP
    assert slips.any()
    less = with_shear_in(state, slips, 0.5, setup.model.friction)
    assert stick_errors(setup, less) == stick_errors(setup, state)


def test_cells_at_the_limit_of_friction_that_varies_are_not_asked_for(sheared: tuple[ProblemSetup, State]) -> None:
    setup, state = sheared
    varied = replace(setup, case=build(**VARIED))
    held = with_shear_in(state, state.fields.zone == Zone.STICK, 1.0, setup.model.friction)
    assert stick_errors(setup, held)[0] > 0.99 * state.summary.stick_radius
    assert stick_errors(varied, held)[0] < 0.1 * state.summary.stick_radius


def test_part_of_a_line_contact_at_the_friction_limit() -> None:
    path = [{"P": LOAD}, {"Qx": 0.25 * SHEAR_FORCE, "increments": 1}]
    setup = set_up(line_case(grid={"points": 64}, load_path=path))
    *_, state = run(setup)
    friction, sticks = setup.model.friction, state.fields.zone == Zone.STICK
    half = sticks & (setup.grid.x[:, None] > 0.0)
    share = np.count_nonzero(half) / np.count_nonzero(sticks)
    below = with_shear_in(state, sticks, 0.5, friction)
    before, after = (stick_errors(setup, one)[0] for one in (below, with_shear_in(below, half, 1.0, friction)))
    added = share * state.summary.stick_radius
    assert after == pytest.approx(before + added + HELD_EDGE * setup.grid.dx, rel=1e-12)


@pytest.mark.parametrize(("cells", "least"), [(0.5, 0.4), (1.5, 0.4), (2.0, 0.4 * 0.75**4), (6.0, 0.0)])
def test_radii_of_few_cells(sheared: tuple[ProblemSetup, State], cells: float, least: float) -> None:
    setup, state = sheared
    side = setup.grid.dx
    small = replace(state, summary=replace(state.summary, contact_radius=cells * side))
    found = LeastErrors.of(setup).values(small, np.ones(len(ESTIMATED)), ShearPath())[CONTACT]
    assert found == pytest.approx(side * math.hypot(least, room(setup.model) * CONTACT_EDGE), rel=0.1)


def test_the_contact_radius_of_unlike_bodies_in_line_contact_is_less_certain_the_more_friction_there_is() -> None:
    path = [{"P": LOAD, "increments": 1}]
    for friction in (0.1, 1.0):
        radii = []
        for bodies in (SIMILAR, DISSIMILAR):
            setup = set_up(line_case(bodies=bodies, friction=friction, load_path=path))
            (state,) = run(setup)
            radii.append(LeastErrors.of(setup).values(state, np.ones(len(ESTIMATED)), MOVES_ON)[CONTACT])
        order = math.atan(abs(setup.model.compliances.dundurs_constant) * friction) / math.pi
        few = radii[0] ** 2 - (CONTACT_EDGE * setup.grid.dx) ** 2  # hardly anything on so many cells
        assert few < 1e-2 * radii[0] ** 2
        assert radii[1] == pytest.approx(math.hypot(radii[0], UNLIKE_EDGE * order * setup.grid.dx), rel=1e-2)
        assert radii[1] > (3.0 if friction == 1.0 else 1.05) * radii[0]


@pytest.mark.parametrize(
    ("bodies", "friction", "opened"), [(DISSIMILAR, 0.02, OPENED_STICK), (DISSIMILAR, 0.3, 0.0), (SIMILAR, 0.02, 0.0)]
)
def test_a_stick_zone_that_shear_opens_between_unlike_bodies(bodies: Any, friction: float, opened: float) -> None:
    """Under P alone it would fill less than a cell of a line contact with little friction."""
    path = [{"P": LOAD, "increments": 2}, {"Qx": 0.7 * friction * LOAD, "increments": 4}]
    setup = set_up(line_case(bodies=bodies, friction=friction, load_path=path, grid={"points": 32}))
    *_, state = run(setup)
    least = LeastErrors.of(setup)
    zones = ZoneErrors(setup.model, setup.grid.dx, False, True, False, least._unseen_slip)
    sheared = ShearPath(length=0.7)
    assert zones._opened(state.summary, sheared) == opened * setup.grid.dx
    assert zones._opened(state.summary, ShearPath()) == 0.0  # pressed alone
    assert least.values(state, np.ones(len(ESTIMATED)), sheared)[STICK] > opened * setup.grid.dx


@pytest.mark.parametrize(
    ("pressures", "doubtful"),
    [
        ([0.0, 5.0, 9.0, 5.0, 0.0], None),  # one peak
        ([2.0, 9.0, 4.0, 9.0, 2.0], 0),
        ([2.0, 9.0, 0.2, 9.0, 2.0], 1),  # a trough of 2 % of the largest pressure
        ([2.0, 9.0, 0.2, 9.0, 0.2, 9.0, 3.0], 2),
    ],
)
def test_troughs_between_waves_may_be_open(pressures: list[float], doubtful: int | None) -> None:
    assert waves_of(pressures) == pytest.approx(
        0.0 if doubtful is None else math.hypot(0.06, 0.5 * math.sqrt(doubtful))
    )


PART = [2.0, 9.0, 9.0, 9.0, 9.0, 2.0]
"""Too long to have an error of its own."""


def test_gaps_of_few_cells_between_waves_may_be_closed() -> None:
    narrow, wide = (waves_of([*PART, *[0.0] * gap, *PART]) for gap in (2, 3))
    assert narrow == pytest.approx(math.hypot(wide, 0.5))


def test_holes_between_waves_stay_open() -> None:
    pressures = [*PART, 0.0, *PART]
    assert waves_of(pressures, hole=6) == pytest.approx(waves_of([*PART, *[0.0] * 3, *PART]))


def test_a_wave_that_hardly_touches_may_not() -> None:
    strong, faint = (waves_of([*PART, *[0.0] * 3, peak, peak, peak]) for peak in (5.0, 0.2))
    assert faint == pytest.approx(math.hypot(strong, 0.5))


def waves_of(pressures: list[float], hole: int | None = None) -> float:
    """Return the least error of the outline of a line contact on a height map with these pressures, in cells."""
    least = LeastErrors.of(set_up(line_case()))
    zones = ZoneErrors(least.model, 1.0, False, True, True, least._unseen_slip)
    gap = np.zeros((len(pressures), 1))
    if hole is not None:
        gap[hole] = np.nan
    fields = SimpleNamespace(pressure=np.array(pressures)[:, None], gap=gap)
    return zones._waves(cast(Any, SimpleNamespace(fields=fields)))
