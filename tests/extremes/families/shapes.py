"""Contacts of one cell and of thousands of spots, rings, sharp ones and flat ones, and height maps of every kind."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, label
from solving import LOAD

from fretsolve.errors import CaseError, GridEdgeError, NotConvergedError, SlidingError

from .driving import Family, Parts, Probe, Run, by, led
from .limits import material, of_cone, of_ellipse, of_hertz, of_punch, of_superposition, off, worst
from .pairs import PLAIN

FloatArray = NDArray[np.float64]
SHEARED = [{"P": LOAD}, {"Qx": 20.0, "increments": 2}]
SIDE = np.linspace(-0.5, 0.5, 101)
SPHERE = {"sphere": {"radius": 10.0}}


def plain(surface: object, **parts: object) -> Parts:
    """Bodies whose shear is Jaeger's superposition, on any surface."""
    whole: Parts = led(load_path=SHEARED, bodies=PLAIN, surface=surface, solver={"tolerance": 1e-8})
    return whole | parts


def cells(count: int) -> Callable[[Run], float]:
    """Return whether so many cells are in contact: 0 or infinite."""
    return lambda run: 0.0 if np.count_nonzero(run.last.fields.pressure) == count else math.inf


def spots(least: int) -> Callable[[Run], float]:
    """Return whether there are that many separate contacts: 0 or infinite."""
    return lambda run: 0.0 if label(run.last.fields.pressure > 0.0)[1] >= least else math.inf


def of_one_cell(run: Run) -> float:
    """Approach of a single cell at the origin: its own compliance, 4 ln(1 + sqrt 2) h p/pi E*."""
    own = 4.0 * math.log(1.0 + math.sqrt(2.0)) * run.cell / (math.pi * material(run).contact_modulus)
    return off(run.end.delta_z, own * run.end.P / run.cell**2)


def bump(depth: float, at: tuple[int, int] = (50, 50)) -> FloatArray:
    """A spike of so many mm on the flat map."""
    heights = np.zeros((101, 101))
    heights[at] -= depth
    return heights


def pit(depth: float) -> FloatArray:
    """A hole in the middle of the flat map."""
    return bump(-depth)


def step(height: float) -> FloatArray:
    """Half of a flat map so much further away."""
    return np.where(SIDE[:, None] > 0.0, height, 0.0) + np.zeros((1, 101))


def holes(share: float) -> FloatArray:
    """A flat map with a share of its points missing."""
    return np.where(np.random.default_rng(0).random((101, 101)) < share, np.nan, 0.0)


def rough(amplitude: float, width: float) -> FloatArray:
    """Random heights of a standard deviation in mm, smoothed over so many points."""
    heights = np.random.default_rng(1).standard_normal((257, 257))
    heights = gaussian_filter(heights, width, mode="wrap") if width else heights
    return np.asarray(heights * amplitude / heights.std())


def bumps(pitch: float) -> FloatArray:
    """Caps of 1 um in a square lattice."""
    wave = np.cos(2.0 * np.pi * SIDE / pitch)
    return -0.5e-3 * np.add.outer(wave, wave)


FEW_CELLS = Family(
    "contact of few cells",
    "1, 2, 4 cells",
    "a cell's own compliance; the loads carried",
    (
        Probe(
            "one cell",
            led({"P": 1e-3}, by(2, Qx=5e-5, Qy=2e-5), points=9, size=0.9),
            worst(of_one_cell, cells(1)),
            1e-6,
        ),
        Probe(
            "one cell, moments 0",
            led({"P": 1e-3, "Mx": 0.0, "My": 0.0}, {"Mz": 0.0, "Qx": 5e-5}, points=9, size=0.9),
            worst(of_one_cell, cells(1)),
            1e-6,
        ),
        Probe(
            "one cell dragged and turned",
            led({"P": 1e-3}, {"delta_x": 1.0}, by(3, delta_x=-1.0), {"phi_z": 1.0}, points=9, size=0.9),
            cells(1),
        ),
        Probe("two cells", led({"P": 1e-3}, {"Qx": 5e-5}, {"Mz": 1e-6}, points=[10, 9], size=[1.0, 0.9]), cells(2)),
        Probe("four cells", led({"P": 1e-3}, {"Qx": 5e-5}, {"Mz": 1e-6}, points=10, size=1.0), cells(4)),
        *(
            Probe(
                f"one cell, P {load:g}",
                led({"P": load}, points=32, size=0.75),
                refused=NotConvergedError,
                says="rounding",
                may_solve=True,
            )
            for load in (1e-9, 1e-12, 1e-15)
        ),
        Probe(
            "one cell, torque",
            led({"P": 1e-3}, {"Mz": 1e-9}, points=9, size=0.9),
            refused=SlidingError,
            says="Mz.*(one cell|single cell|more points)",
        ),
        Probe("one cell, tilting moment", led({"P": 1e-3}, {"My": 1e-9}, points=9, size=0.9), cells(2), resolved=False),
    ),
)

