"""The results of a sweep as one table: settings, what was found at the ends of stages, and its error bars."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretsolve.case.quantities import QuantityError, split_quantity
from fretsolve.errors import CaseError, FileError
from fretsolve.result import Result, open_result
from fretsolve.result.state import ERROR_SUFFIX
from fretsolve.study.quantity import NAMES, Observable
from fretsolve.sweep.manifest import Manifest, Row
from fretsolve.sweep.regime import regime
from fretsolve.sweep.state import CaseState, states
from fretsolve.system.arrays import DoubleArray

UNITS = {name: Observable(name, 1).units for name in NAMES}


@dataclass(frozen=True, eq=False)
class Column:
    """Values ``(cases,)`` under a name, texts or numbers (NaN where there is none) in `units`."""

    name: str
    units: str
    values: NDArray[Any]

    @property
    def heading(self) -> str:
        """With the units, as CSV has it."""
        return f"{self.name} ({self.units})" if self.units else self.name


@dataclass(frozen=True, eq=False)
class Table:
    """One row per case. settings, found, errors: columns of varied keys, quantities and their error bars, if any.

    regimes: of each case, see `regime`, empty where there is none; increments, seconds: solved, and the time they took.
    """

    manifest: Manifest
    states: tuple[CaseState, ...]
    settings: tuple[Column, ...]
    found: tuple[Column, ...]
    errors: tuple[Column, ...]
    regimes: tuple[str, ...]
    increments: NDArray[np.int64]
    seconds: DoubleArray


@dataclass(frozen=True)
class _Reading:
    """What one result says of the quantities. stages: of the whole path, 0 where the run did not get to its end."""

    values: tuple[float, ...] = ()
    errors: tuple[float, ...] = ()
    regime: str = ""
    increments: int = 0
    seconds: float = 0.0
    stages: int = 0


@dataclass
class _Reader:
    """Reads each result once."""

    manifest: Manifest
    quantities: tuple[tuple[str, int | None], ...]
    known: dict[str, _Reading] = field(default_factory=dict)

    def read(self, state: CaseState) -> _Reading:
        """What there is of a case. Raises FileError."""
        nothing = (math.nan,) * len(self.quantities)
        if not state.has_result:
            return _Reading(nothing, nothing, increments=state.increments)
        if state.row.id not in self.known:
            with open_result(self.manifest.result(state.row)) as result:
                self.known[state.row.id] = self._of(result)
        return self.known[state.row.id]

    def _of(self, result: Result) -> _Reading:
        return _Reading(
            tuple(_at_end(result, name, stage) for name, stage in self.quantities),
            tuple(_at_end(result, name + ERROR_SUFFIX, stage) for name, stage in self.quantities),
            regime(result),
            result.increments,
            float(result.history["wall_time"].sum()),
            int(result.history["stage"][-1]) if result.status == "complete" else 0,
        )


def collect(manifest: Manifest, quantities: Sequence[str] = ()) -> Table:
    """What there is by now; quantities: ``NAME`` or ``NAME@STAGE``, those of the manifest by default.

    A result that cannot be read counts as an error of its case. Raises CaseError for a stage that none of them has.
    """
    texts = tuple(dict.fromkeys(quantities or manifest.quantities))
    reader = _Reader(manifest, tuple(_split(text) for text in texts))
    found: list[CaseState] = []
    readings: list[_Reading] = []
    for state in states(manifest):
        try:
            readings.append(reader.read(state))
            found.append(state)
        except FileError as error:
            failed = CaseState(state.row, "error", error.exit_code, str(error))
            readings.append(reader.read(failed))
            found.append(failed)
    stages = max((reading.stages for reading in readings), default=0)
    for text, (_, stage) in zip(texts, reader.quantities, strict=True):
        if stages and stage is not None and stage > stages:
            raise CaseError(f"--quantity {text}: there is no stage {stage}; the cases have stages 1 to {stages}")
    values = np.array([reading.values for reading in readings], np.float64).reshape(len(found), len(texts))
    errors = np.array([reading.errors for reading in readings], np.float64).reshape(len(found), len(texts))
    units = [UNITS[name] for name, _ in reader.quantities]
    return Table(
        manifest,
        tuple(found),
        tuple(setting_column(key, [state.row for state in found]) for key in manifest.keys),
        tuple(Column(text, unit, values[:, i]) for i, (text, unit) in enumerate(zip(texts, units, strict=True))),
        tuple(
            Column(f"{text} error", unit, errors[:, i])
            for i, (text, unit) in enumerate(zip(texts, units, strict=True))
            if np.isfinite(errors[:, i]).any()
        ),
        tuple(reading.regime for reading in readings),
        np.array([reading.increments for reading in readings]),
        np.array([reading.seconds for reading in readings]),
    )


def setting_column(key: str, rows: Sequence[Row]) -> Column:
    """The values of a key: numbers where all are numbers in the same unit, else texts as given, empty for none."""
    texts = [next((setting.value for setting in row.settings if setting.key == key), "") for row in rows]
    try:
        pairs = [split_quantity(text) for text in texts]
    except QuantityError:
        return Column(key, "", np.array(texts, object))
    units = {unit for _, unit in pairs}
    if len(units) > 1:
        return Column(key, "", np.array(texts, object))
    return Column(key, units.pop(), np.array([number for number, _ in pairs]))


def _split(text: str) -> tuple[str, int | None]:
    name, _, stage = (part.strip() for part in text.partition("@"))
    return name, int(stage) if stage else None


def _at_end(result: Result, name: str, stage: int | None) -> float:
    """A column of the history at the end of a stage (None: the last one); NaN where the run did not get there."""
    stages = result.history["stage"]
    complete = result.status == "complete"
    if name not in result.history or not len(stages):
        return math.nan
    if stage is None:
        return float(result.history[name][-1]) if complete else math.nan
    steps = np.flatnonzero(stages == stage)
    if not len(steps) or (steps[-1] == len(stages) - 1 and not complete):
        return math.nan
    return float(result.history[name][steps[-1]])
