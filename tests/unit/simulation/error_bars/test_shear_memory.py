"""What slips on paths of load and shear, against closed forms of Jaeger's superposition."""

from __future__ import annotations

from itertools import pairwise

import pytest

from fretsolve.simulation.error_bars.shear_memory import NO_SHEAR, ShearMemory

FRICTION = 0.3
Path = list[tuple[float, float]]


def remembered(path: Path, along: tuple[float, float, float] = (1.0, 0.0, 0.0)) -> ShearMemory:
    """Return the memory of a path of loads and of shears over the friction, along a direction."""
    memory = NO_SHEAR
    for load, shear in path:
        x, y, turn = (FRICTION * shear * part for part in along)
        memory = memory.after(load, (x, y, turn), FRICTION)
    return memory


@pytest.mark.parametrize(
    ("path", "slipping"),
    [
        ([(1.0, 0.0), (1.0, 0.4)], 0.4),  # Cattaneo and Mindlin
        ([(1.0, 0.0), (1.0, 0.4), (1.0, -0.4)], 0.4),  # half of the way of a reversal
        ([(1.0, 0.0), (1.0, 0.4), (1.0, 0.3)], 0.05),
        ([(1.0, 0.0), (1.0, 0.03), (1.0, 0.02), (1.0, 0.08)], 0.08),  # a turn that the load passes is forgotten
        ([(1.2, 0.072), (1.1, 0.0)], 0.06 / 1.06),  # in proportion, then back
        ([(1.0, 0.0), (1.3, 0.2), (1.1, 0.0)], 1.0 - (1.1 + 0.2 / 0.3) / (1.0 + 0.2 / 0.3) / 1.1),
        ([(0.67, 0.0), (0.67, 0.1), (1.0, 0.1), (1.0, 0.0)], 0.1),  # raised with the shear held, then back
        ([(0.5, 0.0), (0.5, 0.1), (1.0, 0.1), (1.0, 0.14)], 0.04),
        ([(1.3, 0.0), (1.3, 0.2), (0.9, 0.06)], 0.06 / 0.9),  # falls, and slips on
        ([(1.5, 0.0), (1.5, 0.6), (1.0, 4.0 / 30.0)], 4.0 / 30.0),
        ([(1.0, 0.0), (1.3, 0.2)], 0.0),  # less than friction carries on what the load adds
        ([(1.0, 0.0), (1.5, 0.4), (1.0, 0.0)], 0.0),  # and all the way back
        ([(1.0, 0.0), (1.0, 0.5), (0.0, 0.0), (1.0, 0.0), (1.0, 0.04)], 0.04),  # opened in between
        ([(1.0, 0.0), (1.0, 1.0)], 1.0),  # gross slip
        ([(1.0, 0.0), (1.0, 1.0), (1.0, 0.0)], 0.5),
    ],
)
def test_part_of_the_load_that_slips(path: Path, slipping: float) -> None:
    for along in ((1.0, 0.0, 0.0), (0.6, 0.0, -0.8)):
        assert remembered(path, along).slipping == pytest.approx(slipping, abs=1e-9)


def test_the_number_of_increments_does_not_matter() -> None:
    ends = [(1.0, 0.0), (1.3, 0.5), (1.1, 0.1), (1.2, 0.6)]
    fine = [
        (one[0] + share * (two[0] - one[0]), one[1] + share * (two[1] - one[1]))
        for one, two in pairwise(ends)
        for share in (0.25, 0.5, 0.75, 1.0)
    ]
    assert remembered([ends[0], *fine]).slipping == pytest.approx(remembered(ends).slipping, abs=1e-9) != 0.0


def test_an_increment_that_changes_next_to_nothing_leaves_what_slips() -> None:
    memory = remembered([(1.0, 0.0), (1.0, 0.4)])
    held = memory.after(1.0 + 1e-6, (0.4 * FRICTION - 1e-6, 0.0, 0.0), FRICTION)
    assert held.slipping == memory.slipping


def test_an_increment_at_once_shears_all_that_it_presses() -> None:
    """As its load first, and then its shear; where the load does not grow there is no difference."""
    memory = remembered([(1.0, 0.0)])
    shear = 0.2 * FRICTION, 0.0, 0.0
    assert memory.after_at_once(1.3, shear, FRICTION).slipping == pytest.approx(0.2 / 1.3)
    assert memory.after_at_once(0.9, shear, FRICTION) == memory.after(0.9, shear, FRICTION)
