"""Choose bodies, depths, increments and cells for which the stress of a result is computed, and compute it by layers.

Layers are outermost, so that the coefficients of one layer alone are in memory; increments are innermost, so that these
are computed once for many of them.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fretsolve.case.keys.output_spec import StressSpec
from fretsolve.errors import CaseError
from fretsolve.post.stress.influence import COMPONENTS, TRACTIONS, Body, Component, Traction
from fretsolve.post.stress.layers import LayerConvolution, Window, padded_shape
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.setup.cost_estimate import rounded_bytes
from fretsolve.result import Result
from fretsolve.result.state import stage_ends
from fretsolve.system.arrays import DoubleArray

GRADED = (0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.25, 1.6, 2.0)
"""Depths by default, in contact radii. The largest shear of a Hertzian contact lies at about half a radius."""

MARGIN, LINE_MARGIN = 0.25, 1.5
"""Width of the strip around the contact for which the stress is computed, over the contact's width, and that around a
line contact, whose stress falls more slowly with the distance and costs little."""

SPECTRA_BYTES = 2**30
"""Memory for the spectra of increments. Where they do not fit at once, increments are computed in several groups."""

Plane = Literal["x=0", "y=0"]
WindowKind = Literal["auto", "all"]
WindowChoice = WindowKind | float
"""The contact with a margin in proportion, the whole grid, or the contact with a margin in mm."""


@dataclass(frozen=True)
class StressRequest:
    """Stresses to compute.

    bodies, depths (mm, ascending), steps (increments): six components for each; stored: components that the file keeps.
    source: cells with tractions; tractions: only tractions that are not 0; target: cells whose stress is wanted. They
    may lie outside of the grid, where tractions are 0: before its first cell numbers are negative.
    """

    bodies: tuple[Body, ...]
    depths: tuple[float, ...]
    steps: tuple[int, ...]
    source: Window
    target: Window
    tractions: tuple[Traction, ...]
    stored: tuple[Component, ...] = COMPONENTS

    @property
    def shape(self) -> tuple[int, int]:
        """The number of cells of the target along x and along y."""
        first, second = self.target
        return first.stop - first.start, second.stop - second.start

    @property
    def spectrum_bytes(self) -> int:
        """Memory of the spectra of one increment."""
        length, width = padded_shape(self.source, self.target)
        return 16 * len(self.tractions) * length * (width // 2 + 1)

    @property
    def group(self) -> int:
        """The number of increments that are computed at once."""
        return max(1, min(len(self.steps), SPECTRA_BYTES // self.spectrum_bytes))

    def memory(self, threads: int = 1) -> int:
        """Return the bytes that the computation takes, besides the program."""
        length, width = padded_shape(self.source, self.target)
        quarter, spectrum = 2 * length * width, 8 * length * width
        kernels = 14 * quarter + 18 * 2 * quarter  # of the potentials and of the coefficients
        return self.group * self.spectrum_bytes + kernels + 2 * threads * spectrum + 30 * 8 * math.prod(self.shape)

    @property
    def file_bytes(self) -> int:
        """Size of the file before compression."""
        values = len(self.bodies) * len(self.depths) * len(self.steps) * len(self.stored)
        return 4 * values * math.prod(self.shape)


def stress_request(
    tractions: TractionHistory,
    steps: Sequence[int],
    bodies: Sequence[Body] = (),
    depths: Sequence[float] = (),
    plane: Plane | None = None,
    window: WindowChoice = "auto",
    stored: Sequence[Component] = COMPONENTS,
) -> StressRequest:
    """Return what to compute of the increments `steps`. Raises CaseError.

    bodies: by default body 2, or 1 if that is rigid; depths: by default graded ones to two contact radii. plane: only
    the row of cells nearest to it; window: the contact with a margin, also beyond the grid, or the whole grid.
    """
    elastic, path = tractions.poisson_ratios, tractions.result.path
    for body in bodies:
        if body not in elastic:
            raise CaseError(f"body {body} is rigid, so that it has no stress; leave it out", (), path)
    chosen = tuple(sorted(set(bodies))) or ((2,) if 2 in elastic else tuple(elastic))
    for depth in depths:
        if not 0.0 <= depth < math.inf:
            raise CaseError(f"the depth {depth:g} mm is not one; 0 or more is needed", (), path)
    source, kept = tractions.extent(steps)
    target = _target(tractions, source, plane, window)
    return StressRequest(
        bodies=chosen,
        depths=tuple(sorted(set(depths))) or default_depths(tractions, steps),
        steps=tuple(steps),
        source=source,
        target=target,
        tractions=kept,
        stored=tuple(one for one in COMPONENTS if one in stored),
    )


def default_depths(tractions: TractionHistory, steps: Sequence[int]) -> tuple[float, ...]:
    """Return the surface and graded depths to two contact radii, none of them less than half a cell."""
    grid = tractions.grid
    radius = max(float(tractions.result.history["contact_radius"][step]) for step in steps)
    radius = radius or 0.25 * min(grid.size)
    least = least_depth(tractions)
    return tuple(depth for depth in (factor * radius for factor in GRADED) if depth == 0.0 or depth >= least)


def least_depth(tractions: TractionHistory) -> float:
    """Return half a cell (mm): nearer to the surface the stress shows the steps of the cells' tractions."""
    return 0.5 * max(tractions.grid.dx, tractions.grid.dy)


