"""Slip that no cell shows, in the last increment and in all."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import pytest
from solving import DISSIMILAR, build

from fretsolve import run
from fretsolve.reference.hertz import hertz_sphere
from fretsolve.setup.problem_setup import set_up
from fretsolve.simulation.unseen_slip import UnseenSlip

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
        bars.append(UnseenSlip(set_up(case).model, 1.0, 1.0, True, (), flat=True))
    expected = bars[1]._energy_of_annulus(replace(last.summary, max_pressure=0.0))
    assert 0.7 * expected < energies[1] < expected
    assert abs(energies[0] - energies[1]) < expected


def test_an_annulus_that_cells_resolve_is_not_unseen() -> None:
    width = unseen(1.0).annulus(sphere(400.0))
    assert 0.0 < width < sphere(400.0).contact_radius
    assert unseen(width / 1.6).annulus(sphere(400.0)) == 0.0
    assert not unseen(width / 1.6).energies_of_annulus(sphere(400.0), None).any()
