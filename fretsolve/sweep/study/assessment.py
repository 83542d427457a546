"""The runs of a study against the reference: their errors, which runs are worth their cost, and the files of both."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fretsolve.case.history import COMPONENTS
from fretsolve.sweep.manifest import OF_A_CASE, require_own_names
from fretsolve.sweep.outcome import CaseOutcome
from fretsolve.sweep.plan import PreparedCase
from fretsolve.sweep.quantity import NAMES, StageQuantity, place_of
from fretsolve.sweep.study.plan import StudyPlan, words
from fretsolve.sweep.table import Column, column, require_own_hdf5, write_table_csv, write_table_hdf5
from fretsolve.system.arrays import DoubleArray
from fretsolve.system.files import PICTURE_MARK, require_own

ROUNDING = 1e-9
"""Part of the largest value on the path up to which a value counts as 0."""


@dataclass(frozen=True, eq=False)
class AssessedRun:
    """A case and its outcome with values and errors ``(n,)``; NaN if there are none: the reference has no errors.

    best: no other run is both cheaper and more accurate.
    """

    case: PreparedCase
    outcome: CaseOutcome
    values: DoubleArray
    errors: DoubleArray
    is_reference: bool
    best: bool = False

    @property
    def words(self) -> str:
        """The settings, for a sentence."""
        return words(self.case.settings, line=self.case.setup.model.line)

    @property
    def worst(self) -> float:
        """The largest error; NaN if there is none."""
        return float(self.errors.max()) if self.errors.size else math.nan

    @property
    def compared(self) -> bool:
        """True if it has errors."""
        return self.errors.size > 0 and bool(np.isfinite(self.errors).all())


@dataclass(frozen=True, eq=False)
class Assessment:
    """The runs of a plan by cost. reference: values ``(n,)`` of the quantities; scales: of the errors.

    left_out: quantities that are 0 throughout, or of which the reference has no value.
    """

    plan: StudyPlan
    quantities: tuple[StageQuantity, ...]
    left_out: tuple[StageQuantity, ...]
    reference: DoubleArray
    scales: DoubleArray
    rows: tuple[AssessedRun, ...]

    @property
    def difference(self) -> str:
        """The word for the difference of a run from the reference."""
        return "change" if self.plan.problem_keys else "error"

    @property
    def largest(self) -> str:
        """The word for the largest of them."""
        return "largest" if self.plan.problem_keys else "worst"

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the quantities, each once."""
        return tuple(dict.fromkeys(quantity.name for quantity in self.quantities))

    def error_of(self, row: AssessedRun, name: str) -> float:
        """Return the largest error of a quantity over the ends of its stages."""
        return self.worst_of(row, name)[0]

    def worst_of(self, row: AssessedRun, name: str) -> tuple[float, int]:
        """Return the largest error of a quantity over the ends of its stages, and the stage."""
        found = [(row.errors[place], one.stage) for place, one in enumerate(self.quantities) if one.name == name]
        place = int(np.argmax([error for error, _ in found]))  # NaN wins, if there is one
        return float(found[place][0]), found[place][1]

    def stages_of(self, name: str) -> list[int]:
        """Return the stages at whose ends a quantity is compared."""
        return [quantity.stage for quantity in self.quantities if quantity.name == name]

    @property
    def finest(self) -> AssessedRun:
        """The finest run, which is made first."""
        return next(row for row in self.rows if row.case is self.plan.cases[0])


def assess(plan: StudyPlan, outcomes: Sequence[CaseOutcome]) -> Assessment:
    """Compare `outcomes` of the first cases of the plan with its reference."""
    quantities, finest = plan.quantities, outcomes[0]
    reference = finest.values if not finest.failure else np.full(len(quantities), np.nan)
    if plan.known is not None:
        reference = np.array([plan.known[one] for one in quantities])
    peaks = np.max([one.peaks for one in outcomes], axis=0) if finest.failure else finest.peaks
    # An error is relative to the value there, or to the largest on the path if the quantity goes through 0, or is 0.
    # Components of the load other than the normal one, and middles of the zones, go through 0.
    signed = {*(name for names in COMPONENTS[1:] for name in names), *(name for name in NAMES if "_center_" in name)}
    signs = np.array([one.name in signed for one in quantities])
    scales = np.where(signs | (np.abs(reference) <= ROUNDING * peaks), peaks, np.abs(reference))
    kept = np.flatnonzero((peaks > 0.0) & (np.isfinite(reference) | bool(finest.failure))).tolist()
    rows = []
    for case, outcome in sorted(zip(plan.cases, outcomes, strict=False), key=lambda pair: pair[1].seconds):
        is_reference = plan.known is None and outcome is finest
        errors = np.abs(outcome.values - reference)[kept] / scales[kept]
        if outcome.failure or is_reference:
            errors[:] = np.nan
        rows.append(AssessedRun(case, outcome, outcome.values[kept], errors, is_reference))
    worst = [row.worst if row.compared and not plan.problem_keys else math.inf for row in rows]
    best = front([row.outcome.seconds for row in rows], worst)
    return Assessment(
        plan,
        tuple(quantities[index] for index in kept),
        tuple(one for index, one in enumerate(quantities) if index not in kept),
        reference[kept],
        scales[kept],
        tuple(replace(row, best=is_best) for row, is_best in zip(rows, best, strict=True)),
    )


