"""Compute the stress that a request asks for, one layer at a time.

Layers are outermost, so that the coefficients of one layer alone are in memory; increments are innermost, so that these
are computed once for many of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from fretsolve.elastic.fftw import load_wisdom, save_wisdom
from fretsolve.stress.influence import Body
from fretsolve.stress.layers import LayerConvolution
from fretsolve.stress.request import StressRequest
from fretsolve.stress.tractions import TractionHistory
from fretsolve.system.arrays import DoubleArray

MEASURED_FROM = 200
"""Layers of increments from which faster plans of the transforms are worth the time to measure them."""


@dataclass(frozen=True, eq=False)
class Layer:
    """The stress of increment number `step_index` of a request at depth number `depth_index`: (6, nx, ny) in MPa."""

    body: Body
    depth_index: int
    step_index: int
    stress: DoubleArray


def layers(tractions: TractionHistory, request: StressRequest, threads: int = 1) -> Iterator[Layer]:
    """Yield the stress of all layers with the bulk stress of the body, `request.group` increments of each at a time."""
    grid = tractions.grid
    measured = len(request.depths) * len(request.steps) * len(request.bodies) >= MEASURED_FROM
    if measured:
        load_wisdom()
    convolution = LayerConvolution(
        (grid.dx, grid.dy), request.source, request.target, request.tractions, threads, measured, tractions.plane_strain
    )
    if measured:
        save_wisdom()
    ratios = {body: tractions.poisson_ratios[body] for body in request.bodies}
    for start in range(0, len(request.steps), request.group):
        numbers = range(start, min(start + request.group, len(request.steps)))
        spectra = {
            index: convolution.forward(tractions.read(request.steps[index], request.source, request.tractions))
            for index in numbers
        }
        for depth_index, depth in enumerate(request.depths):
            potentials = convolution.potentials(depth, ratios)
            for body, nu in ratios.items():
                kernels = convolution.kernels(potentials, depth, nu, body)
                for index in numbers:
                    stress = convolution.stress(kernels, spectra[index])
                    for row, bulk in zip((0, 1, 3), tractions.bulk_stress(body, request.steps[index]), strict=True):
                        if bulk:
                            stress[row] += bulk
                    yield Layer(body, depth_index, index, stress)
