"""The closed forms that hold for a case, their values at the ends of stages, and what they forecast."""

from __future__ import annotations

import math
from typing import Any

import pytest
from solving import DISSIMILAR, FRICTION, HERTZ, MATERIAL, NO_POISSON, build

from fretsolve.problem.setup.closed_forms import ClosedForms
from fretsolve.reference.tangential import cattaneo_mindlin
from fretsolve.simulation.problem_setup import set_up

P = {"P": 400.0}
CYCLE = [P, {"Qx": 36.0}, {"Qx": -36.0}, {"Qx": 18.0}]
SLIM = {"ellipsoid": {"radius_x": 10.0, "radius_y": 25.0, "angle": 0.5}}
ROUND = {"ellipsoid": {"radius_x": 10.0, "radius_y": 10.0}}


def forms_of(*stages: dict[str, float], **parts: Any) -> ClosedForms:
    return set_up(build(load_path=list(stages or [P]), grid={"points": 12, "size": 1.0}, **parts)).closed_forms


def values_of(*stages: dict[str, float], **parts: Any) -> dict[tuple[str, int], float]:
    """Values by quantity and stage (from 0)."""
    return {(form.quantity, form.stage): form.value for form in forms_of(*stages, **parts).values()}


def test_a_sphere_under_its_approach_is_that_under_its_force() -> None:
    forced = forms_of().largest
    moved = forms_of({"delta_z": forced.delta_z}).largest
    assert forced == HERTZ
    assert moved.load == pytest.approx(400.0)
    assert moved.contact_radius == pytest.approx(HERTZ.contact_radius)
    assert moved.max_pressure == pytest.approx(HERTZ.max_pressure)


def test_an_ellipsoid() -> None:
    slim = forms_of(surface=SLIM).largest
    assert forms_of(surface=ROUND).largest == forms_of().largest
    assert slim.semi_axes == pytest.approx((0.255826, 0.470156), rel=1e-5)
    assert slim.max_pressure == pytest.approx(1.5 * 400.0 / (math.pi * math.prod(slim.semi_axes)))
    assert not slim.is_circle
    assert forms_of({"delta_z": 0.01}, surface=SLIM).largest is None


def test_values_of_a_cycle() -> None:
    found = values_of(*CYCLE, coupling="none")
    peak = cattaneo_mindlin(HERTZ, FRICTION, 36.0, MATERIAL.tangential)
    back = cattaneo_mindlin(HERTZ, FRICTION, 27.0, MATERIAL.tangential)
    assert found["delta_z", 0] == pytest.approx(HERTZ.delta_z, rel=1e-12)
    assert found["max_pressure", 3] == pytest.approx(HERTZ.max_pressure, rel=1e-12)
    assert found["stick_radius", 1] == pytest.approx(peak.stick_radius, rel=1e-12)
    assert found["delta_x", 2] == pytest.approx(-peak.delta_x, rel=1e-12)
    assert found["delta_x", 3] == pytest.approx(2.0 * back.delta_x - peak.delta_x, rel=1e-12)
    assert found["work_total", 2] == pytest.approx(0.75 * peak.work_per_cycle, rel=1e-12)
    assert ("delta_x", 0) not in found


@pytest.mark.parametrize(
    ("stages", "parts", "quantity", "known"),
    [
        ([P, {"Qx": 36.0}], {"coupling": "tangential"}, "delta_x", False),
        ([P, {"Qx": 36.0}], {"coupling": "tangential"}, "delta_z", True),
        ([P, {"Qx": 36.0}], {"coupling": "full"}, "delta_z", False),
        ([{**P, "phi_x": 1e-3}, {"Qx": 36.0}], {}, "delta_z", False),
        ([{**P, "phi_x": 1e-3}, {"phi_x": 0.0, "Qx": 36.0}], {}, "delta_x", False),
        ([{**P, "Qx": 1.0}, {"Qx": 36.0}], {}, "delta_x", False),
        ([P, {"Qx": 30.0}, {"Qx": -36.0, "P": 500.0}], {}, "delta_x", False),
        ([P, {"Qx": 30.0}, {"Qx": -36.0, "P": 500.0}], {}, "max_pressure", True),
        ([P, {"Qx": 30.0}, {"delta_x": -1e-3}], {}, "delta_x", False),
        ([P, {"Qx": 30.0}, {"Qy": 1.0}], {}, "delta_x", False),
        ([P, {"Qx": 24.0, "Qy": 18.0}], {}, "delta_y", True),
        ([P, {"Qx": 45.0}], {}, "delta_x", False),
        ([P], {"surface": {"sphere": {"radius": -10.0}}}, "delta_z", False),
        ([P], {"surface": SLIM}, "delta_z", True),
        ([P, {"Qx": 36.0}], {"surface": SLIM}, "delta_x", False),
        ([P], {"surface": {"cone": {"angle": 0.1}}}, "delta_z", False),
        ([{"delta_z": 0.009}], {}, "max_pressure", False),
    ],
)
def test_where_values_are_exact(stages: list[Any], parts: dict[str, Any], quantity: str, known: bool) -> None:
    found = values_of(*stages, **{"coupling": "none", **parts})
    assert ((quantity, len(stages) - 1) in found) is known


