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
from fretsolve.case.keys.quantity_names import WORST_NAMES, dataset_name
from fretsolve.case.models import Case
from fretsolve.post.fatigue.criteria import FatigueField, fatigue_field
from fretsolve.post.fatigue.critical_plane import SCAN_STEP
from fretsolve.post.fatigue.request import case_request, stresses_of_cycle
from fretsolve.post.fatigue.shakedown import ShakedownSearch
from fretsolve.post.fatigue.stress_cycle import FatigueCycles, StressCycle, opening_of, stress_cycles, stresses_beside
from fretsolve.post.names import fatigue_path
from fretsolve.post.stress.computed_file import DEPTH, ComputedFile, create_values, opened_beside, opened_computed
from fretsolve.post.stress.request import is_outermost
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

COMPONENT = Quantity("component", "1", "component of a normal: 0 along x, 1 along y, 2 along z", "int64")
PARTS = {
    "": ("value", "float64", "{}"),
    "_normal": ("normal", "float64", "normal of the critical plane of {}"),
    "_refined": ("refined", "uint8", "1 where the critical plane of {} is refined, 0 where it is that of the scan"),
    "_utilisation": ("utilisation", "float64", "{} over its limit"),
    "_life": ("life", "float64", "cycles to a crack by {}"),
}
"""Endings of the datasets of a criterion: attribute of `FatigueField`, type, and meaning."""


@dataclass(frozen=True)
class Worst:
    """The largest value of a criterion: where it is (mm), its plane, and what follows from it.

    outermost: it is in the last cells along x or y, so that it may be larger beyond.
    """

    criterion: str
    units: str
    value: float
    place: tuple[float, float, float]
    limit: float | None = None
    normal: tuple[float, ...] | None = None
    life: float | None = None
    outermost: bool = False


def write_fatigue(
    cycles: FatigueCycles,
    target: Path,
    show: Callable[[], object] = lambda: None,
    *,
    shakedown: ShakedownSearch | None = None,
    exclusive: bool = False,
) -> tuple[dict[int, dict[str, Worst]], float]:
    """Compute the parameters of each body, write them, and return the worst places and how far the cycle is open.

    show: called after each layer; shakedown: gets each layer; exclusive: replace no file. Raises OSError.
    """
    worst: dict[int, dict[str, Worst]] = {}
    widest = 0.0
    with atomic_files.new_hdf5(target, exclusive=exclusive) as file:
        content: dict[str, Any] = {}
        for number, cycle in cycles.of_body.items():
            group, scales = _create_body(file, number, cycle)
            worst[number] = {}
            for depth, stress in enumerate(cycle.layers()):
                widest = max(widest, opening_of(stress))
                if shakedown is not None:
                    shakedown.add(number, cycle, depth, stress)
                for name in cycles.request.criteria:
                    # no plane is refined that is below the worst one of the layers before
                    before = worst[number].get(name)
                    known = {} if before is None or before.normal is None else {"known": before.value}
                    field = fatigue_field(name, cycles.materials[number], stress, **known)
                    _write_layer(group, scales, field, depth)
                    found = _worst_of(field, cycle, depth)
                    if before is None or found.value > before.value:
                        worst[number][name] = found
                show()
            content[str(number)] = _describe_worst(group, worst[number])
        write_sealed(file, {"format": FORMAT, "fretsolve_version": __version__, **cycles.attributes}, content)
    return worst, widest


def write_case_fatigue(result: Result, case: Case, threads: int = 1) -> Path:
    """Write the fatigue parameters of a finished run beside its result, and return the name of the file.

    Raises CaseError, FileError.
    """
    target, request, tractions = fatigue_path(result.path), case_request(case), TractionHistory(result)
    with writing(target), stresses_beside(target) as stresses:
        write_stress(tractions, stresses_of_cycle(tractions, request), stresses, threads)
        with opened_computed(stresses) as file:
            write_fatigue(stress_cycles(file, stresses, result.path, request), target)
    return target


