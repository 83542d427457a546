"""Areas of contact and stick zone within cells: against exact fronts, for shapes, and where there is no front."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from solving import FRICTION, LOAD, MATERIAL, RADIUS, A, grid_of, solve, solve_last
from zones import contact_area, stick_area

from fretsolve.contact.zones.edge_law import ZoneFields
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.model.materials import Compliances
from fretsolve.reference.hertz import hertz_elliptic, hertz_sphere
from fretsolve.result.state import Zone

UNIT = Compliances(A=2.0, B=0.0, C=0.0)
"""A contact modulus of 1."""
CELL = 0.7226 / 32
SQUARE = {"points": 32, "size": 0.7226}
SHEARED = [{"P": LOAD}, {"Qx": 30.0, "increments": 1}]


def contact_of(state, grid, materials=MATERIAL):
    return contact_area(state.fields.pressure, state.fields.gap, grid, materials)


def stick_of(state, before, grid, contact=np.inf):
    fields = state.fields
    slip = fields.slip - before.fields.slip
    limit = FRICTION * fields.pressure
    found = ZoneFields(fields.pressure, fields.gap, fields.shear, limit, slip, fields.zone, before.fields.slip)
    return stick_area(found, grid, MATERIAL, contact)


def counted(cells, grid):
    return np.count_nonzero(cells) * grid.cell_area


def relative_radius(area, exact):
    """Relative error of the radius of the circle of that area."""
    return np.sqrt(area / np.pi) / exact - 1.0


def line_contact(half_width, cell, offset):
    """Pressure and gap (n,) of a cylinder of radius 1 on a half-plane, E* = 1, under Hertz's load for `half_width`.

    Constant pressure per cell and gap at its centre, as in the solver; the cells in contact are found by trial.
    """
    cells = int(np.ceil(1.4 * half_width / cell))
    x = (np.arange(-cells, cells + 1) + offset) * cell
    apart = x[:, None] - x
    ends = apart - 0.5 * cell, apart + 0.5 * cell
    below, above = (end * np.log(np.abs(end)) - end for end in ends)
    influence = 2.0 / np.pi * (below - above)
    active, before = np.abs(x) < half_width, np.zeros(x.size, dtype=bool)
    while (active != before).any():
        system = np.zeros((x.size + 1, x.size + 1))
        system[:-1, :-1] = np.where(active[:, None], influence, np.eye(x.size))
        system[:-1, -1], system[-1, :-1] = -1.0 * active, cell
        load = 0.25 * np.pi * half_width**2
        *pressure, approach = np.linalg.solve(system, np.append(np.where(active, -0.5 * x**2, 0.0), load))
        gap = 0.5 * x**2 + influence @ pressure - approach
        before, active = active, np.where(active, np.array(pressure) > 0.0, gap < -1e-13)
    return np.array(pressure), np.where(active, 0.0, gap)


class TestStraightFronts:
    @pytest.mark.parametrize("axis", [0, 1])
    def test_along_the_cells(self, axis):
        """Over all places of the front within a cell. What it has of the border is counted, and taken out here."""
        cell = 1.0 / 40
        for place in np.linspace(0.0, 0.95, 20):
            exact = 1.0 + place * cell
            fields = line_contact(exact, cell, offset=0.37)
            areas = []
            for length in (10, 20):
                pressure, gap = (np.repeat(field[:, None], length, axis=1) for field in fields)
                if axis == 1:
                    pressure, gap = pressure.T.copy(), gap.T.copy()
                areas.append(contact_area(pressure, gap, Grid(*pressure.shape, cell, cell), UNIT))
            half_width = (areas[1] - areas[0]) / (10 * cell) / 2.0
            assert half_width == pytest.approx(exact, abs=5e-3 * cell)

    @pytest.mark.parametrize("along", [0.3, 1.0, 4.0])
    def test_oblong_cells(self, along):
        """The cells' length along the front does not matter."""
        cell, exact = 1.0 / 40, 1.013
        pressure, gap = (np.repeat(field[:, None], 30, axis=1) for field in line_contact(exact, cell, 0.2))
        areas = [
            contact_area(pressure[:, :n], gap[:, :n], Grid(len(gap), n, cell, along * cell), UNIT) for n in (10, 30)
        ]
        assert (areas[1] - areas[0]) / (20 * along * cell) == pytest.approx(2.0 * exact, abs=1e-2 * cell)


