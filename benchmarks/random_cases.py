"""Random cases that nobody tuned the error bars on: surfaces, materials, friction and load paths drawn from a seed.

A case depends on its seed and its number alone, so that the first 20 of 60 are the same cases as 20 of 20. Seeds from
6 on draw from a wider sample: slender cells, sharp edges, maps finer than the cells, many and automatic increments.
Truth is a run with more points and more increments. Moments and displacements are drawn relative to closed forms of
the contact, so that most paths have a solution; a case that has none is reported as such.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
from calibration_cases import CalibrationCase

from fretsolve.case.history import BULK
from fretsolve.case.models import Case
from fretsolve.problem.setup.picked_settings import AREA_MARGIN
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.simulation.problem_setup import set_up

SURFACES = (
    *("sphere",) * 4,
    *(
        "ellipsoid",
        "cylinder with ends",
        "crowned cylinder",
        "rounded punch",
        "cone",
        "ring",
        "wavy sphere",
        "rough map",
    ),
)
WIDER_SEED = 6
"""First seed whose cases are drawn from the wider sample; those of earlier seeds stay as they were."""

WIDER_SURFACES = (*SURFACES, "sharp cylinder", "nearly sharp punch", "sharp punch", "fine map", "coarse map")
"""With sharp ends, roundings and heights finer than the cells, and waves near the spacing of the map."""

SLENDERNESS = (1.0, 1.0, 1.0, 4.0, 10.0)
"""Long over short sides of cells in the wider sample."""

PATHS = (
    *("pressed", "shear", "shear", "reversal", "cycle", "oblique", "torsion", "displacement", "moment", "mixed"),
    *("partly unloaded", "moment and shear"),
)
POINTS = (24, 28, 32, 36, 40)
"""Points per side, before the shapes of the area and of its cells change them."""

LEAST_FINE_INCREMENTS = 32
"""Increments of a stage of the fine run, at least."""

FINER_INCREMENTS = 4
"""Increments of the fine run over those of the run, at least."""

MAP_FOLDER = Path("random_maps")


@dataclass(frozen=True)
class RandomCase(CalibrationCase):
    """A drawn case; the fine run has more increments in every stage, also in those of one increment."""

    points: int = 4

    def fine_case(self) -> Case:
        """The same on the same area with more points and increments."""
        setup = set_up(self.case())
        path = setup.load_path
        stages = [
            {
                **as_in_file(stage.targets),
                "increments": count * finer(count),
                "spacing": "graded" if graded else "equal",
            }
            for stage, count, graded in zip(setup.case.stages(), path.counts, path.graded, strict=True)
        ]
        points: Any = [self.points * count for count in setup.grid.shape[: len(setup.grid.axes)]]
        if setup.model.line:
            (points,) = points
        return self._with(grid={**self.parts["grid"], "points": points}, load_path=stages)


def as_in_file(targets: Iterable[tuple[str, float]]) -> dict[str, Any]:
    """Return the targets of a stage as a case file has them, its bulk stresses by body."""
    own = dict(targets)
    found: dict[str, Any] = {name: value for name, value in own.items() if not name.startswith("bulk_")}
    for body, names in BULK.items():
        parts = {name.rpartition("_")[2]: own[name] for name in names if name in own}
        if parts:
            found[f"bulk_{body}"] = parts
    return found


def finer(count: int) -> int:
    """Return how many increments, an even number, of the fine run stand for one of a stage with `count` of them."""
    return 2 * math.ceil(0.5 * max(FINER_INCREMENTS, LEAST_FINE_INCREMENTS / count))


def random_cases(seed: int, count: int, maps: Path = MAP_FOLDER) -> Iterator[RandomCase]:
    """Yield `count` cases; height maps are written into the folder `maps`."""
    for number in range(count):
        yield _draw(Random(f"{seed}-{number}"), f"{seed}-{number:02d}", maps, wider=seed >= WIDER_SEED)


def _draw(random: Random, label: str, maps: Path, *, wider: bool) -> RandomCase:
    kind = random.choice(WIDER_SURFACES if wider else SURFACES)
    surface, load = _surface(random, kind, maps / f"{label}.npy")
    bodies, alike = bodies_of(random)
    friction, points = friction_of(random), random.choice(POINTS)
    base = {"surface": surface, "bodies": bodies, "friction": friction, "grid": {"points": points}}
    setup = set_up(Case.model_validate({**base, "load_path": [{"P": load}]}))
    size = [round(random.uniform(1.0, 1.4) * side, 4) for side in setup.grid.size]
    path, words = _path(random, setup, load, friction)
    if "moment" in words:
        size = [1.25 * side for side in size]
    parts = {**base, "grid": {"points": points_along(points, size), "size": size}, "load_path": path}
    name = f"{label} {kind}, {'similar' if alike else 'dissimilar'}, friction {friction:g}, {words}"
    return widened(random, RandomCase(name, parts)) if wider else RandomCase(name, parts)


def points_along(points: int, size: Sequence[float]) -> list[int]:
    """Return about `points` points per side, and more along the longer side of a slender area."""
    if max(size) <= 1.5 * min(size):
        return [points, points]
    return [max(24, min(64, round(points * side / math.sqrt(size[0] * size[1]) / 2) * 2)) for side in size]


def widened(random: Random, case: RandomCase) -> RandomCase:
    """Return a case with slender cells, with many or automatic increments, or as it is."""
    grid, path, words = dict(case.parts["grid"]), list(case.parts["load_path"]), case.name
    slender = random.choice(SLENDERNESS)
    if slender > 1.0:
        nx, ny = grid["points"]
        along_x = random.random() < 0.5
        # As many cells as before, but at least 24 along each side.
        few, many = (nx, ny) if along_x else (ny, nx)
        fewer = max(24, round(few / math.sqrt(slender) / 2) * 2)
        more = min(256, round(slender * many * fewer / few / 2) * 2)
        grid["points"] = [fewer, more] if along_x else [more, fewer]
        words += f", cells 1:{slender:g}"
    counts = random.choice(("few", "few", "few", "many", "auto"))
    if counts != "few":
        path = [_recounted(stage, random.choice((16, 24)) if counts == "many" else None) for stage in path]
        words += f", {counts} increments"
    return replace(case, name=words, parts={**case.parts, "grid": grid, "load_path": path})


def _recounted(stage: Mapping[str, Any], count: int | None) -> dict[str, Any]:
    """Return a stage, or a cycle of stages, with `count` increments in each; automatic ones if it is None."""
    if "cycle" in stage:
        cycle = stage["cycle"]
        return {"cycle": {**cycle, "stages": [_recounted(part, count) for part in cycle["stages"]]}}
    return {**stage, "increments": count} if count else {**without(stage, "spacing"), "increments": "auto"}


def without(stage: Mapping[str, Any], key: str) -> dict[str, Any]:
    """Return a stage without a key."""
    return {name: value for name, value in stage.items() if name != key}


def _surface(random: Random, kind: str, file: Path) -> tuple[Any, float]:
    """Return the surface and the normal load, N."""
    radius = radius_of(random)
    load = load_on(random, radius)
    sphere = {"sphere": {"radius": radius}}
    match kind:
        case "sphere":
            return sphere, load
        case "ellipsoid":
            slender = random.choice((1.5, 3.0, 8.0))
            angle = random.choice((0.0, 0.0, 0.4))
            return {"ellipsoid": {"radius_x": radius, "radius_y": round(slender * radius, 3), "angle": angle}}, load
        case "cylinder with ends":
            length = round(0.15 * radius, 3)
            end = round(random.choice((0.2, 0.4)) * length, 4)
            axis = random.choice(("x", "y"))
            return {"cylinder": {"radius": radius, "axis": axis, "length": length, "end_radius": end}}, load
        case "crowned cylinder":
            crown = round(random.choice((4.0, 10.0)) * radius, 2)
            return {"cylinder": {"radius": radius, "axis": random.choice(("x", "y")), "crown_radius": crown}}, load
        case "rounded punch":
            flat = round(0.05 * radius, 4)
            edge = round(random.choice((0.3, 0.5, 1.0)) * flat, 4)
            return {"punch": {"radius": flat, "edge_radius": edge}}, load
        case "cone":
            return {"cone": {"angle": round(random.uniform(0.01, 0.04), 4)}}, load
        case "ring":
            punch = {"radius": round(0.05 * radius, 4), "edge_radius": round(0.025 * radius, 4)}
            return [{"sphere": {"radius": -20.0 * radius}}, {"punch": punch}], load
        case "sharp cylinder":
            return {"cylinder": {"radius": radius, "axis": random.choice(("x", "y")), "length": 0.15 * radius}}, load
        case "nearly sharp punch":
            return {"punch": {"radius": 0.05 * radius, "edge_radius": random.choice((3e-4, 1e-3)) * radius}}, load
        case "sharp punch":
            return {"punch": {"half_width" if random.random() < 0.5 else "radius": 0.05 * radius}}, load
    # The waves of the maps are some cells long, those of fine maps shorter; coarse maps have few points on them.
    side, count = 0.12 * radius, 257
    shortest, longest = (0.006, 0.012) if kind == "fine map" else (0.025, 0.05)
    if kind == "coarse map":
        count = 25
    axis_values = np.linspace(-side, side, count)
    x, y = np.meshgrid(axis_values, axis_values, indexing="ij")
    waves = 1 if kind == "wavy sphere" else 6
    heights = np.zeros_like(x)
    for _ in range(waves):
        length, turn = random.uniform(shortest, longest) * radius, random.uniform(0.0, math.pi)
        phase = random.uniform(0.0, 2.0 * math.pi)
        heights += np.sin(2.0 * math.pi * (x * math.cos(turn) + y * math.sin(turn)) / length + phase)
    scale = random.uniform(2e-6, 1e-5)
    return [sphere, saved_map(heights * scale * radius / math.sqrt(waves), 2.0 * side / (count - 1), file)], load


def saved_map(heights: np.ndarray[Any, np.dtype[np.float64]], spacing: float, file: Path) -> dict[str, Any]:
    """Write a height map into a file, and return the surface that names it."""
    file.parent.mkdir(exist_ok=True)
    np.save(file, heights)
    return {"heights": {"file": str(file.resolve()), "spacing": spacing}}


def radius_of(random: Random) -> float:
    """Return a radius of curvature, mm."""
    return round(random.choice((2.0, 5.0, 10.0, 30.0)) * random.uniform(0.8, 1.25), 3)


def load_on(random: Random, radius: float) -> float:
    """Return a normal load, N."""
    return round(4.0 * radius**2 * random.uniform(0.5, 2.0), 2)


def friction_of(random: Random) -> float:
    """Return a coefficient of friction."""
    return round(math.exp(random.uniform(math.log(0.02), math.log(1.5))), 3)


def bodies_of(random: Random) -> tuple[list[Any], bool]:
    """Return the bodies, and whether they are alike in the sense that normal and shear tractions do not couple."""
    modulus = round(math.exp(random.uniform(math.log(3e3), math.log(4e5))), -2)
    first = {"young_modulus": modulus, "poisson_ratio": round(random.uniform(0.0, 0.45), 2)}
    kind = random.choice(("same", "same", "poisson", "both", "rigid"))
    if kind == "same":
        return [first, first], True
    if kind == "rigid":
        return ["rigid", first], False
    factor = random.uniform(0.2, 5.0) if kind == "both" else 1.0
    return [first, {"young_modulus": factor * modulus, "poisson_ratio": round(random.uniform(0.0, 0.45), 2)}], False


def _path(random: Random, setup: ProblemSetup, load: float, friction: float) -> tuple[list[Any], str]:
    """Return the load path and its words."""
    extents = [side / (2.0 * AREA_MARGIN) for side in setup.grid.size]
    radius = math.sqrt(extents[0] * extents[1])
    limit, torque = friction * load, 0.55 * friction * load * radius
    slide = 0.75 * limit / (setup.model.compliances.contact_modulus * radius) * 1.2

    def count(stage: str) -> int:
        return random.choice((1, 3, 5, 8, 12) if stage == "shear" else (1, 4, 8, 12))

    def stage(kind: str, **targets: float) -> dict[str, Any]:
        graded = {"spacing": "graded"} if random.random() < 0.25 else {}
        values = {name: float(f"{value:.4g}") for name, value in targets.items()}
        return {**values, "increments": count(kind), **graded}

    share = random.choice((0.3, 0.6, 0.8, 0.9, 0.97))
    force = share * limit
    press = stage("press", P=load)
    kind = random.choice(PATHS)
    match kind:
        case "pressed":
            return [press], kind
        case "shear":
            return [press, stage("shear", Qx=force)], f"shear {share:g}"
        case "reversal":
            return [press, stage("shear", Qx=force), stage("shear", Qx=-force)], f"reversal {share:g}"
        case "cycle":
            stages = [stage("shear", Qx=force), stage("shear", Qx=-force)]
            return [press, {"cycle": {"times": 2, "stages": stages}}], f"cycle {share:g}"
        case "oblique":
            turn = random.uniform(0.3, 1.2)
            first = stage("shear", Qx=0.7 * force)
            return [press, first, stage("shear", Qx=force * math.cos(turn), Qy=force * math.sin(turn))], kind
        case "torsion":
            return [press, stage("shear", Mz=share * torque), stage("shear", Qx=0.3 * limit)], f"torsion {share:g}"
        case "displacement":
            far = random.choice((0.4, 0.8, 1.5)) * slide
            return [press, stage("shear", delta_x=far), stage("shear", delta_x=-far)], kind
        case "moment":
            return [stage("press", P=load, My=random.uniform(0.03, 0.12) * load * radius)], kind
        case "mixed":
            first = stage("press", P=0.5 * load)
            return [first, stage("shear", P=load, Qx=0.6 * force), stage("press", P=0.75 * load)], kind
        case "partly unloaded":
            return [press, stage("shear", Qx=0.4 * force), stage("press", P=0.6 * load)], kind
    tilt = stage("press", P=load, My=random.uniform(0.03, 0.1) * load * radius)
    return [tilt, stage("shear", Qy=0.8 * force)], kind


def main() -> None:
    """Print the cases of a seed."""
    import argparse

    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("seed", type=int)
    parser.add_argument("count", type=int)
    options = parser.parse_args()
    for case in random_cases(options.seed, options.count):
        print(case.name, case.parts["grid"], case.parts["load_path"])


if __name__ == "__main__":
    main()
