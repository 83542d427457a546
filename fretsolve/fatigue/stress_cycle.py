"""The stresses of one cycle, read layer by layer from a file of stresses, averaged if wanted."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from fretsolve.case.loading import stored_case
from fretsolve.case.models import Case
from fretsolve.errors import CaseError
from fretsolve.fatigue.averaging import Average, depth_weights
from fretsolve.fatigue.criteria.invariants import COMPONENTS
from fretsolve.fatigue.cycle import opening, require_states
from fretsolve.stress.stress_file import BodyStress
from fretsolve.stress.tractions import cycle_stages
from fretsolve.system.arrays import DoubleArray


@dataclass(frozen=True, eq=False)
class StressCycle:
    """The stresses of a body over one cycle; path: their file.

    chosen: positions in the file of the cycle's increments; before them that of the state with which it begins.
    """

    path: Path
    body: BodyStress
    chosen: tuple[int, ...]
    average: Average | None = None

    def __post_init__(self) -> None:
        missing = [name for name in COMPONENTS if name not in self.body.components]
        try:
            if missing:
                raise CaseError(f"the file lacks the components {', '.join(missing)}, all six are needed")
            require_states(len(self.chosen))
            if self.average is not None:
                self.average.require_resolved(self.body.depths, self.cell)
        except CaseError as error:
            raise CaseError(error.message, (), self.path) from None

    @property
    def cell(self) -> tuple[float, float]:
        """The sides of a cell (mm); the same along a direction with one cell."""
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

    def layers(self) -> Iterator[DoubleArray]:
        """Yield the stresses (steps, 6, points) of each of `depths`."""
        if self.average is not None:
            weights = depth_weights(self.body.depths, *self.average.depth_range)
            means = [self.average.of(self._whole(index), weights, self.cell) for index in self.chosen]
            yield np.stack(means).reshape(len(self.chosen), 6, -1)
            return
        for depth in range(len(self.depths)):
            layer = [self.body.layer(COMPONENTS, index, depth) for index in self.chosen]
            yield np.array(layer, np.float64).reshape(len(self.chosen), 6, -1)

    def _whole(self, index: int) -> DoubleArray:
        return self.body.stress(index).astype(np.float64)


def cycle_of(body: BodyStress, attributes: Any) -> tuple[int, ...]:
    """Return the positions of the increments of the last cycle in a file of stresses, after that of its beginning.

    It begins with the state before it, or with its end where wear has changed the surfaces before it: cells that have
    come into contact by this carry no shear before they have slipped once, but do whenever the cycle begins again. All
    increments of the file if its load path has no `cycle`. attributes: those of the file.
    """
    everything, case = tuple(range(len(body.steps))), _case(attributes)
    found = cycle_stages(case, int(body.stages.max(initial=0)))
    if case is None or found is None:
        return everything
    inside = [index for index in everything if found[0] < body.stages[index] <= found[1]]
    before = [index for index in everything if body.stages[index] <= found[0]]
    if before and case.wear is not None and case.stages()[found[0] - 1].wears is not None:
        before = inside
    return (*before[-1:], *inside)


def elastic_body(attributes: Any, number: int) -> dict[str, Any]:
    """Return a body of the effective case of a file of stresses, empty if it is not known or rigid."""
    bodies = _effective(attributes).get("bodies", ())
    body = bodies[number - 1] if len(bodies) >= number else {}
    return body if isinstance(body, dict) else {}


def opening_of(stress: DoubleArray) -> float:
    """Return how far the last of stresses (steps, 6, points) is from the first one, over the largest range."""
    return opening(stress[0], stress[-1], stress.max(axis=0) - stress.min(axis=0))


def _effective(attributes: Any) -> dict[str, Any]:
    effective: dict[str, Any] = json.loads(attributes.get("effective_case", "{}"))
    return effective


def _case(attributes: Any) -> Case | None:
    try:
        return stored_case(_effective(attributes))
    except json.JSONDecodeError:
        return None
