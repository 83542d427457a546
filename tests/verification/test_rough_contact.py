"""Real contact area of a rough flat under small loads, against the linear law A = kappa P / (E* h') of the literature.

h' is the root mean square slope. Persson's theory has kappa = sqrt(8/pi) = 1.6, and Bush, Gibson and Thomas sqrt(2 pi)
= 2.5 in the limit of vanishing area; computed surfaces have 1.8 to 2.2 (Hyun and Robbins, Tribol. Int. 40, 2007;
Yastrebov, Anciaux and Molinari, Int. J. Solids Struct. 52, 2015), more the fewer waves there are between rolloff and
cutoff. A cell counts whole where it is in contact in part; the last of these authors take (pi - 1 + ln 2)/24 S dx off
the area for the perimeter S, measured along the sides of cells.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache

import numpy as np
import pytest
from solving import MATERIAL, build

from fretsolve import run

PERSSON, BUSH_GIBSON_THOMAS = math.sqrt(8.0 / math.pi), math.sqrt(2.0 * math.pi)
SIDE, SLOPE = 1.0, 0.02
RIM = 2
"""Cells beyond the flat, on each side of the grid."""


@cache
def kappa(points: int, waves: int, seed: int, rolloff: float = SIDE / 4) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return real over nominal area of a flat, kappa by the cells and kappa without the perimeter's part, per load.

    points: cells along the flat; waves: of the shortest ones along it.
    """
    roughness = {
        "hurst": 0.8,
        "rms_slope": SLOPE,
        "rolloff": rolloff,
        "cutoff": SIDE / waves,
        "span": SIDE,
        "seed": seed,
    }
    cell, load = SIDE / points, MATERIAL.contact_modulus * SLOPE * SIDE**2
    case = build(
        surface=[{"punch": {"half_width": SIDE / 2}}, {"roughness": roughness}],
        grid={"points": points + 2 * RIM, "size": cell * (points + 2 * RIM)},
        load_path=[{"P": 0.5 * part * load, "increments": 1} for part in (0.01, 0.02, 0.05)],
        solver={"tolerance": 1e-5},
    )
    found = []
    for state in run(case):
        contact, force = state.fields.pressure > 0.0, state.summary.P
        area = np.count_nonzero(contact) * cell**2
        perimeter = cell * sum(np.count_nonzero(np.diff(contact, axis=axis)) for axis in (0, 1))
        excess = (math.pi - 1.0 + math.log(2.0)) / 24.0 * perimeter * cell
        found.append((area / SIDE**2, area * load / force, (area - excess) * load / force))
    part, raw, corrected = np.array(found).T / np.array([[1.0], [SIDE**2], [SIDE**2]])
    return part, raw, corrected


def mean_and_error(values: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean over seeds and its standard error, per load."""
    return np.mean(values, axis=0), np.std(values, axis=0, ddof=1) / math.sqrt(len(values))


@pytest.mark.slow
def test_area_is_proportional_to_the_load_within_the_literature():
    parts, raw, corrected = zip(*(kappa(256, 32, seed, SIDE / 8) for seed in range(1, 7)), strict=True)
    assert np.min(parts) > 0.01 and np.max(parts) < 0.07
    assert (np.array(corrected) < raw).all()
    mean, error = mean_and_error(corrected)
    assert (mean > PERSSON).all() and (mean < BUSH_GIBSON_THOMAS).all()
    assert abs(mean[-1] - 2.0) < 0.2 + 2.0 * error[-1]
    assert mean[-1] == pytest.approx(mean[0], rel=0.08)  # at five times the load


@pytest.mark.slow
@pytest.mark.parametrize("rolloff", [SIDE / 2, SIDE / 4, SIDE / 8])
def test_kappa_is_about_two_on_six_surfaces(rolloff: float):
    mean, error = mean_and_error([kappa(512, 64, seed, rolloff)[2] for seed in range(1, 7)])
    assert (error < 0.06).all()
    assert (np.abs(mean - 2.0) < 0.2 + 2.0 * error).all()


@pytest.mark.slow
def test_kappa_falls_as_more_waves_follow_the_rolloff():
    means = [np.mean([kappa(512, 64, seed, SIDE / n)[2] for seed in range(1, 7)], axis=0) for n in (8, 4, 2)]
    assert (means[0] > means[1]).all() and (means[1] > means[2]).all()


@pytest.mark.slow
def test_grid_changes_kappa_little_and_the_cells_kappa_tends_to_it():
    """The same surfaces on 4, 8 and 16 cells per shortest wave."""
    raw, corrected = (
        np.mean([[kappa(points, 64, seed)[which] for points in (256, 512, 1024)] for seed in (1, 2)], axis=0)
        for which in (1, 2)
    )
    assert corrected[1] == pytest.approx(corrected[2], rel=0.02)
    assert corrected[0] == pytest.approx(corrected[2], rel=0.03)
    assert (np.diff(raw, axis=0) < 0.0).all()
    assert 2.0 * raw[2] - raw[1] == pytest.approx(corrected[2], rel=0.02)
