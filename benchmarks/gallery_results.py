"""The results that pictures of the documents show, and what several pictures take from them."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretsolve.model.materials import Compliances, compliances
from fretsolve.reference.hertz import HertzContact, hertz_sphere
from fretsolve.result import Result, open_result
from fretsolve.system.arrays import DoubleArray

ROOT = Path(__file__).resolve().parent.parent
CASES = ROOT / "cases"

LOAD, RADIUS, FRICTION, TORQUE, DUNDURS = 400.0, 10.0, 0.1, 5.0, 0.1938
"""The base case: N, mm, 1, N mm, 1."""

MODE_1 = {"I.1": "mode1_similar_uncoupled", "I.2": "mode1_similar", "I.3": "mode1_dissimilar"}

_folder = tempfile.TemporaryDirectory(prefix="gallery")
FOLDER = Path(_folder.name)
"""Of the results and of cases from pages, removed at the end."""


@cache
def solved(case: Path, *overrides: str) -> Result:
    """Return the result of a case, which is run once."""
    out = FOLDER / f"{solved.cache_info().currsize}.h5"
    sets = [word for override in overrides for word in ("--set", override)]
    subprocess.run([sys.executable, "-m", "fretsolve", "run", case, "-o", out, "-q", *sets], check=True)
    return open_result(out)


def shipped(name: str, *overrides: str) -> Result:
    """Return the result of a shipped case."""
    return solved(CASES / f"{name}.yaml", *overrides)


def end_of_stage(result: Result, stage: int) -> int:
    """Return the last increment of a stage, counted from 1."""
    return int(np.flatnonzero(result.history["stage"] == stage)[-1])


def base_compliances() -> Compliances:
    """Return the compliances of the base case; the dissimilar bodies have the same contact modulus."""
    case = shipped("mode1_similar").case
    assert case is not None
    return compliances(*case.bodies)


def hertz(load: float = LOAD) -> HertzContact:
    """Return Hertz's contact of the base case."""
    return hertz_sphere(load, RADIUS, base_compliances().contact_modulus)


def along_x(result: Result, name: str, step: int) -> tuple[DoubleArray, DoubleArray]:
    """Return x/a and a field, or the length of a vector field, midway between the two middle rows of cells."""
    field = result.field(name, step)
    middle = field.shape[-1] // 2
    row = 0.5 * (field[..., middle - 1] + field[..., middle])
    return result.x / hertz().contact_radius, np.hypot(*row) if row.ndim == 2 else row


def panels(rows: int, columns: int, size: tuple[float, float], **options: bool) -> tuple[Figure, list[Axes]]:
    """Return a figure with its axes."""
    figure = Figure(figsize=(columns * size[0], rows * size[1]), layout="constrained")
    return figure, list(np.ravel(figure.subplots(rows, columns, squeeze=False, **options)))
