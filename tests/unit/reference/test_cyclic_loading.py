"""Turning points that a contact remembers, and the energy that it dissipates between them."""

from __future__ import annotations

import numpy as np
import pytest
from solving import FRICTION, HERTZ, MATERIAL

from fretsolve.reference.cyclic_loading import CyclicLoading, cyclic_loading, dissipated, last_branch, turning_points

COMPLIANCES = (MATERIAL.tangential, MATERIAL.torsional)


def loaded(P, Qx, Qy=0.0, Mz=0.0) -> CyclicLoading | None:
    loads = np.broadcast_arrays(*(np.asarray(column, float) for column in (P, Qx, Qy, Mz)))
    return cyclic_loading(HERTZ, FRICTION, COMPLIANCES, loads)


def test_turning_points_that_are_remembered() -> None:
    assert turning_points([1.0, 2.0, 3.0])[0] == (0.0, 3.0)
    assert turning_points([3.0, 1.0, 2.0])[0] == (0.0, 3.0, 1.0, 2.0)
    assert turning_points([3.0, 1.0, 2.0, 0.5])[0] == (0.0, 3.0, 0.5)
    assert turning_points([3.0, -3.0])[0] == (0.0, -3.0)
    assert turning_points([3.0, -2.0, 3.0, 3.0])[0] == (0.0, 3.0)
    assert turning_points([3.0, 3.0 - 1e-12, 3.0], least=1e-9)[0] == (0.0, 3.0)
    assert turning_points([])[0] == (0.0,)


def test_the_last_branch_of_a_closed_loop_is_still_that_of_the_loop() -> None:
    """Where it has closed exactly; cells between it and the first loading's slip zone have not moved."""
    assert last_branch([6.0]) == 6.0
    assert last_branch([6.0, -6.0, 6.0]) == 6.0
    assert last_branch([6.0, 2.0]) == -2.0
    assert last_branch([6.0, 2.0, 6.0]) == 2.0
    assert last_branch([6.0, 2.0, 5.999, 6.0, 6.0]) == 2.0
    assert last_branch([6.0, 2.0, 6.001]) == 6.001
    assert last_branch([6.0, 2.0, 4.0, 3.0]) == -0.5
    assert last_branch([6.0, 6.0 + 1e-9], least=1e-6) == 6.0
    assert last_branch([]) == last_branch([0.0]) == 0.0


def test_dissipation_of_loops_within_loops() -> None:
    def per_cycle(load: float) -> float:
        return load**3

    assert dissipated([2.0, 6.0], per_cycle) == pytest.approx(216.0 / 4)
    assert dissipated([6.0, -6.0, 6.0], per_cycle) == pytest.approx(216.0 * 1.25)
    assert dissipated([6.0, 2.0, 6.0, 8.0], per_cycle) == pytest.approx(512.0 / 4 + 8.0)
    assert dissipated([6.0, -7.0], per_cycle) == pytest.approx(343.0 / 4 + 216.0 / 2)
    assert dissipated([6.0, 0.0, 4.0, -6.0], per_cycle) == pytest.approx(216.0 / 4 + 216.0 / 2 + 8.0)


def test_an_oblique_force_is_one_along_its_direction() -> None:
    straight, oblique = loaded([400, 400], [0, 30]), loaded([400, 400], [0, 18], [0, 24])
    assert oblique.stick_radius == pytest.approx(straight.stick_radius)
    assert oblique.component == "Qy"
    along = straight.displacements()["delta_x"]
    assert oblique.displacements() == {"delta_x": pytest.approx(0.6 * along), "delta_y": pytest.approx(0.8 * along)}


def test_where_there_is_no_solution() -> None:
    assert loaded([400, 400], [0, 30], [0, 0], [0, 1]) is None  # a force and a torque
    assert loaded([400, 400, 400], [0, 30, 30], [0, 0, 10]) is None  # the direction changes
    assert loaded([300, 300, 400], [0, 30, 30]) is None  # P changes under shear
    assert loaded([0, 300, 400, 400], [0, 0, 0, 30]).path == (0.0, 0.0, 0.0, 30.0)
    assert loaded([400], [0]).stick_radius == HERTZ.contact_radius
