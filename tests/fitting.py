"""Loops for fits: those of Cattaneo and Mindlin with a spring in series, and records of them with noise and drift."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.signal import lfilter

from fretsolve.errors import SlidingError
from fretsolve.sweep.fit.model_loop import Branches, LoopModel

P, RADIUS, SHEAR = 400.0, 0.301107, 4.42e-5
"""Of the base case: normal force (N), radius of the contact (mm), tangential compliance of both bodies (1/MPa)."""

Array = NDArray[np.float64]

FIT_CASE = """\
title: rig of the laboratory
bodies:
  - {young_modulus: 200 GPa, poisson_ratio: 0.3}   # both of one steel
  - {young_modulus: 200 GPa, poisson_ratio: 0.3}
surface: {sphere: {radius: 10 mm}}
grid: {points: 24}
friction: 0.14
rig: {stiffness_x: 70 kN/mm}   # from its data sheet
load_path:
  - {P: 400 N}
  - {actuator_x: 4 um, increments: 20}
"""


def mindlin_branch(friction: float, stiffness: float, reach: float, soft: float = 1.0) -> tuple[Array, Array]:
    """Motion of the actuator (mm) and force (N) from the turn at `reach` to the one at `-reach`, once settled.

    stiffness: of the spring in series (N/mm); soft: compliance of the bodies over that of steel.
    """
    slip = friction * P
    whole = 3.0 * slip * soft * SHEAR / (16.0 * RADIUS)

    def motion(force: Array) -> Array:
        return whole * (1.0 - (1.0 - force / slip) ** (2.0 / 3.0)) + force / stiffness

    # from a turn on the force falls along the first loading, twice as large (Masing)
    most = slip if motion(np.array(slip)) <= reach else brentq(lambda force: motion(np.array(force)) - reach, 0.0, slip)
    steps = most * (1.0 - np.linspace(1.0, 0.0, 400) ** 1.5)
    found, force = reach - 2.0 * motion(steps), most - 2.0 * steps
    if found[-1] > -(1.0 - 1e-6) * reach:
        found, force = (
            np.append(found, np.linspace(found[-1], -reach, 20)[1:]),
            np.append(force, np.full(19, force[-1])),
        )
    return found, force


def mindlin_branches(model: LoopModel, values: Sequence[float]) -> Branches:
    """Cattaneo's and Mindlin's loop in place of `LoopModel.branches`.

    The parameters may be friction, rig.stiffness_x (kN/mm), moduli (GPa). Friction below 0.001 has no solution.
    """
    given = {"friction": 0.1, "rig.stiffness_x": 50.0, "bodies.0.young_modulus": 200.0, "bodies.1.young_modulus": 200.0}
    given |= dict(zip([one.name for one in model.parameters], values, strict=True))
    if given["friction"] < 0.001:
        raise SlidingError("nothing holds it")
    soft = 100.0 / given["bodies.0.young_modulus"] + 100.0 / given["bodies.1.young_modulus"]
    reach = 0.5 * abs(model.start - model.ways[0][-1])
    motion, force = mindlin_branch(given["friction"], 1e3 * given["rig.stiffness_x"], reach, soft)
    down, up = (motion, force), (-motion, -force)
    first, second = (down, up) if model.start > model.ways[0][-1] else (up, down)
    slides = bool(force[-1] <= -(1.0 - 1e-9) * given["friction"] * P)
    return Branches((first[0], second[0]), (first[1], second[1]), slides)


def record(
    branch: tuple[Array, Array],
    *,
    seed: int = 0,
    noise: float = 0.0,
    shake: float = 0.0,
    cycles: float = 2.3,
    start: float = 0.2,
    points: int = 200,
    drifts: bool = True,
    slow: float = 0.0,
) -> tuple[Array, Array, Array]:
    """Time (cycles), force (N) and motion (mm) of a sine along a loop, whose way down is `branch`.

    noise, shake: of force and motion, over their amplitudes; drifts: linear drifts and offsets of both; slow:
    correlation of the noise of neighbouring points.
    """
    motion, force = branch
    reach, random = motion[0], np.random.default_rng(seed)
    time = start + np.arange(round(cycles * points)) / points
    moved = reach * np.sin(2.0 * np.pi * time)
    down = ((time - 0.25) % 1.0) < 0.5
    found = np.where(down, np.interp(moved, motion[::-1], force[::-1]), np.interp(moved, -motion, -force))

    def noises() -> Array:
        white = random.standard_normal((300 if slow else 0) + len(time))
        found: Array = np.sqrt(1.0 - slow**2) * lfilter([1.0], [1.0, -slow], white)[-len(time) :]
        return found

    found = found + force[0] * (noise * noises() + drifts * (0.05 * time + 0.1))
    moved = moved + reach * (shake * noises() + drifts * (0.02 * time + 0.3))
    return time, found, moved


def write_record(path: Path, columns: tuple[Array, Array, Array], motion: str = "actuator_x (um)") -> Path:
    """Write a record as a CSV."""
    time, force, moved = columns
    rows = [f"{t:.4f},{q:.6g},{1e3 * d:.6g}\n" for t, q, d in zip(time, force, moved, strict=True)]
    path.write_text(f"time (s),Qx (N),{motion}\n{''.join(rows)}")
    return path
