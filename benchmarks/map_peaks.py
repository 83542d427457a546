"""How the bar of the largest pressure holds on maps whose waves are some cells long, with and without what it holds of
the pressure between the cells.

    python benchmarks/map_peaks.py [--maps 24]

Spheres of 10 mm with sines in random directions on 36 x 36 cells, pressed by 400 N, against 180 x 180 cells.
"""

from __future__ import annotations

import argparse
import math
import statistics
import tempfile
from pathlib import Path

import numpy as np

import fretsolve
from fretsolve.setup.problem_setup import set_up
from fretsolve.simulation.error_bars.error_bars import run_with_error_bars
from fretsolve.simulation.error_bars.least_errors import least_errors

STEEL = "{young_modulus: 200 GPa, poisson_ratio: 0.3}"
CASE = """\
bodies: [{steel}, {steel}]
surface: [{{sphere: {{radius: 10 mm}}}}, {{heights: {{file: {file}, spacing: 5 um}}}}]
friction: 0
grid: {{points: {points}, size: 1 mm}}
load_path: [{{P: 400 N}}]
"""
POINTS, FINE_POINTS, HEIGHT = 36, 180, 2.5e-4


def write_map(file: Path, seed: int, waves: int, cells: tuple[float, float]) -> None:
    """Write a map of `waves` sines that are so many cells long, of 0.25 um over the root of their number."""
    random, axis = np.random.default_rng(seed), np.linspace(-1.0, 1.0, 401)
    x, y = np.meshgrid(axis, axis, indexing="ij")
    heights = np.zeros_like(x)
    for _ in range(waves):
        turn, length, phase = (
            random.uniform(0.0, np.pi),
            random.uniform(*cells) / POINTS,
            random.uniform(0.0, 2.0 * np.pi),
        )
        heights += np.sin(2.0 * np.pi / length * (x * np.cos(turn) + y * np.sin(turn)) + phase)
    np.save(file, HEIGHT / math.sqrt(waves) * heights)


def ratios(folder: Path, maps: int, waves: int, cells: tuple[float, float]) -> dict[str, list[float]]:
    """Return the true error over the bar on each map, with and without the pressure between the cells."""
    found: dict[str, list[float]] = {"without": [], "with": []}
    weights = least_errors.BETWEEN_CELLS, least_errors.IN_CELLS
    for seed in range(maps):
        write_map(folder / "map.npy", seed, waves, cells)
        setups = []
        for points in (FINE_POINTS, POINTS):
            (folder / "case.yaml").write_text(CASE.format(steel=STEEL, file=folder / "map.npy", points=points))
            setups.append(set_up(fretsolve.load_case(folder / "case.yaml")))
        (fine,) = fretsolve.run(setups[0])
        for name, scale in (("without", 0.0), ("with", 1.0)):
            least_errors.BETWEEN_CELLS, least_errors.IN_CELLS = (scale * weight for weight in weights)
            (state,) = run_with_error_bars(setups[1])
            assert state.errors is not None
            error = abs(state.summary.max_pressure - fine.summary.max_pressure)
            found[name].append(error / state.errors.max_pressure_error)
    return found


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--maps", type=int, default=24)
    maps = parser.parse_args().maps
    print("| waves | cells long | between the cells | inside | largest error over bar | median of bar over error |")
    print("| --- " * 6 + "|")
    with tempfile.TemporaryDirectory() as folder:
        for waves, cells in ((1, (4, 8)), (6, (4, 8)), (6, (8, 16))):
            for name, found in ratios(Path(folder), maps, waves, cells).items():
                inside, median = sum(ratio <= 1.0 for ratio in found), statistics.median(1.0 / ratio for ratio in found)
                numbers = f"{inside} of {len(found)} | {max(found):.1f} | {median:.1f}"
                print(f"| {waves} | {cells[0]} to {cells[1]} | {name} | {numbers} |", flush=True)


if __name__ == "__main__":
    main()