def warnings_of(request: StressRequest, tractions: TractionHistory) -> list[str]:
    """Return what to tell the user of a request."""
    least = least_depth(tractions)
    shallow = [depth for depth in request.depths if 0.0 < depth < least]
    if not shallow:
        return []
    depths = ", ".join(f"{depth:.4g}" for depth in shallow)
    return [
        f"at {depths} mm the stress shows the steps between cells; 0 or at least half a cell, {least:.4g} mm, is exact"
    ]


AS_OPTIONS = "fewer depths or increments, --plane, or --window auto is needed"
"""What makes a request of the command line smaller."""


def memory_problem(request: StressRequest, threads: int, advice: str = AS_OPTIONS) -> str | None:
    """Return why the computation is too large for this machine, None if it is not; advice: what would help."""
    needed = request.memory(threads)
    if needed > (there := machine_memory()):
        return f"the stresses take {needed / 1e9:.3g} GB of memory, this machine has {there / 1e9:.3g} GB; {advice}"
    return None


def machine_memory() -> float:
    """Return the memory of this machine (bytes), inf if it is unknown."""
    with suppress(ValueError, OSError, AttributeError):
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    return math.inf


def disk_problem(request: StressRequest, free_disk: int | None, advice: str = AS_OPTIONS) -> str | None:
    """Return why the file may not fit on its disk, None if it does or that is unknown; advice: what would help."""
    if free_disk is not None and request.file_bytes > free_disk:
        size, free = rounded_bytes(request.file_bytes), rounded_bytes(free_disk)
        return f"the file of stresses takes up to {size}, {free} are free on its disk; {advice}"
    return None


def cell_centres(grid: Grid, window: Window) -> tuple[DoubleArray, DoubleArray]:
    """Return x and y (mm) of the centres of cells, also of cells outside of the grid."""
    x, y = (
        axis[0] + side * np.arange(of.start, of.stop)
        for axis, side, of in zip((grid.x, grid.y), (grid.dx, grid.dy), window, strict=True)
    )
    return x, y


def is_outermost(cell: Sequence[int], shape: tuple[int, int]) -> bool:
    """Return whether a cell of a window is one of its last along a direction with several."""
    return any(size > 1 and number in (0, size - 1) for number, size in zip(cell, shape, strict=True))


def _target(tractions: TractionHistory, source: Window, plane: Plane | None, window: WindowChoice) -> Window:
    target, grid = [], tractions.grid
    share = LINE_MARGIN if tractions.plane_strain else MARGIN
    for axis, (of, count, side) in enumerate(zip(source, grid.shape, (grid.dx, grid.dy), strict=True)):
        found = slice(0, count)
        if window != "all" and not (axis == 1 and tractions.plane_strain):
            margin = math.ceil(share * (of.stop - of.start) if window == "auto" else window / side) + 2
            found = slice(of.start - margin, of.stop + margin)
        if plane is not None and plane[0] == "xy"[axis]:
            centers = (grid.x, grid.y)[axis]
            row = int(abs(centers).argmin())
            found = slice(row, row + 1)
        target.append(found)
    return target[0], target[1]


AS_KEYS = "fewer depths or components, a larger every, or window: auto is needed"
"""What makes `output.stress` smaller."""


def case_request(tractions: TractionHistory, spec: StressSpec) -> StressRequest:
    """Return what a case asks for of its result. Raises CaseError."""
    return stress_request(
        tractions,
        increments_of(tractions.result, spec.every),
        spec.bodies,
        spec.depths,
        window=spec.window,
        stored=spec.components,
    )


def increments_of(result: Result, every: int | None) -> tuple[int, ...]:
    """Return every n-th increment with fields and the last one, or, for None, the increments at the ends of stages."""
    if every is not None:
        return tuple(step for step in result.steps if (step + 1) % every == 0 or step == result.steps[-1])
    ends = set(stage_ends(result.history["stage"]).tolist())
    return tuple(step for step in result.steps if step in ends or step == result.steps[-1])


def request_before(
    bodies: Sequence[Body],
    depths: Sequence[float],
    increments: int,
    shape: tuple[int, int],
    window: WindowKind = "auto",
    stored: Sequence[Component] = COMPONENTS,
) -> StressRequest:
    """Return what a case asks for that is not solved yet; shape: of its grid.

    bodies, depths: none for the default. Only the window around a contact of a quarter of the grid's width is certain.
    """
    side = 1.0 if window == "all" else 0.4
    nx, ny = (max(1, round(side * points)) for points in shape)
    cells = slice(0, nx), slice(0, ny)
    return StressRequest(
        bodies=tuple(bodies) or (2,),
        depths=tuple(depths) or tuple(map(float, range(len(GRADED)))),
        steps=tuple(range(increments)),
        source=cells,
        target=cells,
        tractions=TRACTIONS,
        stored=tuple(stored),
    )


def room_problem(request: StressRequest, free_disk: int | None, advice: str = AS_KEYS) -> str | None:
    """Return why stresses are too large for this machine, None if they are not; advice: what would help."""
    return memory_problem(request, 1, advice) or disk_problem(request, free_disk, advice)


def increments_before(spec: StressSpec, increments: int, stages: int) -> int:
    """Return at how many increments a case asks for stresses; increments: increments with fields."""
    return min(stages, increments) if spec.every is None else -(-increments // spec.every)


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
    # from so many layers of increments on, faster plans are worth the time to measure them
    measured = len(request.depths) * len(request.steps) * len(request.bodies) >= 200
    convolution = LayerConvolution(
        (grid.dx, grid.dy), request.source, request.target, request.tractions, threads, measured, tractions.plane_strain
    )
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
