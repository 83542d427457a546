"""Slip that no cell shows, in the last increment and in all."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
import solving
from line_cases import FRICTION as LINE_FRICTION
from line_cases import HERTZ, line_case
from line_cases import LOAD as LINE_LOAD
from solving import DISSIMILAR, RIGID, build

from fretsolve import run
from fretsolve.reference.hertz import hertz_sphere
from fretsolve.reference.tangential import cattaneo_mindlin
from fretsolve.setup.problem_setup import set_up
from fretsolve.simulation.error_bars.least_errors.least_errors import LeastErrors
from fretsolve.simulation.error_bars.least_errors.unseen_slip import UnseenSlip
from fretsolve.simulation.error_bars.shear_path import PRESSED_ORDER, ShearPath

MODEL = set_up(build(bodies=DISSIMILAR, friction=0.3, grid={"points": 16})).model


def sphere(load: float) -> Any:
    """What `UnseenSlip` reads of the summary of a sphere under `load`."""
    hertz = hertz_sphere(load, 10.0, MODEL.compliances.contact_modulus)
    return cast(Any, SimpleNamespace(contact_radius=hertz.contact_radius, max_pressure=hertz.max_pressure, P=load))


def unseen(side: float) -> UnseenSlip:
    return UnseenSlip(MODEL, side, slender=1.0, ends=False, edges=())


def test_increments_dissipate_together_what_all_do() -> None:
    loads = [sphere(100.0 * (1 + place)) for place in range(5)]
    parts, totals = zip(
        *(unseen(1.0).energies_of_annulus(now, before) for now, before in zip(loads, [None, *loads], strict=False)),
        strict=True,
    )
    assert sum(parts) == pytest.approx(totals[-1])
    assert totals[-1] == pytest.approx(totals[0] * 5.0 ** (5.0 / 3.0))
    assert list(parts) == sorted(parts) and parts[0] > 0.0


def test_an_increment_that_presses_no_further_dissipates_nothing() -> None:
    for before in (sphere(400.0), sphere(500.0)):
        last, total = unseen(1.0).energies_of_annulus(sphere(400.0), before)
        assert last == 0.0
        assert total == unseen(1.0).energies_of_annulus(before, None)[1] > 0.0


@pytest.mark.parametrize("edge", [0.0, 1.6e-3])
@pytest.mark.parametrize("friction", [0.15, 0.2])
def test_a_flat_punch_dissipates_what_its_edge_lets_expect(friction: float, edge: float) -> None:
    """On cells that resolve the annulus; with some that do not, the bar holds it."""
    energies, bars = [], []
    for points in (24, 128):
        case = build(
            bodies=[{"young_modulus": 3900.0, "poisson_ratio": 0.13}, {"young_modulus": 3900.0, "poisson_ratio": 0.43}],
            surface={"punch": {"radius": 0.273, **({"edge_radius": edge} if edge else {})}},
            friction=friction,
            grid={"points": points, "size": 0.9},
            load_path=[{"P": 221.2, "increments": 4}],
        )
        *_, last = run(case)
        energies.append(last.summary.work_total)
        bars.append(UnseenSlip(set_up(case).model, 1.0, 1.0, True, (), flat=1.0))
    expected = bars[1]._energy_of_annulus(replace(last.summary, max_pressure=0.0))
    assert 0.7 * expected < energies[1] < expected
    assert abs(energies[0] - energies[1]) < expected


def test_an_annulus_that_cells_resolve_is_not_unseen() -> None:
    width = unseen(1.0).annulus(sphere(400.0))
    assert 0.0 < width < sphere(400.0).contact_radius
    assert unseen(width / 1.6).annulus(sphere(400.0)) == 0.0
    assert not unseen(width / 1.6).energies_of_annulus(sphere(400.0), None).any()


@pytest.mark.parametrize("share", [0.02, 0.1, 0.3])
def test_shear_slips_in_a_thin_annulus_as_cattaneo_and_mindlin_say(share: float) -> None:
    model = set_up(build(friction=0.3, grid={"points": 16})).model
    pressed = sphere(400.0)
    hertz = hertz_sphere(400.0, 10.0, model.compliances.contact_modulus)
    pressed.contact_radius = hertz.contact_radius
    exact = cattaneo_mindlin(hertz, 0.3, share * 120.0, model.compliances.tangential)
    slip = UnseenSlip(model, hertz.contact_radius, slender=1.0, ends=False, edges=())
    assert slip.sheared_annulus(pressed, share) == pytest.approx(hertz.contact_radius - exact.stick_radius)
    first, cycle = slip.energies_of_shear(pressed, share, np.array([share, 4.0 * share]))
    assert first == pytest.approx(exact.work_per_cycle / 4.0, rel=0.02)
    assert cycle == pytest.approx(exact.work_per_cycle, rel=0.02)
    resolved = replace(slip, side=1e-3 * hertz.contact_radius)
    assert resolved.sheared_annulus(pressed, share) == 0.0
    assert not resolved.energies_of_shear(pressed, share, np.array([share, share])).any()
    assert replace(slip, ends=True).sheared_annulus(pressed, share) == 0.0


@pytest.mark.parametrize("points", [20, 24, 32, 33])
@pytest.mark.parametrize("share", [0.05, 0.1, 0.15, 0.2, 0.3])
def test_cells_miss_less_of_a_wider_annulus(points: int, share: float) -> None:
    """All of it up to 0.28 h, and then a part that falls with the width."""
    force = share * solving.FRICTION * solving.LOAD
    path = [{"P": solving.LOAD}, {"Qx": force, "increments": 4}]
    setup = set_up(build(grid={"points": points, "size": 0.74}, coupling="none", load_path=path))
    *_, last = run(setup)
    exact = cattaneo_mindlin(solving.HERTZ, solving.FRICTION, force, solving.MATERIAL.tangential)
    energy, width = exact.work_per_cycle / 4.0, solving.A - exact.stick_radius
    slip = UnseenSlip(setup.model, setup.grid.dx, slender=1.0, ends=False, edges=())
    (missed,) = slip.energies_of_shear(last.summary, share, np.array([share]))
    if width < 1.5 * setup.grid.dx:
        assert missed == pytest.approx(min((0.28 * setup.grid.dx / width) ** 1.5, 1.0) * energy, rel=0.05)
        assert abs(last.summary.work_total - energy) <= 1.01 * missed
    else:
        assert missed == 0.0
        assert last.summary.work_total == pytest.approx(energy, rel=0.05)


@pytest.mark.parametrize("cells", [10.0, 16.4, 22.7, 40.6])
@pytest.mark.parametrize("width", [0.4, 0.9, 1.2, 1.4])
def test_line_contacts_miss_more_of_a_thin_annulus(cells: float, width: float) -> None:
    """Both edges lie alike in their cells, which may miss all of an annulus of 1 h. width: in cells."""
    share = 1.0 - (1.0 - width / cells) ** 2
    side = HERTZ.half_width / cells
    points = 2 * math.ceil(1.2 * cells) + 2
    path = [{"P": LINE_LOAD}, {"Qx": share * LINE_FRICTION * LINE_LOAD, "increments": 1}]
    setup = set_up(line_case(grid={"points": points, "size": points * side}, load_path=path))
    *_, last = run(setup)
    slip = UnseenSlip(setup.model, side, slender=1.0, ends=False, edges=())
    (missed,) = slip.energies_of_shear(last.summary, share, np.array([share]))
    # cells much longer than the annulus miss all of it
    (energy,) = replace(slip, side=10.0 * side).energies_of_shear(last.summary, share, np.array([share]))
    assert missed == pytest.approx(min(width**-1.5, 1.0) * energy, rel=0.01)
    assert energy - last.summary.work_total <= 1.01 * missed


@pytest.mark.parametrize("share", [0.02, 0.1])
def test_shear_slips_at_the_edges_of_a_line_contact(share: float) -> None:
    """Against the integral of mu p times the slip, whose gradient is (2 mu p0/a E*) (x^2 - c^2)^(1/2)."""
    model = set_up(line_case()).model
    modulus, a = HERTZ.contact_modulus, HERTZ.half_width
    c = a * math.sqrt(1.0 - share)
    x = c + (a - c) * (1.0 - np.cos(np.linspace(0.0, np.pi, 4001))) / 2.0  # fine at both ends
    gradient = 2.0 * LINE_FRICTION * HERTZ.max_pressure / (a * modulus) * np.sqrt(x**2 - c**2)
    slips = np.concatenate([[0.0], np.cumsum(0.5 * (gradient[1:] + gradient[:-1]) * np.diff(x))])
    exact = 2.0 * np.trapezoid(
        LINE_FRICTION * HERTZ.max_pressure * np.sqrt(np.maximum(1.0 - (x / a) ** 2, 0.0)) * slips, x
    )
    pressed = cast(Any, SimpleNamespace(contact_radius=a, max_pressure=HERTZ.max_pressure, P=LINE_LOAD))
    slip = UnseenSlip(model, a, slender=1.0, ends=False, edges=())
    assert slip.sheared_annulus(pressed, share) == pytest.approx(a - c)
    (first,) = slip.energies_of_shear(pressed, share, np.array([share]))
    assert first == pytest.approx(exact, rel=0.05)


def beyond(
    share: float, friction: float = 0.6, shears: float = 1.0, loads: tuple[float, float] = (100.0, 100.0)
) -> list[float]:
    """Return what slip beyond a rounding dissipates that no cell sees, in the last of some shears and in all.

    loads: while it is sheared, and now; pressing alone shears to 0.1 of the friction limit.
    """
    sheared, now = loads
    case = build(
        bodies=RIGID,
        surface={"punch": {"radius": 0.5, "edge_radius": 1e-4}},
        friction=friction,
        grid={"points": 24, "size": 1.4},
        load_path=[{"P": now, "increments": 1}],
    )
    *_, last = run(case)
    way = share * sheared**PRESSED_ORDER
    path = ShearPath(farthest=share, last_pressed=way, pressed=shears * way, now=last.summary)
    found: list[float] = LeastErrors.of(set_up(case))._unseen_slip.beyond_roundings(last, 0.1, path).tolist()
    return found


@pytest.mark.parametrize(("share", "friction", "found"), [(0.3, 0.6, True), (0.9, 0.6, False), (0.3, 30.0, False)])
def test_slip_of_unlike_bodies_goes_beyond_a_rounding_where_cells_do_not_see_it(
    share: float, friction: float, found: bool
) -> None:
    """Gross slip goes beyond the cell. Under much friction slip stays within the rounding."""
    assert all(energy > 0.0 for energy in beyond(share, friction)) is found


def test_each_shear_dissipates_as_much_beyond_a_rounding() -> None:
    last, whole = beyond(0.3)
    assert last == pytest.approx(whole)
    assert beyond(0.3, shears=3.0) == pytest.approx([last, 3.0 * whole])
    assert beyond(1e-12) == [0.0, 0.0]  # by a rounding of the loads
    assert beyond(2e-3)[1] < 0.01 * whole
    assert beyond(0.3, loads=(100.0, 10.0))[1] > 0.9 * whole  # a load that falls undoes no energy