def test_mindlin_is_exact_without_poissons_ratio() -> None:
    assert ("delta_x", 3) in values_of(*CYCLE, coupling="tangential", bodies=NO_POISSON)
    assert forms_of(*CYCLE, coupling="tangential", bodies=NO_POISSON).why_not_mindlin == ""
    assert forms_of(*CYCLE).why_not_mindlin.startswith("with Poisson's ratios other than 0, shear along x also moves")
    assert forms_of(P, {"Mz": 5.0}).why_not_mindlin == ""


def test_torsion_is_exact_where_the_directions_interact() -> None:
    assert ("phi_z", 1) not in values_of(P, {"Mz": 5.0}, coupling="none")
    found = values_of(P, {"Mz": 5.0}, coupling="tangential")
    assert found["phi_z", 1] == pytest.approx(1.450218e-3, rel=1e-5)
    assert found["stick_radius", 1] == pytest.approx(0.208818, rel=1e-5)
    aside = {"sphere": {"radius": 10.0, "center": [0.1, 0.05]}}
    moved = values_of(P, {"Mz": 5.0}, coupling="tangential", surface=aside)
    assert moved["phi_z", 1] == found["phi_z", 1]


def smallest(*stages: dict[str, float], **parts: Any) -> tuple[int, float, str] | None:
    found = forms_of(*stages, **parts).smallest_stick
    return None if found is None else (found.stage, found.value, found.source)


def test_smallest_stick_zone() -> None:
    path = [P, {"Qx": 20.0}, {"Qx": -36.0}, {"Qx": 0.0}]
    assert smallest(*path) == (2, pytest.approx(0.139761, abs=1e-6), "Cattaneo-Mindlin")
    assert smallest(P, {"Mz": 5.0}) == (1, pytest.approx(0.208818, abs=1e-6), "Lubkin")
    spence = smallest(P, bodies=DISSIMILAR)
    assert spence == (0, pytest.approx(0.5102 * 0.301107, rel=1e-3), "Spence")


GROSS = cattaneo_mindlin(HERTZ, FRICTION, FRICTION * 400.0, MATERIAL.tangential).delta_x


def test_smallest_stick_zone_under_a_displacement() -> None:
    """c = a sqrt(1 - delta/delta_g), the largest displacement of the path counting."""
    path = [P, {"delta_x": 0.2 * GROSS}, {"delta_x": -0.75 * GROSS}, {"delta_x": 0.0}]
    half = pytest.approx(0.5 * HERTZ.contact_radius, rel=1e-12)
    assert smallest(*path) == (2, half, "Cattaneo-Mindlin")
    oblique = {"delta_x": 0.45 * GROSS, "delta_y": 0.6 * GROSS}
    assert smallest({"delta_z": HERTZ.delta_z}, oblique) == (1, half, "Cattaneo-Mindlin")
    force = 40.0 * (1.0 - 0.25**1.5)
    assert smallest(P, {"Qx": force}) == (1, half, "Cattaneo-Mindlin")


@pytest.mark.parametrize(
    ("stages", "parts"),
    [
        ([P, {"Mz": 7.2}], {}),  # everything slips
        ([P, {"Qx": 40.0}], {}),
        ([P, {"Qx": 20.0, "Mz": 1.0}], {}),
        ([P, {"Qx": 20.0, "P": 500.0}], {}),
        ([P, {"delta_x": GROSS}], {}),
        ([{"P": 400.0, "delta_x": 1e-4}], {}),  # sheared as it is pressed
        ([P, {"delta_x": 1e-4, "Qy": 1.0}], {}),
        ([P, {"delta_x": 1e-4, "phi_z": 1e-4}], {}),
        ([P, {"delta_x": 1e-4}, {"Qx": 0.0}], {}),
        ([P, {"delta_x": 1e-4}, {"P": 500.0}], {}),
        ([P, {"delta_x": 1e-4}, {"delta_y": 1e-4}], {}),
        ([P, {"delta_x": 1e-4}], {"bodies": DISSIMILAR}),
        ([P, {"Qx": 20.0}], {"friction": 0.0}),
        ([P, {"Qx": 20.0}], {"bodies": DISSIMILAR}),
        ([P, {"Qx": 20.0}], {"surface": {"cylinder": {"radius": 1.0, "axis": "x", "length": 1.0}}}),
    ],
)
def test_where_no_closed_form_gives_the_stick_zone(stages: list[Any], parts: dict[str, Any]) -> None:
    assert smallest(*stages, **parts) is None