class TestShapes:
    @pytest.mark.parametrize("radii", [(20.0, 10.0), (40.0, 8.0), (100.0, 6.0)])
    @pytest.mark.parametrize("angle", [0.0, 0.3, 0.8])
    def test_ellipses(self, radii, angle):
        a, b = hertz_elliptic(LOAD, *radii, MATERIAL.contact_modulus).semi_axes
        surface = {"ellipsoid": {"radius_x": radii[0], "radius_y": radii[1], "angle": angle}}
        parts = {"surface": surface, "grid": {"points": 64, "size": 2.3 * a}}
        state, grid = solve_last(**parts, load_path=[{"P": LOAD}]), grid_of(**parts)
        found = contact_of(state, grid)
        assert found == pytest.approx(np.pi * a * b, rel=1.2e-2 * grid.dx / b)  # b is 4.5 to 17.5 cells
        assert counted(state.fields.pressure, grid) > found

    def test_a_ring(self, tmp_path):
        """A torus on a flat: the ring has two fronts, one of them turning the other way."""
        areas = []
        for points in (64, 128):
            side = (np.arange(points + 2) - (points + 1) / 2) * 1.2 / points
            np.save(tmp_path / "map.npy", 0.05 * (np.hypot(side[:, None], side) - 0.4) ** 2)
            surface = {"heights": {"file": str(tmp_path / "map.npy"), "spacing": 1.2 / points}}
            parts = {"surface": surface, "grid": {"points": points, "size": 1.2}}
            state, grid = solve_last(**parts, load_path=[{"P": LOAD}]), grid_of(**parts)
            areas.append((contact_of(state, grid), counted(state.fields.pressure, grid)))
        assert areas[0][0] == pytest.approx(areas[1][0], rel=1e-3)
        assert areas[0][1] > 1.01 * areas[0][0]

    def test_two_contacts(self):
        state, grid = solve_last(grid=SQUARE), grid_of(grid=SQUARE)
        alone = contact_of(state, grid)
        fields = [np.concatenate([field, field], axis=1) for field in (state.fields.pressure, state.fields.gap)]
        assert contact_area(*fields, Grid(32, 64, grid.dx, grid.dy), MATERIAL) == pytest.approx(2.0 * alone, rel=1e-12)

    @pytest.mark.parametrize("points", [(32, 64), (48, 32)])
    def test_circles_in_oblong_cells(self, points):
        parts = {"grid": {"points": list(points), "size": 0.7226}}
        start, state = solve(**parts, coupling="none", load_path=SHEARED)
        grid = grid_of(**parts)
        assert relative_radius(contact_of(state, grid), A) == pytest.approx(0.0, abs=5e-4)
        stick = A * (1.0 - 30.0 / (FRICTION * LOAD)) ** (1 / 3)
        assert relative_radius(stick_of(state, start, grid), stick) == pytest.approx(0.0, abs=3e-3)

    def test_few_cells(self):
        """From two cells of radius on, the radius is within 0.05 cells; below, no worse than a count."""
        cell = 0.1
        for center in ((0.0, 0.0), (0.05, 0.05), (0.03, 0.01)):
            for radius in (0.1, 0.3, 0.5, 0.8, 1.0, 1.4, 2.0, 2.5, 3.0, 4.0):
                load = 4.0 * MATERIAL.contact_modulus * (radius * cell) ** 3 / (3.0 * RADIUS)
                grid = {"points": 13, "size": 13 * cell, "center": list(center)}
                state = solve_last(grid=grid, load_path=[{"P": load}])
                assert hertz_sphere(load, RADIUS, MATERIAL.contact_modulus).contact_radius == pytest.approx(
                    radius * cell
                )
                cells = np.count_nonzero(state.fields.pressure)
                found = contact_of(state, Grid(13, 13, cell, cell)) / cell**2
                error = abs(np.sqrt(found / np.pi) - radius)
                assert error < 0.05 or (radius < 2.0 and error <= max(abs(np.sqrt(cells / np.pi) - radius), 0.1))


