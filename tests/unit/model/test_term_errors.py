"""Expected errors of terms left out, against runs with and without them."""

from __future__ import annotations

import pytest
from solving import DISSIMILAR, RADIUS, build, solve

from fretsolve.model.required_terms import derive_model
from fretsolve.model.term_errors import coupling_errors, cross_errors, negligible_coupling

RIGID = ("rigid", {"young_modulus": 200e3, "poisson_ratio": 0.3})
GRID = {"points": 40, "size": 0.85}
PATHS = {
    "pressing": [{"P": 400.0, "increments": 8}],
    "force": [{"P": 400.0, "increments": 8}, {"Qx": 72.0, "increments": 8}],
    "torque": [{"P": 400.0, "increments": 8}, {"Mz": 12.77, "Qx": 0.0, "Qy": 0.0, "increments": 8}],
}
"""With friction 0.2: nine tenths of sliding."""

MOTION = {"pressing": "", "force": "delta_x", "torque": "phi_z"}


def material(bodies):
    return derive_model(build(bodies=bodies, grid={"points": 2})).compliances


def errors(bodies, drive, less, more):
    """Errors of what `less` leaves out, by quantity: those of the pressure after pressing, the others at the end."""
    ends = []
    for coupling in (less, more):
        states = solve(bodies=bodies, grid=GRID, friction=0.2, load_path=PATHS[drive], coupling=coupling)
        ends.append((states[7].summary, states[-1].summary))
    (pressed, peak), (true_pressed, true_peak) = ends
    found = {}
    for name in ("delta_z", "contact_radius", "max_pressure"):
        found[name] = abs(getattr(pressed, name) / getattr(true_pressed, name) - 1.0)
    for name in filter(None, (MOTION[drive], "work_total")):
        found[name] = abs(getattr(peak, name) / getattr(true_peak, name) - 1.0)
    found["stick_radius"] = abs(peak.stick_radius - true_peak.stick_radius) / true_peak.contact_radius
    return found


@pytest.mark.parametrize("drive", ["pressing", "force", "torque"])
def test_coupling_is_expected_to_cost_what_it_does(drive):
    """Within a factor of two, with Dundurs' constant and friction the same."""
    found = errors(DISSIMILAR, drive, "tangential", "full")
    expected = list(coupling_errors(material(DISSIMILAR), 0.2, drive, MOTION[drive]))
    assert {error.quantity for error in expected} == set(found)
    for error in expected:
        assert 0.5 < error.share / found[error.quantity] < 2.0, error


@pytest.mark.parametrize("drive", ["force", "torque"])
def test_cross_influence_is_expected_to_cost_what_it_does(drive):
    bodies = ({"young_modulus": 200e3, "poisson_ratio": 0.4},) * 2
    found = errors(bodies, drive, "none", "tangential")
    tolerated = {"force": 1.5, "torque": 1.03}[drive]
    for error in cross_errors(material(bodies), drive, MOTION[drive]):
        assert 1.0 / tolerated < error.share / found[error.quantity] < tolerated, error


def test_equal_bodies_lose_nothing():
    equal = material(({"young_modulus": 1.0, "poisson_ratio": 0.3},) * 2)
    for drive in PATHS:
        assert all(error.share == 0.0 for error in coupling_errors(equal, 0.1, drive, MOTION[drive]))
    assert negligible_coupling(equal, 0.1, 1e-15)


def test_errors_grow_with_dissimilarity_and_stay_below_all():
    for drive in PATHS:
        for friction in (1e-6, 0.05, 1.0, 1e3):
            before = dict.fromkeys((error.quantity for error in coupling_errors(material(RIGID), 0.1, drive)), 0.0)
            for ratio in (0.499, 0.45, 0.3, 0.0):
                pair = material(("rigid", {"young_modulus": RADIUS, "poisson_ratio": ratio}))
                for error in coupling_errors(pair, friction, drive):
                    assert before[error.quantity] <= error.share <= 1.0
                    before[error.quantity] = error.share
