"""Random cases of scenes that `random_cases` does not draw, mixed with those that it does.

They are line contacts, cycles about a mean, shear that is turned in few increments, and height maps with holes: scenes
on which error bars were too small while all seeds of `random_cases` were inside. Seeds below 54 have none of them, so
that their cases stay what they were. In later ones about half of the cases are such scenes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
from random_cases import (
    MAP_FOLDER,
    POINTS,
    RandomCase,
    bodies_of,
    friction_of,
    load_on,
    points_along,
    radius_of,
    random_cases,
    saved_map,
    widened,
)

from fretsolve.case.loading import case_model
from fretsolve.case.models import Case
from fretsolve.problem.model.materials import compliances
from fretsolve.reference.hertz import HertzLine, hertz_sphere
from fretsolve.simulation.problem_setup import set_up

FIRST_SEED = 54
"""First seed that draws these scenes."""

KINDS = (*("known",) * 10, *("line",) * 4, "mean", "mean", "turned", "turned", "holes", "holes")
"""Of which each case draws one; known: as `random_cases` draws it."""

LINE_SURFACES = ("cylinder", "cylinder", "cylinder", "punch", "punch", "wavy cylinder", "cylinder with a rim")
LINE_PATHS = (
    *("pressed", "shear", "reversal", "cycle", "mean", "mean", "turned", "mixed", "partly unloaded", "moment"),
    *("moment and shear", "bulk"),
)
HOLES = ("rim beside the contact", "rim within the contact", "hole", "groove")
SHARES = (0.3, 0.6, 0.8, 0.9, 0.97)
"""Largest shear forces over the friction limit."""

LEAST_SHARES = (0.0, 0.3, 0.6, -0.3)
"""Least shear force over the largest one, of cycles about a mean."""


def unseen_cases(seed: int, count: int, maps: Path = MAP_FOLDER) -> Iterator[RandomCase]:
    """Yield `count` cases of a seed; height maps are written into the folder `maps`."""
    for number, known in enumerate(random_cases(seed, count, maps)):
        label = f"{seed}-{number:02d}"
        random = Random(f"scene {label}")
        kind = random.choice(KINDS) if seed >= FIRST_SEED else "known"
        if kind == "known":
            yield known
        elif kind == "line":
            yield _line(random, label, maps)
        else:
            yield _on_area(random, kind, label, maps)


def scene_of(name: str) -> str:
    """Return the kind of scene that a case of this name is."""
    _, _, words = name.partition(" ")
    if words.startswith("line, "):
        return "line contacts"
    if words.startswith(tuple(f"{hole}, " for hole in HOLES)):
        return "maps with holes"
    if ", mean, R" in words:
        return "cycles about a mean"
    return "shear that is turned" if ", turned by " in words else "others"


def _increments(random: Random) -> int:
    return random.choice((1, 2, 3, 4, 5, 8, 12))


def _stage(random: Random, **targets: float) -> dict[str, Any]:
    return {**{name: float(f"{value:.4g}") for name, value in targets.items()}, "increments": _increments(random)}


def _about_mean(random: Random, force: float) -> tuple[list[Any], str]:
    """Return stages of a shear force between `force` and a part of it, and their words."""
    least = random.choice(LEAST_SHARES)
    stages = [_stage(random, Qx=least * force), _stage(random, Qx=force)]
    return [_stage(random, Qx=force), {"cycle": {"times": 2, "stages": stages}}], f"mean, R {least:g}"


def _turned(random: Random, force: float) -> tuple[list[Any], str]:
    """Return stages of a shear force that is turned once or twice, and their words."""
    turn = random.uniform(0.4, 2.6)
    angles = [0.0, turn, *([2.0 * turn] if random.random() < 0.5 else [])]
    stages = [_stage(random, Qx=force * math.cos(angle), Qy=force * math.sin(angle)) for angle in angles]
    return stages, f"turned by {math.degrees(turn):.0f} degrees"


def _on_area(random: Random, kind: str, label: str, maps: Path) -> RandomCase:
    """Return a case of a contact on an area: a cycle about a mean, a turned shear, or a map with holes."""
    radius = radius_of(random)
    load = load_on(random, radius)
    bodies, alike = bodies_of(random)
    friction, points = friction_of(random), random.choice(POINTS)
    sphere: dict[str, Any] = {"sphere": {"radius": radius}}
    surface: Any = sphere
    share = random.choice(SHARES)
    shape = "sphere"
    stages, words = (_turned if kind == "turned" else _about_mean)(random, share * friction * load)
    if kind == "holes":
        contact = hertz_sphere(load, radius, _contact_modulus(bodies)).semi_axes[0]
        shape = random.choice(HOLES)
        surface = [sphere, _holed_map(random, shape, contact, maps / f"{label}.npy")]
        asked = random.choice((0, 1, 2))
        stages, words = stages[:asked], ("pressed", f"shear {share:g}", words)[asked]
    elif random.random() < 0.4:
        shape = "ellipsoid"
        surface = {"ellipsoid": {"radius_x": radius, "radius_y": round(random.choice((1.5, 3.0)) * radius, 3)}}
    base = {"surface": surface, "bodies": bodies, "friction": friction, "grid": {"points": points}}
    path = [_stage(random, P=load), *stages]
    whole = sphere if kind == "holes" else surface
    setup = set_up(Case.model_validate({**base, "surface": whole, "load_path": path[:1]}))
    size = [round(random.uniform(1.0, 1.4) * side, 4) for side in setup.grid.size]
    parts = {**base, "grid": {"points": points_along(points, size), "size": size}, "load_path": path}
    name = f"{label} {shape}, {'similar' if alike else 'dissimilar'}, friction {friction:g}, {words}"
    return widened(random, RandomCase(name, parts))


def _line(random: Random, label: str, maps: Path) -> RandomCase:
    """Return a case of a line contact."""
    radius = radius_of(random)
    bodies, alike = bodies_of(random)
    modulus = _contact_modulus(bodies)
    kind = random.choice(LINE_SURFACES)
    half_width = radius * math.exp(random.uniform(math.log(0.01), math.log(0.05)))
    load = 0.25 * math.pi * modulus * half_width**2 / radius
    surface: Any = {"cylinder": {"radius": radius}}
    if kind == "punch":
        edge = random.choice((0.1, 1.0, 3.0, 10.0)) * radius
        surface = {"punch": {"half_width": float(f"{half_width:.4g}"), "edge_radius": float(f"{edge:.4g}")}}
        load *= 0.3
    elif kind != "cylinder":
        surface = [surface, _line_map(random, kind, HertzLine(load, radius, modulus).half_width, maps / f"{label}.npy")]
    friction, points = friction_of(random), random.choice((24, 32, 48, 64, 96))
    stages, words = _line_path(random, float(f"{load:.4g}"), friction, half_width)
    base = {"plane": "strain", "surface": surface, "bodies": bodies, "friction": friction}
    pressed = {**base, "grid": {"points": points}, "load_path": [{"P": load}]}
    if isinstance(surface, list):
        pressed["surface"] = surface[0]
    size = round(random.uniform(1.0, 1.4) * set_up(case_model(pressed).model_validate(pressed)).grid.size[0], 5)
    if "moment" in words:
        size *= 1.25
    parts = {**base, "grid": {"points": points, "size": size}, "load_path": stages}
    name = f"{label} line, {kind}, {'similar' if alike else 'dissimilar'}, friction {friction:g}, {words}"
    return RandomCase(name, parts)


def _line_path(random: Random, load: float, friction: float, half_width: float) -> tuple[list[Any], str]:
    """Return the load path of a line contact, and its words."""
    press = _stage(random, P=load)
    share = random.choice(SHARES)
    force, kind = share * friction * load, random.choice(LINE_PATHS)
    if kind in ("mean", "turned"):
        stages, words = (_about_mean if kind == "mean" else _turned)(random, force)
        return [press, *stages], words
    words = f"{kind} {share:g}"
    there, back = _stage(random, Qx=force), _stage(random, Qx=-force)
    match kind:
        case "pressed":
            return [press], kind
        case "shear":
            return [press, there], words
        case "reversal":
            return [press, there, back], words
        case "cycle":
            return [press, {"cycle": {"times": 2, "stages": [there, back]}}], words
        case "mixed":
            more = [_stage(random, P=load, Qx=0.6 * force), _stage(random, P=0.75 * load)]
            return [_stage(random, P=0.5 * load), *more], kind
        case "partly unloaded":
            return [press, _stage(random, Qx=0.4 * force), _stage(random, P=0.6 * load)], kind
        case "bulk":
            # It moves the stick zone by its part of 4 mu p0 in half-widths, p0 = 2 P/(pi a); Nowell & Hills (1987).
            stress = random.choice((0.3, 1.2)) * friction * 2.0 * load / (math.pi * half_width)
            pulled = [
                {**_stage(random, Qx=sign * 0.5 * force), "bulk_2": {"xx": float(f"{sign * stress:.4g}")}}
                for sign in (1.0, -1.0)
            ]
            return [press, *pulled], kind
    tilt = _stage(random, P=load, My=random.uniform(0.03, 0.12) * load * half_width)
    return [tilt, *([] if kind == "moment" else [there])], kind


def _contact_modulus(bodies: list[Any]) -> float:
    """Return E* (MPa) of bodies as a case file has them."""
    others = {"surface": {"sphere": {"radius": 1.0}}, "friction": 0.0, "grid": {"points": 8}, "load_path": [{"P": 1.0}]}
    case = Case.model_validate({**others, "bodies": bodies})
    return compliances(*case.bodies).contact_modulus


def _holed_map(random: Random, which: str, contact: float, file: Path) -> dict[str, Any]:
    """Return a map without heights whose material ends, beside or within a contact of radius `contact` (mm)."""
    axis_values = np.linspace(-2.5 * contact, 2.5 * contact, 501)
    x, y = np.meshgrid(axis_values, axis_values, indexing="ij")
    match which:
        case "rim beside the contact":
            gone = np.hypot(x, y) > random.uniform(1.02, 1.3) * contact
        case "rim within the contact":
            gone = np.hypot(x, y) > random.uniform(0.6, 0.98) * contact
        case "hole":
            gone = np.hypot(x - random.uniform(0.0, 0.8) * contact, y) < random.uniform(0.15, 0.4) * contact
        case _:
            gone = np.abs(x - random.uniform(0.0, 0.7) * contact) < random.uniform(0.1, 0.25) * contact
    return saved_map(np.where(gone, math.nan, 0.0), float(axis_values[1] - axis_values[0]), file)


def _line_map(random: Random, kind: str, half_width: float, file: Path) -> dict[str, Any]:
    """Return a map along a line: waves of some cells' length, or a rim beside or within the contact."""
    x = np.linspace(-2.5 * half_width, 2.5 * half_width, 1001)
    heights = np.zeros_like(x)
    if kind == "wavy cylinder":
        length = random.uniform(0.3, 1.0) * half_width
        depth, phase = 1e-3 * random.uniform(0.1, 1.0) * half_width, random.uniform(0.0, 6.0)
        heights = depth * np.sin(2.0 * math.pi * x / length + phase)
    else:
        heights[np.abs(x) > random.uniform(0.6, 1.3) * half_width] = math.nan
    return saved_map(heights, float(x[1] - x[0]), file)