CLOSED_FORMS = Family(
    "shapes with closed forms",
    "ellipses 1 to 1e4, cones 1e-9 to 1.5 rad, punches, R 1e-12 to 1e12 mm",
    "Hertz, Love, Boussinesq",
    (
        *(
            Probe(
                f"ellipsoid 1 to {ratio:g}, turned {angle:g}",
                led(points=48, surface={"ellipsoid": {"radius_x": 10.0, "radius_y": 10.0 * ratio, "angle": angle}}),
                of_ellipse(10.0, 10.0 * ratio),
                0.01 if not angle else 0.05,
                quick=ratio in (1e2, 1e4),
            )
            for ratio, angle in ((1.0, 0.0), (10.0, 0.0), (1e2, 0.0), (1e3, 0.0), (1e4, 0.0), (10.0, 0.7), (1e2, 0.7))
        ),
        *(
            Probe(f"cone {angle:g} rad", led(points=33, surface={"cone": {"angle": angle}}), of_cone(angle), 0.02)
            for angle in (1e-9, 1e-4, 0.01, 0.5, 1.5)
        ),
        Probe("flat punch", led(points=64, size=0.7, surface={"punch": {"radius": 0.3}}), of_punch(0.3), 0.02),
        *(
            Probe(
                f"sphere R {radius:g} mm",
                {"surface": {"sphere": {"radius": radius}}},
                partial(of_hertz, radius=radius),
                0.002,
                quick=radius > 1.0,
            )
            for radius in (1e-12, 1e12)
        ),
    ),
)

SEVERAL = Family(
    "several contacts, rings, roughness",
    "1 ring to thousands of spots, saddle, punches",
    "Jaeger's superposition: shear traction, delta_x",
    (
        Probe(
            "ring",
            plain([{"sphere": {"radius": -5.0}}, {"punch": {"radius": 0.3, "edge_radius": 0.05}}], grid={"points": 40}),
            of_superposition,
            1e-5,
        ),
        Probe(
            "saddle on a punch",
            plain(
                [{"ellipsoid": {"radius_x": 10.0, "radius_y": -20.0}}, {"punch": {"radius": 0.3}}],
                grid={"points": 40, "size": 0.8},
            ),
            of_superposition,
            1e-5,
        ),
        Probe("sharp square punch", plain({"punch": {"half_width": 0.3}}, grid={"points": 40}), of_superposition, 1e-5),
        Probe("cone", plain({"cone": {"angle": 0.02}}), of_superposition, 1e-5),
        Probe(
            "lattice of 81 caps",
            plain({"punch": {"radius": 0.45}}, grid={"points": 96, "size": 1.0}, load_path=[{"P": 20.0}, {"Qx": 1.0}]),
            worst(of_superposition, spots(40)),
            1e-5,
            heights=partial(bumps, 0.1),
        ),
        *(
            Probe(
                f"rough {amplitude:g} mm, {width:g} points wide, P {load:g}, {points} points",
                plain(
                    surface,
                    grid={"points": points, "size": 1.2},
                    load_path=[{"P": load}, {"Qx": 0.06 * load, "increments": 2}],
                ),
                worst(of_superposition, spots(least)),
                1e-4,
                heights=partial(rough, amplitude, width),
                spacing=0.005,
                quick=quick,
                seconds=90.0,
            )
            for amplitude, width, load, surface, points, least, quick in (
                (1e-4, 2.0, 100.0, {"punch": {"radius": 0.5, "edge_radius": 0.01}}, 96, 20, True),
                (1e-3, 1.0, 400.0, {"punch": {"radius": 0.55}}, 240, 500, False),
                (1e-3, 0.0, 1000.0, {"punch": {"radius": 0.55}}, 240, 1000, False),
                (1e-3, 0.0, 4000.0, {"punch": {"radius": 0.55}}, 240, 100, False),
                (1e-3, 1.0, 400.0, SPHERE, 192, 1, False),
                (1e-6, 1.0, 400.0, SPHERE, 96, 1, False),
            )
        ),
    ),
)

MAPS = Family(
    "height maps",
    "holes, steps, spikes and pits of 1e-6 to 1e6 mm",
    "Jaeger's superposition: shear traction, delta_x",
    (
        *(
            Probe(
                f"{name} of {size:g} mm",
                plain(SPHERE, grid={"points": 41, "size": 0.82}),
                of_superposition,
                1e-5,
                heights=partial(make, size),
                quick=size == 1e6,
            )
            for name, make in (
                ("step", step),
                ("spike", bump),
                ("spike aside", partial(bump, at=(55, 52))),
                ("pit", pit),
            )
            for size in (1e-6, 1e-3, 1.0, 1e6)
        ),
        *(
            Probe(
                f"{share:.0%} of the points missing",
                plain(SPHERE, grid={"points": 41, "size": 0.82}),
                of_superposition,
                1e-5,
                heights=partial(holes, share),
            )
            for share in (0.01, 0.2)
        ),
        *(
            Probe(
                f"nothing but NaN, size {size}",
                plain([], grid={"points": 24, "size": size}),
                refused=CaseError,
                says="no finite height",
                heights=partial(holes, 1.0),
            )
            for size in (0.05, "auto")
        ),
        Probe(
            "flat to its end",
            led(points=24, size=0.8, surface=[]),
            refused=GridEdgeError,
            says="the height map ends too soon: a larger map is needed",
            heights=partial(holes, 0.0),
        ),
    ),
)

FAMILIES = (FEW_CELLS, CLOSED_FORMS, SEVERAL, MAPS)
