from __future__ import annotations

import numpy as np
import pytest

from fretsolve.errors import ContactLostError, GridEdgeError
from fretsolve.increment.load_checks import gross_slip_error, require_inside, require_supported
from fretsolve.model.grid import Grid
from fretsolve.model.load_control import LoadControl

GRID = Grid.from_size((8, 6), (0.8, 0.6))
FLAT = np.zeros(GRID.shape)
ALL = (True, True, True)


class TestSupport:
    @pytest.mark.parametrize("loads", [(100.0, 0.0, 0.0), (100.0, 24.9, -34.9), (0.0, 0.0, 0.0)])
    def test_loads_that_act_on_the_grid(self, loads):
        require_supported(LoadControl(ALL, loads), FLAT, GRID)

    @pytest.mark.parametrize(
        ("loads", "component"), [((100.0, 26.0, 0.0), "Mx"), ((100.0, 0.0, -36.0), "My"), ((0.0, 0.0, 1.0), "My")]
    )
    def test_loads_outside_of_the_grid(self, loads, component):
        with pytest.raises(ContactLostError) as caught:
            require_supported(LoadControl(ALL, loads), FLAT, GRID)
        assert caught.value.component == component

    def test_the_message_says_where_the_load_may_act(self):
        with pytest.raises(ContactLostError, match=r"Mx/P = 0\.3 mm.*-0\.25 to 0\.25 mm"):
            require_supported(LoadControl(ALL, (100.0, 30.0, 0.0)), FLAT, GRID)

    def test_moments_of_imposed_rotations_do_not_count(self):
        require_supported(LoadControl((True, False, False), (100.0, 1.0, 1.0)), FLAT, GRID)
        require_supported(LoadControl((False, True, True), (1e-3, 500.0, 500.0)), FLAT, GRID)

    def test_only_cells_with_material_support(self):
        half = FLAT.copy()
        half[4:] = np.inf
        require_supported(LoadControl(ALL, (100.0, 0.0, -20.0)), half, GRID)
        with pytest.raises(ContactLostError):
            require_supported(LoadControl(ALL, (100.0, 0.0, 20.0)), half, GRID)

    def test_no_material_at_all(self):
        with pytest.raises(ContactLostError, match="nowhere"):
            require_supported(LoadControl(ALL, (100.0, 0.0, 0.0)), np.full(GRID.shape, np.inf), GRID)


class TestEdge:
    def test_contact_inside(self):
        pressure = FLAT.copy()
        pressure[1:-1, 1:-1] = 1.0
        require_inside(pressure, GRID)

    @pytest.mark.parametrize(("cell", "side"), [((0, 3), "-x"), ((7, 3), "+x"), ((3, 0), "-y"), ((3, 5), "+y")])
    def test_contact_at_an_edge(self, cell, side):
        pressure = FLAT.copy()
        pressure[cell] = 1.0
        with pytest.raises(GridEdgeError) as caught:
            require_inside(pressure, GRID)
        assert f"({side})" in str(caught.value)
        assert "0.8 x 0.6 mm" in str(caught.value)


class TestGrossSlip:
    def test_what_slips_and_what_is_carried(self):
        error = gross_slip_error(LoadControl(ALL, (50.0, 0.0, 3.0)), 0.8, 40.0)
        assert error.component == "Qx"
        for part in ("Qx = 50 N", "Mz = 3 N mm", "mu P = 40 N", "0.8", "delta_x and phi_z"):
            assert part in str(error)

    def test_nothing_is_carried(self):
        assert "none of it" in str(gross_slip_error(LoadControl(ALL, (0.0, 2.0, 0.0)), 0.0, 0.0))


def test_a_grid_without_material_bears_no_imposed_load():
    for load in (0.0, 100.0):
        with pytest.raises(ContactLostError, match="nowhere face each other") as caught:
            require_supported(LoadControl(ALL, (load, 0.0, 0.0)), np.full(GRID.shape, np.inf), GRID)
        assert caught.value.component == "P"
    require_supported(LoadControl((False, False, False), (0.0, 0.0, 0.0)), np.full(GRID.shape, np.inf), GRID)
