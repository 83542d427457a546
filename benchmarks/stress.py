"""Costs of stresses below the surface, and the tables of their verification.

    python benchmarks/stress.py [--points 512] [--depths 20] [--increments 40] [--into docs/verification.md]

`costs`: one body, six components. Either all cells are loaded, or those of half of the grid's width; the stress of the
whole grid, or that of the window around the contact. `bare` is the time of eight inverse transforms of the padded grid
per depth and increment, with plans of the same kind. Processor time of one thread; a few increments and depths are
timed and multiplied, since each costs the same. `MB` is by how much the largest memory of the process grows.

`edge` and `inside`: how the largest tension at the trailing edge, and the stress at a point below the surface, converge
with the cells.
"""

from __future__ import annotations

import math
import resource
import time
from collections.abc import Callable, Iterator

import numpy as np
from helpers import parser_of, report

from fretsolve.elastic.fftw import plan, pyfftw
from fretsolve.post.stress.edge import EdgeExtrapolation
from fretsolve.post.stress.influence import point_influence
from fretsolve.post.stress.layers import LayerConvolution, Window
from fretsolve.problem.model.grid import Grid

TIMED_DEPTHS, TIMED_INCREMENTS = 3, 8
NU, MU = 0.3, 0.4
EXACT_TENSION = (1 - 2 * NU) / 3 + MU * math.pi * (4 + NU) / 8
POINT, EXACT = (0.6, 0.0, 0.1), (-0.76726, -0.54532, -0.81332, 0.0, -0.31145, 0.0)


def sphere(cells: int, margin: float = 1.3) -> tuple[Grid, dict[str, np.ndarray]]:
    """Return a grid with `cells` per radius and the mean tractions in its cells of a sphere that slides along x."""
    half, parts = math.ceil(margin * cells), 16
    fine = ((np.arange(2 * half * parts) + 0.5) / parts - half) / cells
    pressure = np.sqrt(np.maximum(0.0, 1.0 - fine[:, None] ** 2 - fine**2))
    pressure = pressure.reshape(2 * half, parts, 2 * half, parts).mean(axis=(1, 3))
    return Grid(2 * half, 2 * half, 1 / cells, 1 / cells), {"p": pressure, "qx": MU * pressure, "qy": 0 * pressure}


def spent(work: Callable[[], object], repeat: int = 3) -> float:
    """Return the least processor time of a call."""
    times = []
    for _ in range(repeat):
        began = time.process_time()
        work()
        times.append(time.process_time() - began)
    return min(times)


def cost_rows(points: int, depths: int, increments: int) -> Iterator[str]:
    """Return rows of the table of costs."""
    contact = slice(points // 4, 3 * points // 4)
    margin = slice(points // 8, 7 * points // 8)
    whole = slice(0, points)
    yield "| stress of | padded grid | transforms | s | bare, s | ratio | MB |"
    yield "| --- | --- | --- | --- | --- | --- | --- |"
    for name, source, target in (
        ("the whole grid, all cells loaded", whole, whole),
        ("the whole grid", contact, whole),
        ("the window", contact, margin),
    ):
        yield _cost_row(name, (source, source), (target, target), depths, increments)


def _cost_row(name: str, source: Window, target: Window, depths: int, increments: int) -> str:
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    convolution = LayerConvolution((0.01, 0.01), source, target, measured=True)
    shape = tuple(one.stop - one.start for one in source)
    random = np.random.default_rng(1)
    fields = {one: random.random(shape) for one in ("p", "qx", "qy")}
    spectra = [convolution.forward(fields) for _ in range(increments)]
    forward = spent(lambda: convolution.forward(fields))
    each_depth = each_layer = 0.0
    for depth in np.linspace(0.0, 0.5, TIMED_DEPTHS):
        found = {}
        each_depth += spent(lambda: found.update(convolution.potentials(depth, {2: NU})), 2) / TIMED_DEPTHS  # noqa: B023
        each_depth += spent(lambda: convolution.kernels(found, depth, NU, 2), 2) / TIMED_DEPTHS  # noqa: B023
        kernels = convolution.kernels(found, depth, NU, 2)
        stress = min(
            spent(lambda one=one: convolution.stress(kernels, spectra[one]), 1)  # noqa: B023
            for one in range(min(TIMED_INCREMENTS, increments))
        )
        each_layer += stress / TIMED_DEPTHS
    total = increments * forward + depths * each_depth + depths * increments * each_layer
    mx, my = convolution.padded
    values, spectrum = pyfftw.zeros_aligned((mx, my)), pyfftw.zeros_aligned((mx, my // 2 + 1), np.complex128)
    flags = ("FFTW_MEASURE", "FFTW_DESTROY_INPUT")
    inverse = plan(spectrum, values, axes=(0, 1), direction="FFTW_BACKWARD", flags=flags)
    bare = 8 * depths * increments * spent(inverse.execute, 8)
    # A kernel's transform is that of a quarter.
    transforms = 6 + 3 / depths + 14 / 4 / increments
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
    memory = f"{grown:.0f}" if grown > 100 else "less"
    return f"| {name} | {mx} x {my} | {transforms:.1f} | {total:.3g} | {bare:.3g} | {total / bare:.2f} | {memory} |"


def edge_rows() -> Iterator[str]:
    """Return rows of the largest tension at the trailing edge."""
    yield "| cells per radius | extrapolated | deviation, % | estimated error |"
    yield "| --- | --- | --- | --- |"
    for cells in (10, 20, 40, 80, 160):
        grid, fields = sphere(cells)
        whole = slice(0, grid.nx), slice(0, grid.ny)
        extrapolation = EdgeExtrapolation(grid, whole, whole, {2: NU}, ("p", "qx"))
        found = extrapolation.estimates(fields, {2: np.zeros(3)})[2, "tension"]
        yield f"| {cells} | {found.value:.4f} | {100 * (found.value / EXACT_TENSION - 1):+.2f} | {found.error:.3f} |"


def inside_rows() -> Iterator[str]:
    """Return rows of the error at a point below the surface."""
    yield "| cells per radius | largest error of a component |"
    yield "| --- | --- |"
    for cells in (10, 20, 40, 80, 160):
        grid, fields = sphere(cells)
        found = point_influence(grid, POINT, NU, 2).stress(fields)
        yield f"| {cells} | {np.abs(found - EXACT).max():.1e} |"


def main() -> None:
    """Print the tables, or write them between their marks."""
    parser = parser_of(__doc__)
    for name, default in (("points", 512), ("depths", 20), ("increments", 40)):
        parser.add_argument(f"--{name}", type=int, default=default)
    options = parser.parse_args()
    parts = {
        "stress costs": lambda: print(*cost_rows(options.points, options.depths, options.increments), sep="\n"),
        "stress edge": lambda: print(*edge_rows(), sep="\n"),
        "stress inside": lambda: print(*inside_rows(), sep="\n"),
    }
    report(parts, options.into)


if __name__ == "__main__":
    main()
