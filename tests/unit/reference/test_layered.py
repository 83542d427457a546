"""A circular contact with a layer: full stick against its limits and a solve on rings, and the onset of gross slip."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import ellipk

from fretsolve.reference.hertz import hertz_sphere
from fretsolve.reference.layered import layered_stick_compliance, onset_compliance
from fretsolve.reference.tangential import cattaneo_mindlin

A, S = 0.3, 4e-5
"""Contact radius (mm) and tangential compliance (1/MPa) of bodies with nu = 0 and E' = 4/S."""


def compliance_on_rings(layer: float, count: int) -> float:
    """Solve (K + L) q = 1 on rings that lie closer together at the rim, between the middles of rings."""
    edges = A * np.sin(0.5 * math.pi * np.linspace(0.0, 1.0, count + 1))
    middle, area = 0.5 * (edges[1:] + edges[:-1]), math.pi * np.diff(edges**2)
    r, rho = middle[:, None], middle[None, :]
    nodes, weights = np.polynomial.legendre.leggauss(8)
    matrix = np.zeros((count, count))
    half = 0.5 * np.diff(edges)
    for node, weight in zip(nodes, weights, strict=True):
        rho = middle + half * node
        m = 4.0 * r * rho / (r + rho) ** 2
        matrix += weight * half * 4.0 * rho / (r + rho) * ellipk(np.where(m < 1.0, m, 0.0))
    # a ring's own part: 4 rho/(r + rho) K has the logarithm ln(8 r/|r - rho|) about r, of the mean 1 + ln(8 r/half)
    matrix[np.diag_indices(count)] = 4.0 * half * (1.0 + np.log(8.0 * middle / half))
    q = np.linalg.solve(S / (4.0 * math.pi) * matrix + layer * np.eye(count), np.ones(count))
    return 1.0 / float(q @ area)


@pytest.mark.parametrize("share", [0.1, 1.0, 10.0])
def test_full_stick_is_that_of_rings(share: float) -> None:
    layer = share * A * S / 4.0
    assert layered_stick_compliance(A, S, layer) == pytest.approx(compliance_on_rings(layer, 300), rel=2e-3)


def test_full_stick_without_a_layer_is_mindlins_and_near_it_with_a_thin_one() -> None:
    assert layered_stick_compliance(A, S, 0.0) == S / (8.0 * A)
    assert layered_stick_compliance(A, S, 1e-8 * A * S) == pytest.approx(S / (8.0 * A), rel=1e-5)


def test_full_stick_on_a_very_compliant_layer_is_a_bed_of_springs() -> None:
    """The bodies add the displacement of a uniform traction, 8/(3 pi) of q a S on average."""
    layer = 1e3 * A * S
    springs = layer / (math.pi * A**2)
    bodies = S / (4.0 * math.pi) * 16.0 / 3.0 * A / (math.pi * A**2)
    assert layered_stick_compliance(A, S, layer) == pytest.approx(springs + bodies, rel=1e-7)


@pytest.mark.parametrize(("share", "stiffness"), [(0.5, 1.45866476), (1.0, 1.17673181), (10.0, 0.2686520049)])
def test_full_stick_does_not_depend_on_the_number_of_polynomials(share: float, stiffness: float) -> None:
    """Q/(E' a delta), from 160 polynomials."""
    assert layered_stick_compliance(A, S, share * A * S / 4.0) * 4.0 / S * A == pytest.approx(1.0 / stiffness, rel=1e-8)


def test_gross_slip_begins_at_mindlins_displacement_and_the_layers_in_the_middle() -> None:
    hertz, friction, layer = hertz_sphere(400.0, 10.0, 1e5), 0.1, 2e-6
    compliance = onset_compliance(hertz.contact_radius, S, layer)
    found = cattaneo_mindlin(hertz, friction, friction * 400.0, compliance).delta_x
    bodies = 3.0 * S * friction * 400.0 / (16.0 * hertz.contact_radius)
    assert found == pytest.approx(bodies + layer * friction * hertz.max_pressure)
