"""Choose what a picture of fatigue parameters shows: sections and layers through the worst place, and their extent."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from matplotlib.transforms import Bbox
from scipy.ndimage import label

from fretsolve.case.keys.quantity_names import SLIP_CRITERIA, dataset_name
from fretsolve.post.fatigue.fatigue_file import BodyFatigue
from fretsolve.post.names import PARAMETERS
from fretsolve.post.plots.labels import quantity_label
from fretsolve.post.plots.pictures.stresses import DEEPEST, SIDE_MARGIN
from fretsolve.post.plots.snapshot import Snapshot, cell_size, outer_edges
from fretsolve.result import Result
from fretsolve.system.arrays import BoolArray, DoubleArray

SHARE = 0.5
"""How far the hot spot reaches down from the largest parameter to the median, which is that of its surroundings."""

MARGIN, FEWEST = 0.25, 4
"""Margin of the hot spot over its larger side, and cells on each side of the worst place that are shown at least."""

FLATTEST = 0.5
"""Least height of what is shown over its width."""

PARTS = {"utilisation": "{} over its limit", "life": "life by {}", "damage": "damage by {}"}
"""Endings of the datasets that may be drawn in place of a parameter, in words."""

WHITE = {"life": "run-out", "damage": "no damage"}
"""Endings of datasets on a logarithmic scale, and the meaning of places without a colour."""


@dataclass(frozen=True, eq=False)
class Panel:
    """A dataset of a criterion of a body, drawn as a section, a layer or a curve (`kind`) through the worst place.

    part: the ending of the dataset, of `PARTS`, or empty for the parameter; contact: cells of the body's window that
    touch; whole: it shows the whole contact, else the hot spot; named: the title names the body.
    """

    number: int
    body: BodyFatigue
    criterion: str
    part: str
    kind: str
    contact: BoolArray
    named: bool
    whole: bool = False

    @cached_property
    def parameter(self) -> DoubleArray:
        """The parameter over depth, x and y."""
        return self.body.field(self.criterion)

    @cached_property
    def values(self) -> DoubleArray:
        """The values that are drawn, over depth, x and y; NaN where it has no colour."""
        if not self.part:
            return self.parameter
        found = self.body.field(f"{self.criterion}_{self.part}")
        return np.where(np.isfinite(found) & (found > 0.0), found, np.nan) if self.part in WHITE else found

    @cached_property
    def worst_place(self) -> tuple[int, int, int]:
        """Indices of the largest parameter over depth, x and y."""
        depth, i, j = (int(part) for part in np.unravel_index(int(self.parameter.argmax()), self.parameter.shape))
        return depth, i, j

    @property
    def words(self) -> str:
        """The name of what is drawn."""
        name = PARAMETERS[self.criterion]
        return PARTS.get(self.part, "{}").format(name.removesuffix(" parameter") if self.part in WHITE else name)

    @property
    def label(self) -> str:
        """The label of the axis or colours."""
        units = "" if self.part else str(self.body.attribute(self.criterion, "units"))
        return quantity_label(self.words, "cycles" if self.part == "life" else units)

    @property
    def title(self) -> str:
        """The criterion, and where the section or layer lies."""
        depth, _, j = self.worst_place
        name = f"body {self.number}, " * self.named + PARAMETERS[self.criterion].removesuffix(" parameter")
        if self.kind == "section":
            return name if len(self.body.y) == 1 else f"{name} at y = {self.body.y[j]:.3g} mm"
        return f"{name} at depth {self.body.depths[depth]:.3g} mm"

    @property
    def across(self) -> DoubleArray:
        """Depths of a section, or y of a layer (mm)."""
        return self.body.depths if self.kind == "section" else self.body.y

    @property
    def worst(self) -> tuple[int, int]:
        """Indices of the worst place in the section or layer."""
        depth, i, j = self.worst_place
        return (i, depth) if self.kind == "section" else (i, j)

    def plane(self, values: DoubleArray) -> DoubleArray:
        """Return the values in the section, (nx, depths), or in the layer, (nx, ny)."""
        depth, _, j = self.worst_place
        return values[:, :, j].T if self.kind == "section" else values[depth]

    @cached_property
    def box(self) -> Bbox:
        """The part of the section or layer that is shown (mm)."""
        return self._inside(*self._around_contact()) if self.whole else self.hot_spot

    @cached_property
    def hot_spot(self) -> Bbox:
        """The points about the worst place that stand out from their surroundings, and the nearest edge of contact."""
        values = self.plane(self.parameter)
        regions, _ = label(values >= values[self.worst] - SHARE * (values[self.worst] - np.median(values)))
        hot = np.nonzero(regions == regions[self.worst])
        seen = [self.body.x[hot[0]], self.across[hot[1]]]
        if (edge := self._nearest_edge()) is not None:
            seen = [np.append(one, place) for one, place in zip(seen, edge, strict=True)]
        corners = np.array([[one.min() for one in seen], [one.max() for one in seen]])
        margin = max(MARGIN * float(np.ptp(corners, axis=0).max()), FEWEST * cell_size(self.body.x))
        corners += [[-margin], [margin]]
        width, height = np.ptp(corners, axis=0)
        corners[:, 1] += np.array([-0.5, 0.5]) * max(FLATTEST * width - height, 0.0)
        return self._inside(corners, max(float(corners[1, 1]), FLATTEST * float(width)))

    def _inside(self, corners: DoubleArray, deep: float) -> Bbox:
        """Return a box by two corners (2, 2), or by its sides along x and its depth, within the window of the body."""
        ends = outer_edges(self.body.x), outer_edges(self.body.y)
        if self.kind == "section":
            corners[:, 1] = 0.0, deep
            ends = ends[0], (0.0, float(self.body.depths[-1]))
        return Bbox(np.clip(corners, *np.transpose(ends)))

    def _around_contact(self) -> tuple[DoubleArray, float]:
        """Return two corners (2, 2) of what touches, with the worst place and a margin, and the depth of a section."""
        corners, margins = np.empty((2, 2)), np.empty(2)
        _, *worst = self.worst_place
        for axis, (centres, at) in enumerate(zip((self.body.x, self.body.y), worst, strict=True)):
            touching = centres[self.contact.any(axis=1 - axis)]
            seen = np.append(touching if len(touching) else centres, centres[at])
            corners[:, axis] = seen.min(), seen.max()
            margins[axis] = 0.5 * SIDE_MARGIN * np.ptp(touching) if len(touching) else 0.0
        corners += [-margins, margins]
        deep = 0.5 * DEEPEST / (1.0 + SIDE_MARGIN) * float(np.ptp(corners[:, 0]))
        return corners, max(deep, 1.2 * float(self.body.depths[self.worst_place[0]]))

    def _nearest_edge(self) -> tuple[float, float] | None:
        """Return the cell beside which contact ends (mm) that is nearest to the worst place; None without any."""
        _, i, j = self.worst_place
        touching = self.contact[:, j : j + 1] if self.kind == "section" else self.contact
        ends = np.concatenate([np.argwhere(np.diff(touching, axis=axis)) for axis in (0, 1)])
        if not len(ends):
            return None
        worst = np.array([i, 0 if self.kind == "section" else j])
        nearest = ends[np.square(ends - worst).sum(axis=1).argmin()]
        return float(self.body.x[nearest[0]]), 0.0 if self.kind == "section" else float(self.body.y[nearest[1]])


def panels_of(result: Result, number: int, body: BodyFatigue, name: str, *, named: bool) -> Iterator[Panel]:
    """Yield the panels of a dataset: a section and a layer, or a section twice, or a curve where neither is there."""
    criterion = max((one for one in body.criteria if name.startswith(one)), key=len)
    below = len(body.depths) > 1 and criterion not in map(dataset_name, SLIP_CRITERIA)
    there = [("section", below), ("layer", len(body.y) > 1)]
    kinds = [kind for kind, is_there in there if is_there]
    contact = _largest_contact(result, body)
    for kind in kinds or ["curve"]:
        panel = Panel(number, body, criterion, name[len(criterion) + 1 :], kind, contact, named)
        yield panel
        if kinds == ["section"]:
            yield replace(panel, whole=True)


def _largest_contact(result: Result, body: BodyFatigue) -> BoolArray:
    """Return the cells of a body's window that touch where the most cells of the cycle do, ``(nx, ny)``."""
    stored = [step for step in body.steps if step in result.steps]
    if not stored:
        return np.zeros((len(body.x), len(body.y)), bool)
    most = max(stored, key=lambda step: int(result.history["contact_cells"][step]))
    touching = Snapshot(result, most).contact
    grid = (result.x, body.x), (result.y, body.y)  # the window may reach beyond the grid
    cells = [np.rint((of - centres[0]) / cell_size(centres)).astype(int) for centres, of in grid]
    inside = [(index >= 0) & (index < count) for index, count in zip(cells, touching.shape, strict=True)]
    clipped = [np.clip(index, 0, count - 1) for index, count in zip(cells, touching.shape, strict=True)]
    return np.asarray(touching[np.ix_(*clipped)] & inside[0][:, None] & inside[1])
