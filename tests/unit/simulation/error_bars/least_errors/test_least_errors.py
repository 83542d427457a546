"""Least errors of single quantities; `tests/verification/test_bars_hold.py` compares bars with true errors."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from fake_states import fake_states
from line_cases import line_case
from solving import DISSIMILAR, SIMILAR, build

from fretsolve.case.history import Summary
from fretsolve.result.state import ESTIMATED
from fretsolve.setup.problem_setup import set_up
from fretsolve.simulation.error_bars.coarse_runs import values_of
from fretsolve.simulation.error_bars.error_bars import run_with_error_bars
from fretsolve.simulation.error_bars.least_errors.least_errors import DISSIPATED_FACETS, SHARP_TURN, LeastErrors
from fretsolve.simulation.error_bars.least_errors.zone_errors import CONTACT_EDGE, MAP_EDGE, SHARP_EDGE, ZoneErrors
from fretsolve.simulation.error_bars.quantity_estimates import DELTA_X, DELTA_Y, DELTA_Z, PHI_Y, TOTAL, room
from fretsolve.simulation.error_bars.shear_path import ShearPath
from fretsolve.simulation.simulation import run

ROUND = replace(
    next(fake_states(1)).summary,
    P=400.0,
    contact_radius=0.3,
    contact_half_width_x=0.3,
    contact_half_width_y=0.3,
    max_pressure=2000.0,
)


def least_errors(cell: tuple[float, float] = (0.03, 0.03), **parts: Any) -> LeastErrors:
    """Return those of a sphere on cells of these sides."""
    return replace(LeastErrors.of(set_up(build(grid={"points": 16}, **parts))), cell=cell)


def over_contact(cell: tuple[float, float], summary: Summary = ROUND, **parts: Any) -> np.ndarray:
    return least_errors(cell, **parts)._cells_over_contact(summary, summary.contact_radius)


def test_square_cells_in_a_round_contact_count_alike() -> None:
    assert over_contact((0.03, 0.03)) == pytest.approx(np.full(len(ESTIMATED), 0.01), rel=1e-12)


def test_slender_cells_count_by_their_extent_across_the_edge() -> None:
    """Against the mean over the edge of dx^2 cos^2 + dy^2 sin^2, for moments and tilts with the square of the lever."""
    angles = np.linspace(0.0, 2.0 * np.pi, 1000, endpoint=False)
    across = (0.06 * np.cos(angles)) ** 2 + (0.006 * np.sin(angles)) ** 2
    levers = {"My": np.cos(angles) ** 2, "phi_y": np.cos(angles) ** 2, "Mx": np.sin(angles) ** 2}
    found = over_contact((0.06, 0.006))
    for name in ("delta_z", "Mz", "work_total", *levers):
        mean = np.average(across, weights=levers.get(name)) / 0.3**2
        assert found[ESTIMATED.index(name)] == pytest.approx(mean, rel=1e-9)


def test_an_ellipse_on_cells_as_slender_counts_like_a_circle() -> None:
    ellipse = replace(ROUND, contact_half_width_x=0.6, contact_half_width_y=0.15)
    assert over_contact((0.06, 0.015), ellipse) == pytest.approx(over_contact((0.03, 0.03)), rel=1e-12)
    assert over_contact((0.015, 0.06), ellipse)[DELTA_Z] > 3.5 * over_contact((0.015, 0.06))[DELTA_Z]


def test_cells_count_as_the_contact_at_most() -> None:
    assert over_contact((0.5, 0.5)).tolist() == [1.0] * len(ESTIMATED)
    opened = least_errors()._cells_over_contact(ROUND, 0.0)
    assert opened.tolist() == [1.0] * len(ESTIMATED)
    open_now = replace(ROUND, contact_half_width_x=0.0, contact_half_width_y=0.0)
    assert over_contact((0.03, 0.03), open_now) == pytest.approx(over_contact((0.03, 0.03)), rel=1e-12)


def test_a_line_contact_counts_its_cells_across() -> None:
    least = LeastErrors.of(set_up(line_case()))
    summary = replace(ROUND, contact_half_width_y=5.0)  # half of a length of the axis that is unlike its cells
    assert least._cells_over_contact(summary, 0.3) == pytest.approx(np.full(len(ESTIMATED), (least.side / 0.3) ** 2))


@pytest.mark.parametrize(
    ("width", "like", "unlike", "line"),
    [
        (0.1, 0.12 / 0.25, 0.22 * math.sqrt(0.1) / 0.125, 1.2),
        (0.6, 0.2, 0.2, 0.3 / 0.6**1.5),
        (1.4, 0.12 / 1.4, 0.12 / 1.4, 0.3 / 1.4**1.5),
        (4.0, 0.12 * math.sqrt(0.1) / 8.0, 0.22 * math.sqrt(0.1) / 8.0, 0.0375),
    ],
)
def test_energy_is_less_certain_the_thinner_the_annulus(width: float, like: float, unlike: float, line: float) -> None:
    """Over that of the increment; width: in cells. In an annulus of 0.25 cells it is that of 0.25 cells."""
    sheared = replace(ROUND, Qx=100.0, work=1e-3, stick_radius=0.3 - 0.03 * width)
    of_line = replace(LeastErrors.of(set_up(line_case())), cell=(0.03, 0.03))
    for bodies, area in ((SIMILAR, like), (DISSIMILAR, unlike)):
        least = least_errors(friction=0.3, bodies=bodies)
        assert least.energy_at_edge(sheared, 4) == pytest.approx(1e-3 * area, rel=1e-9)
        assert least.energy_at_edge(sheared, 2) == pytest.approx(1e-3 * unlike, rel=1e-9)
    assert of_line.energy_at_edge(sheared, 4) == pytest.approx(1e-3 * line, rel=1e-9)
    assert of_line.energy_at_edge(replace(sheared, stick_radius=0.0), 4) == 0.0


@pytest.mark.parametrize(("friction", "sheared"), [(0.05, 0.05), (0.9, None)])
def test_pressing_unlike_bodies_moves_them_sideways_by_errors_of_the_cells(
    friction: float, sheared: float | None
) -> None:
    """By a part of what friction or, if that is less, their mismatch shears of them; like bodies not at all."""
    path = [{"P": 400.0, "increments": 2}]
    for bodies in (SIMILAR, DISSIMILAR):
        setup = set_up(build(grid={"points": 16}, friction=friction, bodies=bodies, load_path=path))
        *_, state = run(setup)
        largest = np.abs(values_of(state.summary))
        least = LeastErrors.of(setup).values(state, largest, ShearPath())[[DELTA_X, DELTA_Y]]
        if bodies is SIMILAR:
            assert least == pytest.approx(0.0, abs=1e-12)
            continue
        pair, radius = setup.model.compliances, state.summary.contact_radius
        part = sheared if sheared is not None else abs(pair.dundurs_constant)
        pressed = part * 400.0 / (pair.contact_modulus * radius)
        assert least == pytest.approx(0.3 * (setup.grid.dx / radius) ** 2 * pressed, rel=1e-2)


def test_a_parted_body_is_not_pressed_sideways() -> None:
    """An approach may have an offset, or be a gap; the load has none."""
    least, unlike = np.zeros(len(ESTIMATED)), least_errors(friction=0.3, bodies=DISSIMILAR)
    largest = np.zeros(len(ESTIMATED))
    largest[DELTA_Z] = 0.2
    unlike._add_pressed_sideways(least, largest, np.full(len(ESTIMATED), 0.01))
    assert not least.any()


def test_slip_within_a_rounding_counts_under_the_load_of_its_way() -> None:
    """Unloading after a shear keeps what has been dissipated; a larger load before any shear dissipates nothing."""
    punch = {"surface": {"punch": {"radius": 0.5, "edge_radius": 0.01}}, "grid": {"points": 40, "size": 1.2}}
    bars = []
    for path in (
        [{"P": 300.0}, {"Qx": 9.0}],
        [{"P": 300.0}, {"Qx": 9.0}, {"P": 150.0}],
        [{"P": 3000.0}, {"P": 300.0}, {"Qx": 9.0}],
    ):
        stages = [{**stage, "increments": 1} for stage in path]
        *_, last = run_with_error_bars(build(**punch, friction=0.3, load_path=stages))
        assert last.errors is not None and last.summary.work_total == 0.0
        bars.append(last.errors.work_total_error)
    sheared, unloaded, relieved = bars
    assert relieved == pytest.approx(sheared, rel=0.05)
    # as much way again by the unloading, and the square of the larger share
    assert unloaded == pytest.approx(2.0 * 2.0**2 * sheared, rel=0.05)


def test_energies_that_no_grid_shows_add_up_as_independent_errors() -> None:
    """Those by the cells, and of an annulus that is sheared and thinner than them, each known alone."""
    least, state = least_errors(friction=0.3), next(fake_states(1))
    summary = replace(ROUND, work=1e-3, work_total=2e-3, stick_radius=0.3)
    state, path = replace(state, summary=summary), ShearPath(largest=0.01, way=(0.01, 0.0, 0.0), length=0.01)
    _, shown = least._dissipated(state, 0.25, ShearPath(), least._unseen_slip)
    _, unseen = least._dissipated(state, 0.0, path, least._unseen_slip)
    assert shown == pytest.approx(0.25 * 2e-3, rel=1e-12)
    assert unseen > 0.0
    _, both = least._dissipated(state, 0.25, path, least._unseen_slip)
    assert both == pytest.approx(math.hypot(shown, unseen), rel=1e-12)


def test_energy_on_facets_of_a_map_is_less_certain_by_the_first_power_of_the_cells() -> None:
    least, state = least_errors(friction=0.3), next(fake_states(1))
    state = replace(state, summary=replace(ROUND, work=1e-3, work_total=2e-3, stick_radius=0.3))
    largest = np.zeros(len(ESTIMATED))
    smooth, facets = (replace(least, ridges=ridges).values(state, largest, ShearPath())[TOTAL] for ridges in (0.0, 1.0))
    assert smooth < facets == pytest.approx(math.hypot(smooth, DISSIPATED_FACETS * 0.1 * 2e-3), rel=1e-9)


def test_the_edge_of_a_contact_on_a_height_map_is_less_certain() -> None:
    least = least_errors()
    plain, on_map = (
        ZoneErrors(least.model, 0.03, False, True, maps, least._unseen_slip)._contact_radius(ROUND, 0.0)
        for maps in (False, True)
    )
    assert plain == pytest.approx(room(least.model) * CONTACT_EDGE * 0.03, rel=0.01)
    assert on_map == pytest.approx(room(least.model) * MAP_EDGE * 0.03, rel=0.01)


@pytest.mark.parametrize(
    ("seen", "area", "line"),
    [(0.0, 0.26, 0.6), (1.0, 0.26, 0.6), (2.0, 0.26, 0.15), (4.0, 0.065, 0.0375), (math.inf, 0.0, 0.0)],
)
def test_the_edge_at_a_rounding_is_known_better_over_more_cells(seen: float, area: float, line: float) -> None:
    on_line = replace(LeastErrors.of(set_up(line_case())), cell=(0.03, 0.03))
    for least, part in ((least_errors(), area), (on_line, line)):
        assert least._outline(ROUND, seen) == pytest.approx(part * 0.03, rel=1e-12)


def test_a_punch_that_is_tilted_on_a_rounding_of_some_cells_turns_less_surely() -> None:
    case = build(
        surface={"punch": {"radius": 0.5, "edge_radius": 0.3}},
        friction=0.0,
        grid={"points": 41, "size": 1.2},
        load_path=[{"P": 1500.0, "My": 20.0}],
    )
    setup = set_up(case)
    state, least = next(run(setup)), LeastErrors.of(setup)
    seen, largest = least._cells_of_roundings(state), np.abs(values_of(state.summary))
    assert 1.0 < seen < 3.0
    found, without = (one.values(state, largest, ShearPath())[PHI_Y] for one in (least, replace(least, edges=())))
    part = SHARP_TURN * SHARP_EDGE * least.side / state.summary.contact_radius * min(2.0 / seen, 1.0) ** 2
    assert found == pytest.approx(math.hypot(without, part * largest[PHI_Y]), rel=1e-9)


def test_line_contacts_that_end_at_holes_know_the_energy_of_their_annuli_less() -> None:
    least = replace(LeastErrors.of(set_up(line_case())), cell=(0.03, 0.03))
    state = next(fake_states(1))
    state = replace(state, summary=replace(state.summary, work=2e-6, work_total=2e-5))
    path = replace(ShearPath(), last_at_edge=1e-6, at_edge=2e-6)
    found = [least._dissipated(state, 0.0, path, replace(least._unseen_slip, holes=holes)) for holes in (False, True)]
    assert found[0] == pytest.approx([1e-6, 2e-6])
    assert found[1] == pytest.approx([1.2 * 2e-6, 6e-6])  # all that the increment dissipates, at most


@pytest.mark.parametrize("missed", [0.0, 0.05])
def test_a_sharp_outline_makes_energies_uncertain(missed: float) -> None:
    least = replace(least_errors(), missed=missed)
    found, largest = np.zeros(len(ESTIMATED)), np.ones(len(ESTIMATED))
    least._add_sharp_outline(found, largest, 0.01)
    assert found[TOTAL] == pytest.approx(math.hypot(0.01, missed))
