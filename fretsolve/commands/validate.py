"""``fretsolve validate``: what a case comes to, before anything is solved."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import yaml

from fretsolve.case import HeightsSurface, load_case
from fretsolve.commands.description import grid_line, model_lines, warn
from fretsolve.commands.hertz import hertz_contact
from fretsolve.errors import CaseError, FileError
from fretsolve.estimate import estimate, memory_problem
from fretsolve.scene import prepare

if TYPE_CHECKING:
    from fretsolve.commands.hertz import Hertz
    from fretsolve.scene import Scene

FEWEST_CELLS = 20
"""Cells across the contact below which results are off by per cents."""

MOST_STAGES_SHOWN = 40

YAML_WIDTH = 110


def validate_cases(cases: Sequence[Path], overrides: Sequence[str]) -> int:
    """Print a report on each case, or its errors; the exit code of the worst."""
    code = 0
    for path in cases:
        try:
            scene = prepare(load_case(path, overrides))
            if any(isinstance(surface, HeightsSurface) for surface in scene.case.surface):
                scene.separation()  # reads the maps
            hertz = hertz_contact(scene)
            for line in report(scene, hertz):
                print(line)
            print(flush=True)
            warn(scene, *warnings(scene, hertz))
        except (CaseError, FileError) as error:
            print(error, file=sys.stderr)
            code = max(code, error.exit_code)
    return code


def report(scene: Scene, hertz: Hertz | None) -> Iterator[str]:
    """The lines on one case."""
    yield f"# {scene.case.source.path}, with all defaults, in mm, N, MPa, rad"
    yield effective_yaml(scene)
    yield "# model"
    yield from model_lines(scene.model)
    yield "\n# grid"
    yield grid_line(scene)
    yield f"\n# load path of {scene.load_path.increments} increments"
    yield from stage_lines(scene)
    if hertz is not None:
        yield "\n# Hertz at the largest load"
        yield from closed_form_lines(scene, hertz)
    yield "\n# cost"
    yield from estimate(scene).lines()


def effective_yaml(scene: Scene) -> str:
    """The case with all defaults, as a case file."""
    return yaml.dump(
        scene.case.effective(),
        Dumper=_Dumper,
        sort_keys=False,
        default_flow_style=None,
        allow_unicode=True,
        width=YAML_WIDTH,
    )


class _Dumper(yaml.SafeDumper):
    """Writes equal values out instead of referring back to the first."""

    def ignore_aliases(self, data: object) -> bool:
        return True


def stage_lines(scene: Scene) -> Iterator[str]:
    """One line per stage: what it moves where, in how many increments."""
    stages = scene.case.stages()
    ends = (-1, *scene.load_path.last_steps)
    counts = [last - before for before, last in pairwise(ends)]
    for stage, count in list(zip(stages, counts, strict=True))[:MOST_STAGES_SHOWN]:
        targets = ", ".join(f"{name} -> {value:g}" for name, value in stage.targets)
        chosen = " (auto)" if stage.increments is None else ""
        yield f"stage {stage.number}: {targets} in {count} increment{'s' * (count > 1)}{chosen}"
    if len(stages) > MOST_STAGES_SHOWN:
        yield f"... and {len(stages) - MOST_STAGES_SHOWN} more stages, up to stage {len(stages)}"


def closed_form_lines(scene: Scene, hertz: Hertz) -> Iterator[str]:
    """What Hertz's theory says at the largest normal load, and the limits of friction there."""
    first, second = hertz.semi_axes
    size = f"a = {first:.6g} mm" if first == second else f"semi-axes {first:.6g} and {second:.6g} mm"
    yield f"P = {hertz.load:.6g} N: {size}, p0 = {hertz.max_pressure:.6g} MPa, delta_z = {hertz.delta_z:.6g} mm"
    yield f"{hertz.cells_across(scene.grid):.1f} cells across the contact"
    if scene.model.friction:
        torque = f", at Mz = {hertz.torque(scene.model.friction):.6g} N*mm" if first == second else ""
        yield f"everything slides at Q = mu P = {scene.model.friction * hertz.load:.6g} N{torque}"
    yield f"Dundurs' constant {scene.model.compliances.dundurs_constant:.4g}"


def warnings(scene: Scene, hertz: Hertz | None) -> Iterator[str]:
    """What a person should hear before running the case."""
    yield from scene.model.warnings
    if hertz is not None and hertz.cells_across(scene.grid) < FEWEST_CELLS:
        yield (
            f"grid.points: only {hertz.cells_across(scene.grid):.1f} cells across the contact;"
            f" {FEWEST_CELLS} or more are needed for errors below a few per cent"
        )
    too_large = memory_problem(scene)
    if too_large is not None:
        yield too_large.message
