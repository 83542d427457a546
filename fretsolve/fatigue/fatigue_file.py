"""The file of fatigue parameters: fields over depth, x and y for each body and criterion."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretsolve import __version__
from fretsolve.case.keys.material_spec import Material
from fretsolve.errors import FileError
from fretsolve.fatigue.criteria.by_name import FatigueField, fatigue_field
from fretsolve.fatigue.criteria.critical_plane import SCAN_STEP
from fretsolve.fatigue.names import WORST_NAMES, dataset_name
from fretsolve.fatigue.request import FatigueRequest
from fretsolve.fatigue.stress_cycle import StressCycle, opening_of
from fretsolve.result import Result
from fretsolve.result.header import write_sealed
from fretsolve.result.layout import FIELD_FILTERS, Quantity, X, Y, create_column
from fretsolve.result.part_reader import damage_reported, digests_of, read_columns, require
from fretsolve.stress.names import ComputedFile, opened_computed, require_made_from
from fretsolve.stress.stress_file import DEPTH
from fretsolve.system import atomic_files
from fretsolve.system.arrays import DoubleArray
from fretsolve.system.files import reported
from fretsolve.system.foreign_files import own_dataset, own_node

FORMAT = "fretsolve fatigue 1"
"""Attribute `format` of the root; the number rises whenever an older fretsolve could misread a newer file."""

_AXES = ("depth", "x", "y")

COMPONENT = Quantity("component", "1", "component of a normal: 0 along x, 1 along y, 2 along z", "int64")
MEANINGS = {
    "": "{}",
    "_normal": "normal of the critical plane of {}",
    "_refined": "1 where the critical plane of {} is refined, 0 where it is that of the scan",
    "_utilisation": "{} over its limit",
    "_life": "cycles to a crack by {}",
}


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
    normal: tuple[float, float, float] | None = None
    life: float | None = None
    outermost: bool = False


@dataclass(frozen=True, eq=False)
class FatigueCycles:
    """The stresses of a cycle and the constants of each body; attributes: those of the file of parameters."""

    request: FatigueRequest
    of_body: Mapping[int, StressCycle]
    materials: Mapping[int, Material]
    attributes: Mapping[str, str]

    @property
    def layers(self) -> int:
        """The number of layers of all bodies."""
        return sum(len(cycle.depths) for cycle in self.of_body.values())


def write_fatigue(
    cycles: FatigueCycles, target: Path, show: Callable[[], object] = lambda: None, *, exclusive: bool = False
) -> tuple[dict[int, dict[str, Worst]], float]:
    """Compute the parameters of each body, write them, and return the worst places and how far the cycle is open.

    show: called after each layer; exclusive: replace no file. Raises OSError.
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
                for name, field in _fields(cycles.request.criteria, cycles.materials[number], stress, worst[number]):
                    _write_layer(group, scales, field, depth)
                    found = _worst_of(field, cycle, depth)
                    if name not in worst[number] or found.value > worst[number][name].value:
                        worst[number][name] = found
                show()
            content[str(number)] = _describe_worst(group, worst[number])
        write_sealed(file, {"format": FORMAT, "fretsolve_version": __version__, **cycles.attributes}, content)
    return worst, widest


def _describe_worst(group: Any, worst: Mapping[str, Worst]) -> dict[str, Any]:
    """Store the worst places as attributes of their datasets, and return what the header says of a body."""
    parameters = {dataset_name(name): _attributes_of(found) for name, found in sorted(worst.items())}
    for name, values in parameters.items():
        group[name].attrs.update(values)
    units = {dataset_name(name): {"units": found.units} for name, found in worst.items()}
    return {
        "steps": group.attrs["steps"].tolist(),
        "columns": digests_of({name: group[name][:] for name in _AXES}),
        "fields": sorted(set(group) - {*_AXES, COMPONENT.name}),
        "parameters": {name: values | units[name] for name, values in parameters.items()},
    }


def _fields(
    criteria: tuple[str, ...], material: Material, stress: DoubleArray, before: Mapping[str, Worst]
) -> Iterator[tuple[str, FatigueField]]:
    """Yield each criterion in a layer; before: the worst of the layers before it, below which no plane is refined."""
    for name in criteria:
        options = {"known": before[name].value} if name in before and before[name].normal is not None else {}
        yield name, fatigue_field(name, material, stress, **options)