def _describe_worst(group: Any, worst: Mapping[str, Worst]) -> dict[str, Any]:
    """Store the worst places as attributes of their datasets, and return what the header says of a body."""
    parameters: dict[str, dict[str, Any]] = {}
    for name, found in sorted((dataset_name(name), found) for name, found in worst.items()):
        values: dict[str, Any] = {"worst": found.value, "worst_place": list(found.place)}
        if found.limit is not None:
            values["limit"] = found.limit
        if found.normal is not None:
            values |= {"worst_normal": found.normal, "scan_step": SCAN_STEP}
        group[name].attrs.update(values)
        parameters[name] = values | {"units": found.units}
    return {
        "steps": group.attrs["steps"].tolist(),
        "columns": digests_of({name: group[name][:] for name in _AXES}),
        "fields": sorted(set(group) - {*_AXES, COMPONENT.name}),
        "parameters": parameters,
    }


def _create_body(file: Any, number: int, cycle: StressCycle) -> tuple[Any, list[Any]]:
    group = file.create_group(f"fatigue/body_{number}")
    body = cycle.body
    group.attrs["steps"] = np.asarray(body.steps)[list(cycle.cycle.states)]
    axes = (DEPTH, cycle.depths), (X, body.x), (Y, body.y), (COMPONENT, np.arange(3))
    return group, [create_column(group, quantity, values) for quantity, values in axes]


def _write_layer(group: Any, scales: list[Any], field: FatigueField, depth: int) -> None:
    for ending, (attribute, dtype, meaning) in PARTS.items():
        values, name = getattr(field, attribute), dataset_name(field.criterion) + ending
        if values is None:
            continue
        axes = scales if ending == "_normal" else scales[:3]
        shape = [len(axis) for axis in axes[1:]]
        if name not in group:
            texts = {"units": "1" if ending else field.units, "long_name": meaning.format(field.criterion)}
            create_values(group, name, axes, dtype, (1, *shape), **texts)
        group[name][depth] = values.T.reshape(shape)


def _worst_of(field: FatigueField, cycle: StressCycle, depth: int) -> Worst:
    point = field.worst
    i, j = divmod(point, cycle.shape[1])
    return Worst(
        field.criterion,
        field.units,
        float(field.value[point]),
        (float(cycle.body.x[i]), float(cycle.body.y[j]), float(cycle.depths[depth])),
        field.limit,
        None if field.normal is None else tuple(field.normal[:, point].tolist()),
        None if field.life is None else float(field.life[point]),
        is_outermost((i, j), cycle.shape),
    )


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


def fatigue_bodies(computed: ComputedFile) -> dict[int, BodyFatigue]:
    """Return the bodies of an open file of fatigue parameters. Raises FileError if it is not one, or is damaged."""
    return computed.bodies("fatigue", _read_body)


def read_worst(path: Path, result: Result | None = None) -> dict[str, float]:
    """Return the largest value of each parameter in a file, of all bodies, by `WORST_NAMES`; NaN for what is not there.

    Raises FileError if it is damaged, or was not computed from `result`.
    """
    found = dict.fromkeys(WORST_NAMES, math.nan)
    if not path.exists():
        return found
    with opened_beside(path, "fatigue", result) as file:
        for body in fatigue_bodies(file).values():
            for name, criterion in WORST_NAMES.items():
                if dataset_name(criterion) in body.criteria:
                    value = float(body.attribute(dataset_name(criterion), "worst"))
                    found[name] = value if math.isnan(found[name]) else max(found[name], value)
    return found


def _read_body(path: Path, group: Any, known: Mapping[str, Any]) -> BodyFatigue:
    columns = read_columns(group, known["columns"])
    for name in known["fields"]:
        with damage_reported(path, name):
            own_dataset(group, name)
    depths, x, y = (columns[name] for name in _AXES)
    return BodyFatigue(path, depths, x, y, tuple(known["steps"]), known["parameters"], group)
