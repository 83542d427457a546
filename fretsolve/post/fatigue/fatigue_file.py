"""The file of fatigue parameters: fields over depth, x and y for each body and criterion."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretsolve import __version__
from fretsolve.case.keys.quantity_names import LIFE_NAMES, WORST_NAMES, dataset_name
from fretsolve.case.models import Case
from fretsolve.post.fatigue.criteria import FatigueField
from fretsolve.post.fatigue.critical_plane import SCAN_STEP
from fretsolve.post.fatigue.request import case_request, stresses_of_cycles
from fretsolve.post.fatigue.ruiz import UNITS
from fretsolve.post.fatigue.shakedown import ShakedownSearch
from fretsolve.post.fatigue.stress_cycle import FatigueCycles, StressCycles, stress_cycles, stresses_beside
from fretsolve.post.fatigue.worst import Worst, WorstOfBody, WorstSearch
from fretsolve.post.names import fatigue_path
from fretsolve.post.stress.computed_file import DEPTH, ComputedFile, create_values, opened_beside, opened_computed
from fretsolve.post.stress.stress_file import write_stress
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.result import Result
from fretsolve.result.header import write_sealed
from fretsolve.result.layout import Quantity, X, Y, create_column
from fretsolve.result.part_reader import damage_reported, digests_of, read_columns, require
from fretsolve.system import atomic_files
from fretsolve.system.files import writing
from fretsolve.system.hdf5_files import own_dataset

FORMAT = "fretsolve fatigue 1"
"""Attribute `format` of the root; the number rises whenever an older fretsolve could misread a newer file."""

_AXES = ("depth", "x", "y")

CYCLE = Quantity("cycle", "1", "number of the cycle in the table of cycles", "int64")
TIMES = Quantity("times", "1", "how often the cycle occurs in a block")
COMPONENT = Quantity("component", "1", "component of a normal: 0 along x, 1 along y, 2 along z", "int64")
PARTS = {
    "": ("value", "float64", "{}"),
    "_normal": ("normal", "float64", "normal of the critical plane of {}"),
    "_refined": ("refined", "uint8", "1 where the critical plane of {} is refined, 0 where it is that of the scan"),
    "_utilisation": ("utilisation", "float64", "{} over its limit"),
    "_life": ("life", "float64", "cycles to a crack by {}"),
}
"""Endings of the datasets of a criterion: attribute of `FatigueField`, type, and meaning."""


def write_fatigue(
    cycles: FatigueCycles,
    target: Path,
    show: Callable[[], object] = lambda: None,
    *,
    shakedown: ShakedownSearch | None = None,
    folder: Path | None = None,
    exclusive: bool = False,
) -> tuple[dict[int, WorstOfBody], float]:
    """Compute the parameters of each body, write them, and return the worst places and how far a cycle is open.

    show: called after each layer of each cycle; shakedown: gets each of these; folder: where the file lies until it is
    whole, by default beside `target`; exclusive: replace no file. Raises OSError.
    """
    worst: dict[int, WorstOfBody] = {}
    widest = 0.0
    with atomic_files.new_hdf5(target, folder, exclusive=exclusive) as file:
        content: dict[str, Any] = {}
        for number, of_body in cycles.of_body.items():
            group, scales = _create_body(file, number, of_body)
            search = WorstSearch(cycles, number, shakedown)
            for depth in range(len(of_body.depths)):
                for field in search.layer(depth, show):
                    _write_layer(group, scales, field, depth)
            worst[number], widest = search.found(), max(widest, search.widest)
            columns = [*_AXES, *_write_cycles(group, of_body, worst[number])]
            content[str(number)] = _describe_worst(group, worst[number].total, columns)
        write_sealed(file, {"format": FORMAT, "fretsolve_version": __version__, **cycles.attributes}, content)
    return worst, widest


def write_case_fatigue(result: Result, case: Case, threads: int = 1, folder: Path | None = None) -> Path:
    """Write the fatigue parameters of a finished run beside its result, and return the name of the file.

    Raises CaseError, FileError.
    """
    target, request, tractions = fatigue_path(result.path), case_request(case), TractionHistory(result)
    with writing(target), stresses_beside(target, folder) as stresses:
        computed = stresses_of_cycles(tractions, request)
        write_stress(tractions, computed.stresses, stresses, threads)
        with opened_computed(stresses) as file:
            write_fatigue(stress_cycles(file, stresses, result.path, request, computed), target, folder=folder)
    return target


def _describe_worst(group: Any, worst: Mapping[str, Worst], columns: list[str]) -> dict[str, Any]:
    """Store the worst places as attributes of their datasets, and return what the header says of a body.

    columns: names of the datasets that have a digest.
    """
    parameters: dict[str, dict[str, Any]] = {}
    for name, found in sorted((dataset_name(name), found) for name, found in worst.items()):
        values: dict[str, Any] = {"worst": found.value, "worst_place": list(found.place)}
        if not math.isnan(found.error):
            values["worst_error"] = found.error
        if found.limit is not None:
            values["limit"] = found.limit
        if found.normal is not None:
            values |= {"worst_normal": found.normal, "scan_step": SCAN_STEP}
        if found.life is not None:
            values |= {"shortest_life": found.life.cycles, "shortest_life_place": list(found.life.place)}
            if not math.isnan(found.life.low):
                values["shortest_life_range"] = [found.life.low, found.life.high]
        group[name].attrs.update(values)
        parameters[name] = values | {"units": found.units}
    return {
        "steps": group.attrs["steps"].tolist(),
        "columns": digests_of({name: group[name][:] for name in columns}),
        "fields": sorted(set(group) - {*columns, COMPONENT.name}),
        "parameters": parameters,
    }


def _write_cycles(group: Any, of_body: StressCycles, worst: WorstOfBody) -> list[str]:
    """Write the worst values of each cycle if there are several, and return the names of their columns."""
    cycles = of_body.cycles
    if len(cycles) < 2:
        return []
    scale = create_column(group, CYCLE, [cycle.number for cycle in cycles])
    columns = [(TIMES, [cycle.times for cycle in cycles])]
    for name in worst.total:
        found = [of_cycle[name] for of_cycle in worst.of_cycles]
        values, units = [one.value for one in found], found[0].units
        stem = dataset_name(name)
        columns.append((Quantity(f"{stem}_worst_of_cycle", units, f"largest {name} of each cycle"), values))
        if lives := [one.life.cycles for one in found if one.life is not None]:
            columns.append(
                (Quantity(f"{stem}_life_of_cycle", "1", f"cycles to a crack by {name} of each cycle"), lives)
            )
    for quantity, numbers in columns:
        create_column(group, quantity, numbers, scale)
    return [CYCLE.name, *(quantity.name for quantity, _ in columns)]


def _create_body(file: Any, number: int, of_body: StressCycles) -> tuple[Any, list[Any]]:
    group = file.create_group(f"fatigue/body_{number}")
    body = of_body.body
    group.attrs["steps"] = np.asarray(body.steps)[list(_states(of_body))]
    axes = (DEPTH, of_body.depths), (X, body.x), (Y, body.y), (COMPONENT, np.arange(3))
    return group, [create_column(group, quantity, values) for quantity, values in axes]


def _states(of_body: StressCycles) -> tuple[int, ...]:
    """Return the states of the only cycle in their order, or of several cycles each once."""
    return of_body.cycles[0].states if len(of_body.cycles) == 1 else of_body.states


def _write_layer(group: Any, scales: list[Any], field: FatigueField, depth: int) -> None:
    for ending, (attribute, dtype, meaning) in PARTS.items():
        values, name = getattr(field, attribute), dataset_name(field.criterion) + ending
        if values is None:
            continue
        axes = scales if ending == "_normal" else scales[:3]
        shape = [len(axis) for axis in axes[1:]]
        if name not in group:
            of = field.criterion + (", on the surface; 0 below, where nothing slips" if field.units == UNITS else "")
            texts = {"units": "1" if ending else field.units, "long_name": meaning.format(of)}
            create_values(group, name, axes, dtype, (1, *shape), **texts)
        group[name][depth] = values.T.reshape(shape)


@dataclass(frozen=True, eq=False)
class BodyFatigue:
    """The part of a file of fatigue parameters about one body.

    depths, x, y: in mm; steps: of the cycle; parameters: names of datasets, with what is known of each; group: the open
    HDF5 group of the file `path`.
    """

    path: Path

    depths: NDArray[np.float64]
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    steps: tuple[int, ...]
    parameters: Mapping[str, Mapping[str, Any]]
    group: Any

    @property
    def criteria(self) -> tuple[str, ...]:
        """The names of the parameters' datasets."""
        return tuple(self.parameters)

    def field(self, name: str) -> NDArray[Any]:
        """Return a dataset (depths, nx, ny), or (depths, nx, ny, 3) of normals."""
        with damage_reported(self.path, name):
            dataset = own_dataset(self.group, name)
            whole = (len(self.depths), len(self.x), len(self.y), *((3,) if name.endswith("_normal") else ()))
            require(dataset.shape == whole and dataset.dtype.kind in "fu", name, "the shape of its axes")
            values = np.asarray(dataset[()])
            sound = (values > -np.inf) if name.endswith("_life") else np.isfinite(values)  # an endless life is infinite
            require(sound.all(), name, "numbers, NaN is damage")
            return values

    def attribute(self, name: str, of: str) -> Any:
        """Return what the header says of a dataset, None if that is not known."""
        return self.parameters[name].get(of)

    def worst(self, name: str) -> tuple[float, float]:
        """Return the largest value of a parameter and its error bar, NaN if it is not known."""
        known = self.parameters.get(name, {})
        return float(known.get("worst", math.nan)), float(known.get("worst_error", math.nan))

    def shortest_life(self, name: str) -> tuple[float, float]:
        """Return the shortest life by a parameter and its error bar, NaN if it is not known."""
        known = self.parameters.get(name, {})
        life, bounds = float(known.get("shortest_life", math.nan)), known.get("shortest_life_range")
        if bounds is None:
            return life, math.nan
        return life, max((abs(one - life) for one in bounds if one != life), default=0.0)


