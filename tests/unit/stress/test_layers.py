from __future__ import annotations

import numpy as np
import pytest

from fretsolve.model.grid import Grid
from fretsolve.stress.influence import point_influence
from fretsolve.stress.layers import LayerConvolution

GRID = Grid(13, 10, 0.02, 0.03, 0.01, -0.02)
WHOLE = slice(0, 13), slice(0, 10)
WINDOWS = [(WHOLE, WHOLE), ((slice(3, 9), slice(2, 7)), WHOLE), (WHOLE, (slice(4, 13), slice(6, 7)))]
WINDOWS.append(((slice(8, 12), slice(1, 4)), (slice(0, 3), slice(5, 10))))


def random_tractions(source, seed=1):
    values = np.random.default_rng(seed).normal(size=(3, *GRID.shape))
    inside = np.zeros(GRID.shape)
    inside[source] = 1.0
    return dict(zip(("p", "qx", "qy"), values * inside, strict=True))


@pytest.mark.parametrize(("source", "target"), WINDOWS)
@pytest.mark.parametrize("depth", [0.0, 0.01, 0.2])
@pytest.mark.parametrize("body", [1, 2])
def test_convolution_is_the_direct_sum(source, target, depth, body):
    """To rounding, for all cells of several windows."""
    tractions, nu = random_tractions(source), 0.27
    layer = LayerConvolution((GRID.dx, GRID.dy), source, target)
    kernels = layer.kernels(layer.potentials(depth, {body: nu}), depth, nu, body)
    found = layer.stress(kernels, layer.forward({name: field[source] for name, field in tractions.items()}))
    cells = [(i, j) for i in range(*target[0].indices(99)) for j in range(*target[1].indices(99))]
    for i, j in cells[:: max(1, len(cells) // 12)]:
        exact = point_influence(GRID, (GRID.x[i], GRID.y[j], depth), nu, body).stress(tractions)
        np.testing.assert_allclose(found[:, i - target[0].start, j - target[1].start], exact, rtol=0, atol=1e-13)


@pytest.mark.parametrize("kept", [("p",), ("p", "qx"), ("p", "qy"), ("qx",)])
def test_tractions_that_are_0_may_be_left_out(kept):
    tractions = {name: field * (name in kept) for name, field in random_tractions(WHOLE).items()}
    results = []
    for names in (kept, ("p", "qx", "qy")):
        layer = LayerConvolution((GRID.dx, GRID.dy), WHOLE, WHOLE, names)
        kernels = layer.kernels(layer.potentials(0.05, {2: 0.3}), 0.05, 0.3, 2)
        results.append(layer.stress(kernels, layer.forward(tractions)))
    np.testing.assert_allclose(*results, rtol=0, atol=1e-14)


def test_threads_give_the_same_bits():
    tractions, results = random_tractions(WHOLE), []
    for threads in (1, 3):
        layer = LayerConvolution((GRID.dx, GRID.dy), WHOLE, WHOLE, threads=threads)
        kernels = layer.kernels(layer.potentials(0.05, {2: 0.3}), 0.05, 0.3, 2)
        results.append(layer.stress(kernels, layer.forward(tractions)))
    np.testing.assert_array_equal(*results)


def test_a_layer_carries_the_loads():
    """The integral of zz is -P, of xz -Qx and of yz -Qy, less the few per cent of shear that pass outside of the grid.

    Those are integrated from the point solution of Cerruti.
    """
    half, depth = 4.0, 0.1
    grid = Grid.from_size((256, 256), (2 * half, 2 * half))
    loaded = (grid.x[:, None] ** 2 + grid.y**2) < 0.2**2
    whole = slice(0, 256), slice(0, 256)
    layer = LayerConvolution((grid.dx, grid.dy), whole, whole)
    tractions = {"p": 1.0 * loaded, "qx": 0.3 * loaded, "qy": -0.1 * loaded}
    kernels = layer.kernels(layer.potentials(depth, {2: 0.3}), depth, 0.3, 2)
    total = layer.stress(kernels, layer.forward(tractions)).sum(axis=(1, 2)) / loaded.sum()
    assert total[2] == pytest.approx(-1.0, rel=1e-3)

    angles = (np.arange(720) + 0.5) * np.pi / 360.0
    edge = half / np.maximum(np.abs(np.cos(angles)), np.abs(np.sin(angles)))
    # The integral of 3 x^2 z/(2 pi rho^5) along each angle from there on.
    far = 1.0 / np.hypot(edge, depth)
    lost = np.sum(np.cos(angles) ** 2 * (3.0 * depth * far - (depth * far) ** 3)) / 720.0
    assert total[4] == pytest.approx(-0.3 * (1.0 - lost), rel=1e-3)
    assert total[5] == pytest.approx(0.1 * (1.0 - lost), rel=1e-3)
