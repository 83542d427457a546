"""Which increments of a case count as mirror images before it is solved."""

from __future__ import annotations

import pytest
from solving import DISSIMILAR, build

from fretsolve.cli.case_summary import mirror_lines
from fretsolve.simulation.problem_setup import set_up

PATH = [{"P": 400.0, "increments": 3}, {"Qx": 20.0, "increments": 2}, {"Mz": 1.0, "increments": 4}]
BULK = [{"P": 400.0, "increments": 1}, {"bulk_2": {"xx": 70.0}, "increments": 1}]


def setup_of(path=PATH[:2], **parts):
    return set_up(build(**{"bodies": DISSIMILAR, "grid": {"points": 32}, "load_path": path} | parts))


@pytest.mark.parametrize(
    ("parts", "expected"),
    [
        ({}, 5),
        ({"path": PATH}, 5),
        ({"path": [PATH[0], {"Mz": 0.0, "increments": 2}]}, 5),
        ({"path": [PATH[0], {"delta_y": 1e-4, "increments": 2}, PATH[1]]}, 3),
        ({"grid": {"points": 33}}, 0),
        ({"grid": {"points": 16}}, 5),
        ({"grid": {"points": 14}}, 0),
        ({"surface": {"ellipsoid": {"radius_x": 10.0, "radius_y": 5.0, "angle": 0.3}}}, 0),
        ({"friction": {"coefficient": [0.2, 0.1]}}, 0),
        ({"friction": {"expression": "0.1 + 0.1*(r < 0.1)"}}, 5),
        ({"friction": {"expression": "0.1 + 0.1*(y > 0.1)"}}, 0),
        ({"friction": {"coefficient": 0.1, "shear_limit": 150.0}}, 5),
        ({"path": BULK}, 2),
        ({"path": [*BULK, {"bulk_2": {"xy": 10.0}, "increments": 3}]}, 2),
    ],
    ids=str,
)
def test_increments_from_the_first_one_on(parts, expected):
    setup = setup_of(**parts)
    assert setup.mirrored_increments == expected
    assert setup.share_of_cells == pytest.approx(1.0 - 0.5 * expected / setup.load_path.increments)
    advised = parts.get("grid") == {"points": 33}
    assert len(mirror_lines(setup)) == (expected > 0 or advised)


def test_validate_advises_an_even_number_of_points():
    (line,) = mirror_lines(setup_of(grid={"points": 33}))
    assert line == "an even number of points along y lets mirror images be solved on the half y > 0"
    assert not mirror_lines(setup_of([{"P": 400.0, "Qy": 1.0}], grid={"points": 33}))


def test_validate_says_which():
    (line,) = mirror_lines(setup_of())
    assert line == "mirror images about y = 0: all increments are solved on the half y > 0"
    (line,) = mirror_lines(setup_of([{"P": 400.0, "increments": 1}, PATH[2]]))
    assert line == "mirror images about y = 0: the first 1 increment is solved on the half y > 0"
    (line,) = mirror_lines(setup_of(PATH))
    assert line == "mirror images about y = 0: the first 5 increments are solved on the half y > 0"