@pytest.fixture(scope="module")
def sheared():
    """Fields of an off-centre contact in oblong cells, with a stick zone off its centre, and their grid."""
    grid = {"points": [32, 40], "size": 0.76, "center": [0.013, -0.007]}
    parts = {"grid": grid, "load_path": [{"P": LOAD}, {"Qx": 25.0, "Qy": 15.0, "Mz": 2.0, "increments": 1}]}
    start, state = solve(**parts)
    fields = state.fields
    slip = fields.slip - start.fields.slip
    limit = FRICTION * fields.pressure
    arrays = fields.pressure, fields.gap, fields.shear, limit, slip, fields.zone, start.fields.slip
    return arrays, grid_of(**parts)


class TestSymmetry:
    @staticmethod
    def areas(arrays, grid, materials=MATERIAL):
        contact = contact_area(*arrays[:2], grid, materials)
        return contact, stick_area(ZoneFields(*arrays), grid, materials, contact)

    def test_transposition(self, sheared):
        arrays, grid = sheared
        turned = [np.swapaxes(array[::-1] if array.ndim == 3 else array, -1, -2) for array in arrays]
        found = self.areas(turned, Grid(grid.ny, grid.nx, grid.dy, grid.dx))
        assert found == pytest.approx(self.areas(arrays, grid), rel=1e-12)

    @pytest.mark.parametrize("axis", [-1, -2])
    def test_reflection(self, sheared, axis):
        arrays, grid = sheared
        assert self.areas([np.flip(array, axis) for array in arrays], grid) == pytest.approx(
            self.areas(arrays, grid), rel=1e-12
        )

    @given(length=st.floats(1e-4, 1e4), stiffness=st.floats(1e-4, 1e4), ratio=st.floats(1e-3, 1e3))
    @settings(max_examples=25, deadline=None)
    def test_units_do_not_matter(self, sheared, length, stiffness, ratio):
        """Areas scale with lengths squared; tractions over the modulus with displacements over lengths."""
        arrays, grid = sheared
        traction, displacement = stiffness * ratio, length * ratio
        factors = traction, displacement, traction, traction, displacement, 1, displacement
        scaled = [array if factor == 1 else factor * array for array, factor in zip(arrays, factors, strict=True)]
        materials = Compliances(MATERIAL.A / stiffness, MATERIAL.B / stiffness, MATERIAL.C / stiffness)
        found = self.areas(scaled, Grid(grid.nx, grid.ny, length * grid.dx, length * grid.dy), materials)
        assert np.array(found) / length**2 == pytest.approx(self.areas(arrays, grid), rel=1e-9)


