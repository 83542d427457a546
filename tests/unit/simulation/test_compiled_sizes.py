"""The compiled kernels measure zones as `ZoneEdge` does, wherever these lie and whatever the fields are like."""

from __future__ import annotations

import numpy as np
import pytest
from solving import DISSIMILAR, LOAD, build

from fretsolve.kernels import load
from fretsolve.model.grid import Grid
from fretsolve.model.materials import Compliances
from fretsolve.result.state import Zone
from fretsolve.setup.problem_setup import set_up
from fretsolve.simulation.simulation import run
from fretsolve.simulation.zones.compiled_sizes import ZoneSize, compiled_sizes
from fretsolve.simulation.zones.edge_shares import ZoneFields
from fretsolve.simulation.zones.zone_areas import zone_area
from fretsolve.simulation.zones.zone_edges import ZoneEdge, contact_edge, stick_edge
from fretsolve.simulation.zones.zone_extents import zone_extent

pytest.importorskip("numba")

KERNELS = load(compiled=True).zones
MATERIALS = Compliances(2e-5, 5e-6, 1e-6)
SHAPES = [(1, 9), (9, 1), (2, 3), (7, 6), (12, 17), (30, 30)]


def by_edges(fields: ZoneFields, grid: Grid) -> tuple[ZoneSize, ZoneSize]:
    contact = contact_edge(fields.pressure, fields.gap, grid, MATERIALS)
    stick = stick_edge(fields, grid, MATERIALS, contact)

    def size(edge: ZoneEdge | None) -> ZoneSize:
        return ZoneSize(zone_area(edge), zone_extent(edge))

    return size(contact), size(stick)


def random_fields(random: np.random.Generator, shape: tuple[int, int]) -> ZoneFields:
    """Return fields whose zones lie anywhere: smooth ones or not, with material everywhere or not."""
    x, y = (np.linspace(-1.0, 1.0, count) if count > 1 else np.zeros(1) for count in shape)
    a, b, c, d = random.uniform(0.1, 1.6), random.uniform(0.1, 1.6), random.uniform(-1, 1), random.uniform(-1, 1)
    height = 1.0 - ((x[:, None] - c) / a) ** 2 - ((y[None, :] - d) / b) ** 2
    height += random.choice([0.0, 0.02, 0.6]) * random.normal(size=shape)
    pressure = 500.0 * np.sqrt(np.maximum(height, 0.0))
    gap = np.where(height > 0.0, 0.0, 0.02 * random.choice([0.1, 1.0]) * np.maximum(-height, 0.0) ** 1.5)
    gap[(height <= 0.0) & (random.random(shape) < random.choice([0.0, 0.3]))] = np.inf
    limit = 0.3 * pressure
    # the stick zone, the reserve in it and the slip outside
    inner = height - random.uniform(0.0, 0.9) + random.choice([0.0, 0.3]) * random.normal(size=shape)
    sticks = (pressure > 0.0) & (inner > 0.0)
    power = random.choice([0.5, 1.5, 3.0])
    share = np.where(sticks, 1.0 - np.clip(np.maximum(inner, 0.0) ** power, 0.0, 1.0), 1.0)
    at_limit = sticks & (random.random(shape) < random.choice([0.0, 0.5]))
    share[at_limit] = 1.0 - 1e-6 * random.random(shape)[at_limit]  # rounding alone would decide which is less at 1
    angle = random.uniform(0.0, 6.3) + random.choice([0.0, 1.0]) * random.normal(size=shape)
    along = np.array([np.cos(angle), np.sin(angle)])
    zone = np.where(pressure > 0.0, np.where(sticks, Zone.STICK, Zone.SLIP), Zone.OPEN).astype(np.uint8)
    slip = np.where(zone == Zone.SLIP, 1e-3 * random.choice([0.01, 1.0]) * np.maximum(-inner, 0.0) ** 1.5, 0.0) * along
    before = random.choice([0.0, -1.0, -0.8, -0.5, 1.0]) * slip
    before += random.choice([0.0, 1e-5]) * random.random((2, *shape))
    return ZoneFields(pressure, gap, share * limit * along, limit, slip, zone, before)


@pytest.mark.parametrize("shape", SHAPES)
def test_random_fields(shape):
    random, measured = np.random.default_rng(sum(shape)), 0
    for _ in range(150):
        fields = random_fields(random, shape)
        grid = Grid(*shape, *random.uniform(0.01, 0.03, 2), *random.uniform(-1.0, 1.0, 2))
        sizes = compiled_sizes(KERNELS, fields, grid, MATERIALS)
        for found, expected in zip(sizes, by_edges(fields, grid), strict=True):
            np.testing.assert_allclose(found.area, expected.area, rtol=1e-9, atol=1e-15)
            np.testing.assert_allclose(found.extent, expected.extent, rtol=1e-9, atol=1e-12)
            measured += found.area > 0.0
    assert measured > 100


@pytest.mark.parametrize(("bodies", "coupling"), [(DISSIMILAR, "auto"), (None, "none")])
def test_runs_have_the_same_sizes(bodies, coupling):
    """Growing and receding fronts, at the limit, and those that move by less than a cell."""
    parts = {} if bodies is None else {"bodies": bodies}
    path = [{"P": LOAD, "increments": 4}, *({"Qx": q, "increments": 6} for q in (36.0, -36.0))]
    case = build(**parts, coupling=coupling, grid={"points": [32, 30]}, load_path=path)
    histories = [[state.summary for state in run(set_up(case, compiled=compiled))] for compiled in (False, True)]
    for one, other in zip(*histories, strict=True):
        for zone in ("contact", "stick"):
            for name in ("area", "half_width_x", "half_width_y", "center_x", "center_y"):
                values = [getattr(summary, f"{zone}_{name}") for summary in (one, other)]
                np.testing.assert_allclose(*values, rtol=1e-5, atol=1e-6)
