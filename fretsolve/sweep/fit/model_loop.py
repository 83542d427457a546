"""Compute the force of a case at the motions of a measured loop."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.interpolate import Akima1DInterpolator

from fretsolve.case.history import COMPONENTS
from fretsolve.case.loading import CaseText, replaced
from fretsolve.case.models import Case
from fretsolve.simulation.problem_setup import set_up
from fretsolve.simulation.simulation import run
from fretsolve.sweep.fit.measured_loop import MeasuredLoop
from fretsolve.sweep.fit.parameters import Parameter
from fretsolve.system.arrays import DoubleArray

COARSE_POINTS, COARSE_INCREMENTS = 32, 16
"""Cells per side, and increments of a half cycle, on the way to the solution."""

FINE_INCREMENTS = 24
"""Increments of a half cycle at the solution. A cubic without overshoot (Akima) gives the force between them."""

LEAD_INCREMENTS = 3
"""Increments of a half cycle before the measured one, whose slip settles the contact."""

FORCE, MOTION, ACTUATOR = COMPONENTS[3]


@dataclass(frozen=True, eq=False)
class Branches:
    """The half cycles of a solved loop: motion and force of each, from its start on; slides: one ends in gross slip."""

    motion: tuple[DoubleArray, DoubleArray]
    force: tuple[DoubleArray, DoubleArray]
    slides: bool

    def curves(self, points: int) -> tuple[DoubleArray, DoubleArray]:
        """Return motion and force along the loop, at `points` places of each half cycle."""
        ways = [np.linspace(motion[0], motion[-1], points) for motion in self.motion]
        forces = [self._force(branch, way)[0] for branch, way in enumerate(ways)]
        return np.concatenate(ways), np.concatenate(forces)

    def at(self, loop: MeasuredLoop) -> DoubleArray:
        """Return the force at the measured motions and its derivative by the motion ``(2, n)``."""
        found = np.empty((2, len(loop.motion)))
        for branch in (0, 1):
            here = loop.branch == branch
            found[:, here] = self._force(branch, loop.motion[here])
        return found

    def _force(self, branch: int, motion: DoubleArray) -> tuple[DoubleArray, DoubleArray]:
        """Return the force on a half cycle and its derivative; beyond the ends, where noise leads, on the tangent."""
        order = np.argsort(self.motion[branch])
        nodes = self.motion[branch][order]
        curve = Akima1DInterpolator(nodes, self.force[branch][order])
        inside = np.clip(motion, nodes[0], nodes[-1])
        slope = curve(inside, 1)
        return curve(inside) + slope * (motion - inside), slope


def area(motion: DoubleArray, force: DoubleArray) -> float:
    """Return the area within a closed polygon: the work of the force, below 0 where it drives the motion."""
    return 0.5 * float(np.sum(np.roll(motion, -1) * force - motion * np.roll(force, -1)))


@dataclass(frozen=True)
class LoopModel:
    """A case that moves along a measured loop, for any values of its parameters.

    text: the case with `--set`; pressing: entries of its load path that come before; motion: that the stages move;
    start: the motion where the measured cycle starts; ways: the motions along its half cycles, an increment each.
    points: as `grid.points`, None where the case decides; compiled: whether the compiled kernels are used.
    """

    text: CaseText
    pressing: int
    motion: str
    start: float
    ways: tuple[tuple[float, ...], tuple[float, ...]]
    parameters: tuple[Parameter, ...]
    points: int | list[int] | None
    compiled: bool = False

    def case(self, values: Sequence[float]) -> Case:
        """Return the case at values of the parameters. Raises CaseError."""
        data: Any = self.text.data
        for parameter, value in zip(self.parameters, values, strict=True):
            data = replaced(data, parameter.key, parameter.written(value) if parameter.unit else value)
        # from the middle to the cycle, and once along it, to settle the contact
        path = [(one, LEAD_INCREMENTS) for one in (self.start, self.ways[0][-1], self.start)]
        path += [(one, 1) for way in self.ways for one in way]
        stages = [{self.motion: one, "increments": number, "spacing": "equal"} for one, number in path]
        data = {key: value for key, value in data.items() if key not in ("expect", "output")}
        data |= {"load_path": [*data["load_path"][: self.pressing], *stages], "output": {"fields": []}}
        solver = {key: value for key, value in data.get("solver", {}).items() if key != "accuracy"}
        data["solver"] = {**solver, "error_bars": False}
        if self.points is not None:
            data = replaced(data, ("grid", "points"), self.points)
        return replace(self.text, data=data).case()

    def stretched(self, factor: float) -> LoopModel:
        """Return the model on a way that is longer by a factor, about its middle."""
        turn = self.ways[0][-1]
        middle = 0.5 * (self.start + turn)
        start, *ways = (tuple(middle + factor * (one - middle) for one in way) for way in ((self.start,), *self.ways))
        return replace(self, start=start[0], ways=(ways[0], ways[1]))

    @property
    def reach(self) -> float:
        """Half the way between the turns."""
        return 0.5 * abs(self.start - self.ways[0][-1])

    def branches(self, values: Sequence[float]) -> Branches:
        """Solve the loop at values of the parameters. Raises NoSolutionError, CaseError."""
        history = [state.summary for state in run(set_up(self.case(values), self.compiled))]
        first, second = map(len, self.ways)
        ways = history[-second - first - 1 : -second], history[-second - 1 :]
        motion, force = (
            [np.array([getattr(one, name) for one in way]) for way in ways] for name in (self.motion, FORCE)
        )
        slides = any(one.contact_cells > 0 and one.stick_cells == 0 for way in ways for one in way[1:])
        return Branches((motion[0], motion[1]), (force[0], force[1]), slides)


def pressing_entries(text: CaseText, case: Case) -> int:
    """Return how many entries of the load path come before the motion that the loop replaces.

    Raises CaseError where stages do anything else than to press first and to move along x then.
    """
    pressing, along = ({name for names in part for name in names} for part in (COMPONENTS[:3], COMPONENTS[3:4]))
    pressed, first = set[int](), None
    for stage in case.stages():
        names, entry = {name for name, _ in stage.targets}, int(stage.key[1])
        first = entry if first is None and names & along else first
        others = sorted(names - (pressing if first is None else along))
        if others or entry in (pressed if first is not None else ()):
            what = f"moves {', '.join(others)} beside the motion along x" if others else "presses and moves"
            message = f"{what}; a fit takes stages that press, and then stages that move along x alone"
            raise case.source.problem(message, stage.key)
        if first is None:
            pressed.add(entry)
    if first == 0:
        message = "nothing presses before the motion along x; a stage such as {P: 400 N} is needed"
        raise case.source.problem(message, ("load_path", 0))
    return len(text.data["load_path"]) if first is None else first