def _create_body(file: Any, number: int, cycle: StressCycle) -> tuple[Any, list[Any]]:
    """Create the group of a body with its axes, and return it with their scales."""
    group = file.create_group(f"fatigue/body_{number}")
    body = cycle.body
    group.attrs["steps"] = np.asarray(body.steps)[list(cycle.chosen)]
    axes = (DEPTH, cycle.depths), (X, body.x), (Y, body.y), (COMPONENT, np.arange(3))
    return group, [create_column(group, quantity, values) for quantity, values in axes]


def _write_layer(group: Any, scales: list[Any], field: FatigueField, depth: int) -> None:
    """Write the values of a criterion at one depth."""
    name, title = dataset_name(field.criterion), field.criterion
    normal = field.normal.T if field.normal is not None else None
    parts: dict[str, tuple[NDArray[Any] | None, str]] = {
        "": (field.value, field.units),
        "_normal": (normal, "1"),
        "_refined": (field.refined, "1"),
        "_utilisation": (field.utilisation, "1"),
        "_life": (field.life, "1"),
    }
    shape = tuple(len(scale) for scale in scales[:3])
    for suffix, (values, units) in parts.items():
        if values is None:
            continue
        axes = scales if suffix == "_normal" else scales[:3]
        if name + suffix not in group:
            kind = "uint8" if suffix == "_refined" else "float64"
            whole = tuple(len(scale) for scale in axes)
            dataset = group.create_dataset(name + suffix, whole, kind, chunks=(1, *whole[1:]), **FIELD_FILTERS)
            dataset.attrs.update(units=units, long_name=MEANINGS[suffix].format(title))
            for axis, scale in enumerate(axes):
                dataset.dims[axis].attach_scale(scale)
        group[name + suffix][depth] = values.reshape(*shape[1:], *values.shape[1:])


def _worst_of(field: FatigueField, cycle: StressCycle, depth: int) -> Worst:
    point = field.worst
    i, j = divmod(point, cycle.shape[1])
    return Worst(
        field.criterion,
        field.units,
        float(field.value[point]),
        (float(cycle.body.x[i]), float(cycle.body.y[j]), float(cycle.depths[depth])),
        field.limit,
        (float(field.normal[0, point]), float(field.normal[1, point]), float(field.normal[2, point]))
        if field.normal is not None
        else None,
        float(field.life[point]) if field.life is not None else None,
        any(size > 1 and number in (0, size - 1) for number, size in zip((i, j), cycle.shape, strict=True)),
    )


def _attributes_of(worst: Worst) -> dict[str, Any]:
    """Return the attributes of a criterion's dataset."""
    found: dict[str, Any] = {"worst": worst.value, "worst_place": list(worst.place)}
    if worst.limit is not None:
        found["limit"] = worst.limit
    if worst.normal is not None:
        found |= {"worst_normal": worst.normal, "scan_step": SCAN_STEP}
    return found


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


def fatigue_bodies(computed: ComputedFile | None, path: Path) -> dict[int, BodyFatigue]:
    """Return the bodies of an open file of fatigue parameters. Raises FileError if it is not one, or is damaged."""
    if computed is None or computed.kind != "fatigue" or not computed.content:
        raise FileError("is not a file of fatigue parameters, which `fretsolve fatigue` writes", path)
    with damage_reported(path, "the parameters"):
        known = {int(number): body for number, body in computed.content.items()}
        return {
            number: _read_body(path, own_node(computed.file, f"fatigue/body_{number}"), body)
            for number, body in known.items()
        }


def read_worst(path: Path, result: Result | None = None) -> dict[str, float]:
    """Return the largest value of each parameter in a file, of all bodies, by `WORST_NAMES`; NaN for what is not there.

    Raises FileError if it is damaged, or was not computed from `result`.
    """
    found = dict.fromkeys(WORST_NAMES, math.nan)
    if not path.exists():
        return found
    if result is not None:
        require_made_from(result, path)
    with reported("cannot be read", path), opened_computed(path) as file:
        for body in fatigue_bodies(file, path).values():
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
