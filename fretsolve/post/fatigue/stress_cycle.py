"""The stresses of cycles, read layer by layer from a file of stresses, averaged if wanted."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from fretsolve.case.keys.material_spec import Material
from fretsolve.errors import CaseError
from fretsolve.post.fatigue.material import placed
from fretsolve.post.fatigue.request import Average, ComputedTractions, FatigueRequest, depth_weights
from fretsolve.post.stress.computed_file import ComputedFile, not_of_kind
from fretsolve.post.stress.cycles import LoadCycle, chosen, cycles_from_text, require_states, states_of
from fretsolve.post.stress.influence import COMPONENTS
from fretsolve.post.stress.stress_file import BodyStress, bodies_of
from fretsolve.system.arrays import DoubleArray, IndexArray
from fretsolve.system.atomic_files import working_folder

CLOSED_WITHIN = 0.01
"""The share of its range by which a closed cycle may miss its beginning."""


@dataclass(frozen=True, eq=False)
class StressCycles:
    """The stresses of a body over cycles; path: their file. The states of the cycles are places in the file."""

    path: Path
    body: BodyStress
    cycles: tuple[LoadCycle, ...]
    average: Average | None = None

    def __post_init__(self) -> None:
        missing = [name for name in COMPONENTS if name not in self.body.components]
        with placed(lambda message: CaseError(message, (), self.path)):
            if missing:
                raise CaseError(f"the file lacks the components {', '.join(missing)}, all six are needed")
            for cycle in self.cycles:
                require_states(cycle, range(len(self.body.steps)))
            if self.average is not None:
                self.average.require_resolved(self.body.depths, self.cell)

    @property
    def cell(self) -> tuple[float, float]:
        """The sides of a cell (mm); along a direction with one cell the side of the other direction."""
        x, y = (float(axis[1] - axis[0]) if len(axis) > 1 else 0.0 for axis in (self.body.x, self.body.y))
        return x or y, y or x

    @cached_property
    def depths(self) -> DoubleArray:
        """Depths of the layers (mm); with an average, the mean depth of its only layer."""
        return self.body.depths if self.average is None else np.array([np.mean(self.average.depth_range)])

    @property
    def shape(self) -> tuple[int, int]:
        """Cells along x and along y."""
        return len(self.body.x), len(self.body.y)

    @property
    def states(self) -> tuple[int, ...]:
        """The places of the states of all cycles."""
        return states_of(self.cycles, range(len(self.body.steps)))

    def increments(self, cycle: LoadCycle) -> LoadCycle:
        """Return a cycle with increments of the result as its states."""
        return replace(cycle, states=tuple(self.body.steps[list(cycle.states)].tolist()))

    def stress(self, cycle: LoadCycle, depth: int) -> DoubleArray:
        """Return the stresses (steps, 6, points) of a cycle at a place of `depths`, unloaded first if it begins so."""
        if self.average is None:
            layer = [self.body.layer(COMPONENTS, index, depth) for index in cycle.states]
            return cycle.with_rest(np.array(layer, np.float64).reshape(len(layer), 6, -1))
        weights = depth_weights(self.body.depths, *self.average.depth_range)
        whole = (self.body.stress(index).astype(np.float64) for index in cycle.states)
        means = [self.average.of(stress, weights, self.cell) for stress in whole]
        return cycle.with_rest(np.stack(means).reshape(len(means), 6, -1))

    def paths(self, depth: int, points: IndexArray) -> list[DoubleArray]:
        """Return the stresses (steps, 6, points) of each cycle at some points of a place of `depths`."""
        return [self.stress(cycle, depth)[:, :, points] for cycle in self.cycles]


@dataclass(frozen=True, eq=False)
class FatigueCycles:
    """The stresses of cycles and the constants of each body.

    attributes: of the file of parameters; tractions: that the stresses were computed from, None if only these are
    known.
    """

    request: FatigueRequest
    of_body: Mapping[int, StressCycles]
    materials: Mapping[int, Material]
    attributes: Mapping[str, str]
    tractions: ComputedTractions | None = None

    @property
    def layers(self) -> int:
        """The number of layers of all bodies and cycles."""
        return sum(len(of.depths) * len(of.cycles) for of in self.of_body.values())

    @property
    def cycles(self) -> tuple[LoadCycle, ...]:
        """The cycles, which are the same of all bodies."""
        return next(iter(self.of_body.values())).cycles


@contextmanager
def stresses_beside(target: Path, folder: Path | None = None) -> Iterator[Path]:
    """Yield the name of a file of stresses that is removed at the end of the block; see `working_folder`."""
    with working_folder(target, folder) as working:
        yield working / "stress.h5"


def stress_cycles(
    file: ComputedFile | None,
    stresses: Path,
    origin: Path,
    request: FatigueRequest,
    tractions: ComputedTractions | None = None,
) -> FatigueCycles:
    """Return the cycles in `file`, the open file of `stresses`. Raises CaseError, FileError.

    origin: the file that messages name; tractions: that the stresses were computed from.
    """
    if file is None:
        raise not_of_kind("stress", stresses)
    if (slip := request.slip_criteria) and tractions is None:
        message = f"{slip[0]} needs slip, which a file of stresses does not hold; the result itself is needed"
        raise CaseError(message, (), origin)
    found, attributes = bodies_of(file), file.attributes
    if missing := [number for number in request.bodies if number not in found]:
        there = " and ".join(f"body {one}" for one in found)
        raise CaseError(f"there are no stresses of body {missing[0]}, only of {there}", (), origin)
    cycles, materials = {}, {}
    for number, body in found.items():
        if not request.bodies or number in request.bodies:
            own = request.material.with_elastic_constants(elastic_body(attributes, number))
            own.require(request.criteria)
            with placed(lambda message: CaseError(message, (), origin)):
                of_request = chosen(cycles_from_text(attributes["cycles"]), request.cycles)
            cycles[number] = StressCycles(origin, body, of_request, request.average)
            materials[number] = own.material
    average = request.average
    texts = {
        "average": "" if average is None else f"{average.kind} over {average.length:g} mm",
        "material": next(iter(materials.values())).model_dump_json(exclude_none=True),
    }
    texts |= {name: str(attributes[name]) for name in ("title", "result", "effective_case") if name in attributes}
    return FatigueCycles(request, cycles, materials, texts, tractions)


def elastic_body(attributes: Any, number: int) -> dict[str, Any]:
    """Return a body of the effective case of a file of stresses, empty if it is not known or rigid."""
    bodies = _effective(attributes).get("bodies", ())
    body = bodies[number - 1] if len(bodies) >= number else {}
    return body if isinstance(body, dict) else {}


def opening_of(stress: DoubleArray) -> float:
    """Return how far a cycle misses its beginning: the largest change of a stress over the largest range of one.

    stress: (steps, components, points); of a crack its stress intensities.
    """
    largest = float((stress.max(axis=0) - stress.min(axis=0)).max(initial=0.0))
    return float(np.abs(stress[-1] - stress[0]).max(initial=0.0)) / largest if largest > 0.0 else 0.0


def not_closed(share: float, *, whole_path: bool = False) -> str | None:
    """Return the warning of a cycle that misses its beginning by `share` of its range, None if it is closed.

    whole_path: the cycle is a load path without one.
    """
    if share <= CLOSED_WITHIN:
        return None
    what, advice = "cycle", "more cycles in the load path are needed"
    if whole_path:
        what, advice = "whole load path", "a service that repeats it needs a path that ends as it begins, or a `cycle`"
    return (
        f"the {what} is not closed: its last state differs from its first by {100.0 * share:.3g} % of the range"
        f" (more than {100.0 * CLOSED_WITHIN:g} %); {advice}"
    )


def _effective(attributes: Any) -> dict[str, Any]:
    effective: dict[str, Any] = json.loads(attributes.get("effective_case", "{}"))
    return effective
