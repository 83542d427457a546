"""The file of stresses: components of each body over increment, depth, x and y, and the largest stresses.

It lies beside the result, which stays as it is. Components are stored in single precision, 6e-8 of each value.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretsolve import __version__
from fretsolve.case.keys.output_spec import StressSpec
from fretsolve.case.keys.quantity_names import PEAK_NAMES
from fretsolve.post.names import stress_path
from fretsolve.post.stress.computed_file import DEPTH, ComputedFile, create_values, opened_beside
from fretsolve.post.stress.cycles import cycles_as_text, cycles_of, within
from fretsolve.post.stress.influence import COMPONENTS, Body, Component
from fretsolve.post.stress.invariants import MEANINGS
from fretsolve.post.stress.peaks import Key, Peak, PeakSearch
from fretsolve.post.stress.request import StressRequest, case_request, cell_centres, layers
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.result import Result
from fretsolve.result.header import write_sealed
from fretsolve.result.layout import STEP, Quantity, X, Y, chunk_shape, create_column
from fretsolve.result.part_reader import damage_reported, digests_of, read_columns, require
from fretsolve.system import atomic_files
from fretsolve.system.files import writing
from fretsolve.system.hdf5_files import own_dataset

FORMAT = "fretsolve stress 1"
"""Attribute `format` of the root; the number rises whenever an older fretsolve could misread a newer file."""

STAGE = Quantity("stage", "1", "stage of the load path, counted from 1 with cycles unrolled", "int64")

_PEAK_COLUMNS: tuple[tuple[str, str, str, str], ...] = (
    ("", "value", "MPa", "{}; at the edge of contact extrapolated to cells of no size"),
    ("_error", "error", "MPa", "estimated error of the {}"),
    ("_on_cells", "on_cells", "MPa", "{} at the centres of cells"),
    ("_x", "x", "mm", "x of the {}"),
    ("_y", "y", "mm", "y of the {}"),
    ("_depth", "depth", "mm", "depth of the {}"),
)


def write_stress(
    tractions: TractionHistory,
    request: StressRequest,
    target: Path,
    threads: int = 1,
    show: Callable[[], object] = lambda: None,
    *,
    folder: Path | None = None,
    exclusive: bool = False,
) -> dict[Key, list[Peak]]:
    """Compute the stresses, write them to `target`, and return the largest ones of each increment.

    show: called after each layer of each increment; folder: where the file lies until it is whole, by default beside
    `target`; exclusive: replace no file. Raises OSError, FileError.
    """
    search = PeakSearch(tractions, request)
    with atomic_files.new_hdf5(target, folder, exclusive=exclusive) as file:
        result = tractions.result
        names = "title", "case_yaml", "effective_case"
        attributes = {"format": FORMAT, "fretsolve_version": __version__, "result": result.path.name}
        attributes["cycles"] = cycles_as_text(within(cycles_of(result), request.steps, result.steps))
        attributes |= {name: result.attributes[name] for name in names if name in result.attributes}
        datasets = {body: _create_body(file, tractions, request, body) for body in request.bodies}
        for layer in layers(tractions, request, threads):
            search.add(layer)
            for component, dataset in datasets[layer.body].items():
                dataset[layer.step_index, layer.depth_index] = layer.stress[COMPONENTS.index(component)]
            show()
        peaks = search.peaks()
        for (body, name), found in peaks.items():
            group = file[f"stress/body_{body}"]
            for suffix, attribute, units, meaning in _PEAK_COLUMNS:
                quantity = Quantity(f"max_{name}{suffix}", units, meaning.format(MEANINGS[name]))
                create_column(group, quantity, [getattr(peak, attribute) for peak in found], group["step"])
        content = {}
        for body in datasets:
            members = file[f"stress/body_{body}"].items()
            content[str(body)] = digests_of({name: dataset[:] for name, dataset in members if dataset.ndim == 1})
        write_sealed(file, attributes, content)
    return peaks


def write_case_stress(result: Result, spec: StressSpec, threads: int, folder: Path | None = None) -> Path:
    """Write the stresses of a finished run beside its result, and return the name of the file.

    Raises CaseError, FileError.
    """
    target = stress_path(result.path)
    tractions = TractionHistory(result)
    with writing(target):
        write_stress(tractions, case_request(tractions, spec), target, threads, folder=folder)
    return target


def _create_body(file: Any, tractions: TractionHistory, request: StressRequest, body: Body) -> dict[Component, Any]:
    """Create the group of a body with its axes, and return the datasets of the components that are stored."""
    group = file.create_group(f"stress/body_{body}")
    group.attrs["poisson_ratio"] = tractions.poisson_ratios[body]
    x, y = cell_centres(tractions.grid, request.target)
    axes = (STEP, request.steps), (DEPTH, request.depths), (X, x), (Y, y)
    scales = [create_column(group, quantity, values) for quantity, values in axes]
    stage = tractions.result.history["stage"]
    create_column(group, STAGE, [stage[step] for step in request.steps], scales[0])
    found: dict[Component, Any] = {}
    chunks = (1, 1, *chunk_shape(*request.shape))
    for name in request.stored:
        meaning = f"stress {name} in body {body}, positive in tension"
        found[name] = create_values(group, name, scales, "float32", chunks, units="MPa", long_name=meaning)
    return found


@dataclass(frozen=True, eq=False)
class BodyStress:
    """The part of a file of stresses about one body.

    steps, stages: of the increments; depths, x, y: in mm; columns: the largest stresses over the increments, by name;
    components: names of the stored components, as ``(steps, depths, nx, ny)`` in the open HDF5 group of `path`.
    """

    path: Path

    steps: NDArray[np.int64]
    stages: NDArray[np.int64]
    depths: NDArray[np.float64]
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    columns: Mapping[str, NDArray[np.float64]]
    components: tuple[Component, ...]
    group: Any

    def stress(self, step_index: int) -> NDArray[np.float32]:
        """Return all stored components of an increment, ``(components, depths, nx, ny)``."""
        return np.stack([self._read(name, step_index) for name in self.components])

    def layer(self, names: Sequence[str], step_index: int, depth_index: int) -> NDArray[np.float32]:
        """Return components of an increment at one depth, ``(components, nx, ny)``. Raises FileError."""
        return np.stack([self._read(name, (step_index, depth_index)) for name in names])

    def _read(self, name: str, place: int | tuple[int, int]) -> NDArray[np.float32]:
        with damage_reported(self.path, name):
            values: NDArray[np.float32] = own_dataset(self.group, name)[place]
            require(np.isfinite(values).all(), name, "finite numbers, NaN is damage")
            return values


def bodies_of(stresses: ComputedFile) -> dict[int, BodyStress]:
    """Return the bodies of an open file of stresses. Raises FileError if it is not one, or is damaged."""
    return stresses.bodies("stress", _read_body)


def read_peaks(path: Path, result: Result | None = None) -> dict[str, dict[int, tuple[float, float]]]:
    """Return the largest stresses of all bodies in a file, with their errors: by name (`PEAK_NAMES`) and increment.

    Empty if there is no file. Raises FileError if it is damaged, or was not computed from `result`.
    """
    found: dict[str, dict[int, tuple[float, float]]] = {name: {} for name in PEAK_NAMES}
    if not path.exists():
        return found
    with opened_beside(path, "stress", result) as file:
        for body in bodies_of(file).values():
            for name, known in found.items():
                for index, step in enumerate(body.steps.tolist()):
                    peak = float(body.columns[name][index]), float(body.columns[f"{name}_error"][index])
                    known[step] = max(known.get(step, peak), peak)
    return found


def _read_body(path: Path, group: Any, digests: Mapping[str, str]) -> BodyStress:
    stored = read_columns(group, digests)
    axes = {name: stored[name] for name in ("step", "stage", "depth", "x", "y")}
    columns = {name: column for name, column in stored.items() if name.startswith("max_")}
    components = tuple(name for name in COMPONENTS if name in group)
    whole = len(axes["step"]), len(axes["depth"]), len(axes["x"]), len(axes["y"])
    if missing := {f"{name}{suffix}" for name in PEAK_NAMES for suffix, *_ in _PEAK_COLUMNS} - set(columns):
        raise KeyError(f"no column {min(missing)}")
    for name in components:
        stress = own_dataset(group, name)
        if stress.shape != whole or stress.dtype != np.float32:
            raise ValueError(f"{name} does not have the shape of its axes")
    if any(len(column) != whole[0] for column in (axes["stage"], *columns.values())):
        raise ValueError("the largest stresses do not have a value per increment")
    steps, stages, depths, x, y = axes.values()
    return BodyStress(path, steps, stages, depths, x, y, columns, components, group)
