"""Closed forms of pressing alone: which contact a surface has, and how wide it is."""

from __future__ import annotations

import math

import pytest
from solving import MATERIAL, A, build

from fretsolve.problem.setup.closed_forms import ClosedForms
from fretsolve.reference.hertz import love_cone
from fretsolve.simulation.problem_setup import set_up

MODULUS = MATERIAL.contact_modulus
STRAIGHT = {"cylinder": {"radius": 10.0, "axis": 0.0, "length": 2.0, "end_radius": 0.2}}


def forms_of(surface: object, *loads: dict[str, float]) -> ClosedForms:
    path = list(loads or [{"P": 400.0}])
    return set_up(build(surface=surface, load_path=path, grid={"points": 12, "size": 3.0})).closed_forms


@pytest.mark.parametrize(
    ("surface", "width"),
    [
        ({"sphere": {"radius": 10.0}}, 2.0 * A),
        ({"cone": {"angle": 0.02}}, 2.0 * love_cone(400.0, 0.02, MODULUS).contact_radius),
        ({"punch": {"radius": 0.4}}, 0.8),
        ({"cylinder": {"radius": 10.0, "axis": 0.0}}, 4.0 * math.sqrt(400.0 / 5.0 * 10.0 / (math.pi * MODULUS))),
        (STRAIGHT, 4.0 * math.sqrt(400.0 / 1.6 * 10.0 / (math.pi * MODULUS))),
        ([{"sphere": {"radius": 20.0}}, {"sphere": {"radius": 20.0}}], None),
    ],
    ids=["sphere", "cone", "punch", "cylinder without ends", "cylinder", "two surfaces"],
)
def test_width_of_the_contact(surface: object, width: float | None) -> None:
    """Of cylinders b = 2 sqrt(p R/pi E*) with the load p per length between the rounded ends."""
    assert forms_of(surface).contact_width(5.0) == (None if width is None else pytest.approx(width))


def test_the_hardest_pressed_load_of_a_punch_counts() -> None:
    surface = {"punch": {"radius": 0.4}}
    one, other = (forms_of(surface, {"P": 100.0}, {"P": load}).punch for load in (400.0, 50.0))
    assert one is not None and other is not None
    assert (one.load, other.load) == pytest.approx((400.0, 100.0))
    # Boussinesq: P = 2 a E* d
    approach = 400.0 / (0.8 * MODULUS)
    moved = forms_of(surface, {"delta_z": approach}).punch
    assert moved is not None
    assert moved.load == pytest.approx(400.0)
    assert forms_of(surface, {"P": 400.0, "My": 1.0}).punch is None
