"""Tips and edges: where the pressure is infinite, or higher than cells show."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from solving import build

from fretsolve.case.keys.body_specs import PunchSurface
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.problem.setup.warnings import case_warnings
from fretsolve.problem.surface.edges import Edge, edges, flat_part, rounding
from fretsolve.simulation.problem_setup import set_up


def setup_of(surface: Any, points: int = 41, size: float = 1.2) -> ProblemSetup:
    parts = {"surface": surface, "friction": 0.0, "load_path": [{"P": 200.0}]}
    return set_up(build(**parts, grid={"points": points, "size": size}))


def test_edges_are_where_bodies_end() -> None:
    cylinder = {"radius": 5.0, "axis": "x", "length": 1.0, "end_radius": 0.1}
    setup = setup_of([{"punch": {"radius": 0.5}}, {"cylinder": cylinder}])
    found = edges(setup.case.surface, setup.grid)
    assert [edge.radius for edge in found] == [0.0, 0.1]
    assert [rounding(surface) for surface in setup.case.surface] == [0.0, 0.1]
    assert not found[0].near[20, 20]
    assert found[0].near[37, 20]
    assert found[1].near[37, 20]
    assert not found[1].near[20].any()  # the cylinder lies along x
    assert not edges(setup_of({"sphere": {"radius": 10.0}}).case.surface, setup.grid)


def test_tip_of_a_cone_is_one() -> None:
    setup = setup_of({"cone": {"angle": 0.02}})
    (tip,) = edges(setup.case.surface, setup.grid)
    pressure = np.zeros(setup.grid.shape)
    assert tip.hidden_pressure(pressure, 0.03, 1e5) == 0.0
    pressure[20, 20] = 1.0
    assert math.isinf(tip.hidden_pressure(pressure, 0.03, 1e5))


def test_peak_at_a_rounded_edge_is_that_of_the_singular_integral() -> None:
    """By quadrature of the pressure whose slope is that of the arc, in units of the depth d."""
    from scipy.integrate import quad

    radius, modulus, factor = 0.005, 1.1e5, 60.0
    depth = (1.5 * math.pi * factor * radius / modulus) ** (2.0 / 3.0)

    def pressure(x: float) -> float:  # (E* / 2 pi r) (d - x)^(1/2) times the principal value of the integral
        root = math.sqrt(1.0 - x)
        if x > 0.0:  # s = 1 - u^2
            smooth = quad(lambda u: -2.0 * (1.0 - u**2) / (root + u), 0.0, 1.0, weight="cauchy", wvar=root)[0]
        else:
            smooth = quad(lambda u: 2.0 * (1.0 - u**2) / (1.0 - u**2 - x), 0.0, 1.0)[0]
        return modulus * depth / (2.0 * math.pi * radius) * root * smooth

    far = 1e4
    assert pressure(-far) == pytest.approx(factor / math.sqrt(far * depth), rel=1e-3)
    peak = max(pressure(x) for x in np.linspace(0.2, 0.5, 31))
    cell, near = 0.03, np.ones((1, 1), dtype=bool)
    shown = np.full((1, 1), 2.0 * factor / math.sqrt(cell))
    hidden = Edge(radius, near).hidden_pressure(shown, cell, modulus)
    assert shown[0, 0] + hidden == pytest.approx(peak, rel=0.01)


def test_roundings_within_a_cell_are_warned_of() -> None:
    punch = {"punch": {"radius": 0.5, "edge_radius": 0.02}}
    (text,) = [one for one in case_warnings(setup_of(punch)) if "rounding" in one]
    assert "edge_radius: the rounding of 0.02 mm fits into a cell of 0.0293 mm" in text
    assert not [one for one in case_warnings(setup_of(punch, points=64)) if "fits into a cell" in one]
    assert not [one for one in case_warnings(setup_of({"punch": {"radius": 0.5}})) if "rounding" in one]


@pytest.mark.parametrize(
    ("punch", "line", "flat"),
    [
        ({"radius": 0.5, "edge_radius": 0.2}, False, 0.3),
        ({"radius": 0.5}, False, 0.5),
        ({"radius": 0.5, "edge_radius": 0.5}, False, 0.0),
        ({"half_width": 0.5, "edge_radius": 0.2}, False, 0.6 / math.sqrt(math.pi)),
        ({"half_width": 0.5, "edge_radius": 0.2}, True, 0.5),
    ],
)
def test_flat_part_of_a_punch(punch: dict[str, float], line: bool, flat: float) -> None:
    assert flat_part(PunchSurface(**punch), line=line) == pytest.approx(flat, abs=1e-12)