class TestNoFront:
    def test_nothing_touches(self):
        nothing, grid = np.zeros((6, 5)), Grid(6, 5, 0.1, 0.1)
        assert contact_area(nothing, nothing + 1.0, grid, MATERIAL) == 0.0

    @pytest.mark.parametrize("place", [(3, 2), (0, 0), (5, 4)])
    def test_one_cell(self, place):
        pressure = np.zeros((6, 5))
        pressure[place] = 1.0
        assert contact_area(pressure, 1.0 * (pressure == 0.0), Grid(6, 5, 0.1, 0.3), MATERIAL) == pytest.approx(0.03)

    def test_the_whole_grid(self):
        pressure = np.ones((6, 5))
        assert contact_area(pressure, 0.0 * pressure, Grid(6, 5, 0.1, 0.3), MATERIAL) == pytest.approx(0.9)

    @pytest.mark.parametrize("punch", [{"radius": 0.2}, {"half_width": 0.2}])
    def test_a_sharp_edge_is_where_the_cells_are(self, punch):
        parts = {"surface": {"punch": punch}, "grid": {"points": 40, "size": 0.6}}
        state, grid = solve_last(**parts), grid_of(**parts)
        assert contact_of(state, grid) == pytest.approx(counted(state.fields.pressure, grid), rel=1e-12)

    def test_a_step_of_finite_height(self):
        """Of a height map, a hundred times as high as the surfaces approach."""
        parts = {"surface": {"punch": {"radius": 0.2}}, "grid": {"points": 40, "size": 0.6}}
        state, grid = solve_last(**parts), grid_of(**parts)
        gap = np.where(np.isinf(state.fields.gap), 1.0, state.fields.gap)
        found = contact_area(state.fields.pressure, gap, grid, MATERIAL)
        assert found == pytest.approx(counted(state.fields.pressure, grid), rel=1e-12)

    def test_full_stick(self):
        """The stick zone ends where the contact does."""
        pressed, sheared = solve(friction=2.0, grid=SQUARE, load_path=[{"P": LOAD}, {"Qx": 1e-3, "increments": 1}])
        fields = sheared.fields
        zone = np.where(fields.zone == Zone.OPEN, Zone.OPEN, Zone.STICK).astype(np.uint8)
        limit, slip = 2.0 * fields.pressure, 0.0 * fields.slip
        found = ZoneFields(fields.pressure, fields.gap, fields.shear, limit, slip, zone, slip)
        contact = contact_of(pressed, grid_of(grid=SQUARE))
        assert stick_area(found, grid_of(grid=SQUARE), MATERIAL, contact) == contact

    @pytest.mark.parametrize("friction", [0.0, FRICTION])
    def test_gross_slip(self, friction):
        path = [{"P": LOAD}, {"delta_x": 0.01, "increments": 1}]
        start, state = solve(friction=friction, grid=SQUARE, load_path=path)
        assert stick_of(state, start, grid_of(grid=SQUARE)) == 0.0
        assert state.fields.zone.any()

    @given(data=st.data())
    @settings(max_examples=60, deadline=None)
    def test_whatever_the_fields(self, data):
        """Finite areas, the stick zone's no larger than the contact's, and that no larger than the grid."""
        shape = data.draw(st.tuples(st.integers(1, 9), st.integers(1, 9)))
        random = np.random.default_rng(data.draw(st.integers(0, 2**32)))
        pressure = np.maximum(random.standard_normal(shape) + data.draw(st.floats(-1.0, 2.0)), 0.0)
        gap = np.where(pressure > 0.0, 0.0, random.choice([0.0, 1e-9, 1e-3, np.inf], shape))
        zone = np.where(pressure > 0.0, random.integers(1, 3, shape), 0).astype(np.uint8)
        bound = FRICTION * pressure
        shear = np.where(zone == Zone.SLIP, 1.0, random.random(shape)) * np.stack([bound, 0.0 * bound])
        slip = random.choice([0.0, 1e-9, 1e-5, 1.0], (2, *shape)) * (zone == Zone.SLIP)
        before = random.choice([-1.0, -0.8, -0.5, 0.0, 1.0], (2, *shape)) * slip
        before += random.choice([0.0, 1e-9, 1e-5], (2, *shape))
        grid = Grid(*shape, 0.1, 0.1 * data.draw(st.floats(0.1, 10.0)))
        contact = contact_area(pressure, gap, grid, MATERIAL)
        stick = stick_area(ZoneFields(pressure, gap, shear, bound, slip, zone, before), grid, MATERIAL, contact)
        assert 0.0 <= stick <= contact <= grid.nx * grid.ny * grid.cell_area * (1.0 + 1e-12)
        assert (contact > 0.0) == pressure.any()


class TestSmallIncrements:
    """The slip of one increment is then less than belongs to the shear in the stick zone."""

    @pytest.mark.parametrize("increments", [20, 200])
    def test_a_front_that_hardly_moves(self, increments):
        path = [{"P": LOAD}, {"Qx": 36.0, "increments": increments}]
        *_, start, state = solve(grid=SQUARE, coupling="none", load_path=path)
        exact = A * 0.1 ** (1 / 3)
        found = stick_of(state, start, grid_of(grid=SQUARE))
        assert np.sqrt(found / np.pi) == pytest.approx(exact, abs=0.12 * CELL)

    def test_a_front_that_stays(self):
        """A stage that holds the load, but for a trace of it."""
        parts = {"grid": {"points": 64, "size": 0.7226}, "coupling": "none"}
        path = [{"P": LOAD}, {"Qx": 30.0, "increments": 1}, {"Qx": 30.0 * (1.0 + 1e-7), "increments": 1}]
        pressed, sheared, held = solve(**parts, load_path=path)
        grid = grid_of(**parts)
        moved, kept = stick_of(sheared, pressed, grid), stick_of(held, sheared, grid)
        assert np.sqrt(kept / np.pi) == pytest.approx(np.sqrt(moved / np.pi), abs=0.1 * grid.dx)