def front(costs: Sequence[float], errors: Sequence[float]) -> list[bool]:
    """Return which points are on the Pareto front: no other one that costs as little has an error as small."""
    least, found = math.inf, [False] * len(costs)
    for index in sorted(range(len(costs)), key=lambda index: (costs[index], errors[index])):
        if errors[index] < least:
            least, found[index] = errors[index], True
    return found


CSV_NAME, HDF5_NAME, PICTURE_NAME = "study.csv", "study.h5", "study.png"

_OWN_NAME = re.compile(rf"{OF_A_CASE.pattern}|study\.(csv|h5|png)(\..*tmp)?$")
_FIRST_COLUMNS = b"result,status,role,"
"""Beginning of the table as CSV."""


def require_own_folder(folder: Path) -> None:
    """Raise FileError if there are files in `folder` that no study has written, so that a study may not replace them.

    Once there is a study's table, others may lie beside it.
    """
    require_own_hdf5(folder / HDF5_NAME, ("result", "failure", "reference", "best"), "the table of a study", "folder")
    if not (folder / HDF5_NAME).exists():
        require_own_names(folder, _OWN_NAME, "no study")
    require_own(folder / CSV_NAME, _FIRST_COLUMNS, "the table of a study")
    require_own(folder / PICTURE_NAME, PICTURE_MARK.encode(), "a picture")


def write_study_csv(path: Path, study: Assessment) -> None:
    """Write one row per run, by cost; a reference that is not a run is the first row. Raises FileError."""
    rows = study.rows
    per_cent = [100.0 * np.array([row.errors[index] for row in rows]) for index in range(len(study.quantities))]
    about = [
        _results(study),
        column("status", ["failed" if row.outcome.failure else "complete" for row in rows]),
        column("role", ["reference" if row.is_reference else "best" if row.best else "" for row in rows]),
        *_settings(study),
        column("points x", [row.case.setup.grid.shape[0] for row in rows]),
        column("points y", [row.case.setup.grid.shape[1] for row in rows]),
        *(replace(one, name=one.name.replace("_", " ")) for one in _costs(study)),
    ]
    errors = zip(study.quantities, per_cent, strict=True)
    columns = [
        *about,
        *_values(study),
        *(column(f"{study.difference} of {study.plan.column(one)}", values, "%") for one, values in errors),
        column(f"{study.largest} {study.difference}", [100.0 * row.worst for row in rows], "%"),
        column("reason", [row.outcome.failure for row in rows]),
    ]
    blank = [""] * (len(about) - 3)
    first = ["", study.plan.reference_words, "reference", *blank, *study.reference.tolist()]
    write_table_csv(path, columns, () if study.plan.known is None else first)


def write_study_hdf5(path: Path, study: Assessment, advice: Sequence[str]) -> None:
    """Write the rows of the CSV file as HDF5, errors as numbers instead of per cent. Raises FileError."""
    rows, difference = study.rows, study.difference
    attributes = {
        "case_yaml": study.plan.cases[0].setup.case.source.text,
        "provenance": study.plan.cases[0].header.provenance,
        "corrected": study.plan.corrected,
        "reference": study.plan.reference_words,
        "advice": "\n".join(advice),
    }
    is_reference = [row.is_reference for row in rows]
    about = [
        _results(study),
        column("failure", [row.outcome.failure for row in rows], meaning="why there is no solution, or empty"),
        column("reference", is_reference, "1", "the run that the others are compared with"),
        column("best", [row.best for row in rows], "1", "no other run is both cheaper and more accurate"),
    ]
    points = column("points", [row.case.setup.grid.shape for row in rows], "1", "grid points along x and y")
    values = _values(study)
    errors = [
        column(one.name, [row.errors[i] for row in rows], "1", f"{difference} of {one.meaning}, over its scale")
        for i, one in enumerate(values)
    ]
    groups = {"": about, "settings": _settings(study), "cost": [points, *_costs(study)], "values": values}
    write_table_hdf5(path, groups | {f"{difference}s": errors}, attributes)


def _results(study: Assessment) -> Column:
    return column("result", [row.case.out.name for row in study.rows], meaning="result file beside this one")


def _settings(study: Assessment) -> list[Column]:
    return [
        column(key, [row.case.settings[key] for row in study.rows], meaning="value as given")
        for key in study.plan.variations
    ]


def _costs(study: Assessment) -> list[Column]:
    outcomes = [row.outcome for row in study.rows]
    applications = [one.applications for one in outcomes]
    return [
        column("increments", [one.increments for one in outcomes], "1", "increments solved"),
        column("time", [one.seconds for one in outcomes], "s", "wall-clock time of the increments"),
        column("operator_applications", applications, "1", "influence applications, in parts of one on the whole grid"),
    ]


def _values(study: Assessment) -> list[Column]:
    return [
        column(
            study.plan.column(one),
            [row.values[index] for row in study.rows],
            study.finest.outcome.units.get(one.name, one.units),
            f"{study.plan.column(one).partition('@')[0]} ({place_of(one.name, [one.stage])})",
            scale=study.scales[index],
            reference=study.reference[index],
        )
        for index, one in enumerate(study.quantities)
    ]