def fatigue_bodies(computed: ComputedFile) -> dict[int, BodyFatigue]:
    """Return the bodies of an open file of fatigue parameters. Raises FileError if it is not one, or is damaged."""
    return computed.bodies("fatigue", _read_body)


def read_worst(path: Path, result: Result | None = None) -> dict[str, tuple[float, float]]:
    """Return the largest value of each parameter, by `WORST_NAMES`, and the shortest lives, by `LIFE_NAMES`, of all
    bodies in a file, each with its error bar; NaN for what is not there.

    Raises FileError if it is damaged, or was not computed from `result`.
    """
    found = dict.fromkeys((*WORST_NAMES, *LIFE_NAMES), (math.nan, math.nan))
    if not path.exists():
        return found
    with opened_beside(path, "fatigue", result) as file:
        for body in fatigue_bodies(file).values():
            known = {name: body.worst(dataset_name(criterion)) for name, criterion in WORST_NAMES.items()}
            known |= {name: body.shortest_life(dataset_name(criterion)) for name, criterion in LIFE_NAMES.items()}
            for name, pair in known.items():
                is_worse = pair[0] < found[name][0] if name in LIFE_NAMES else pair[0] > found[name][0]
                if is_worse or math.isnan(found[name][0]):
                    found[name] = pair
    return found


def _read_body(path: Path, group: Any, known: Mapping[str, Any]) -> BodyFatigue:
    columns = read_columns(group, known["columns"])
    for name in known["fields"]:
        with damage_reported(path, name):
            own_dataset(group, name)
    depths, x, y = (columns[name] for name in _AXES)
    return BodyFatigue(path, depths, x, y, tuple(known["steps"]), known["parameters"], group)
