"""The runs of a study as files: ``study.csv`` and ``study.h5``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from fretsolve.study.assessment import AssessedRun, Assessment
from fretsolve.sweep import table_files
from fretsolve.sweep.table_files import Column, column

CSV_NAME, HDF5_NAME = "study.csv", "study.h5"


def write_csv(path: Path, study: Assessment) -> None:
    """Write one row per run, by cost; a reference that is not a run is the first row. Raises FileError."""

    def of_rows(value: Callable[[AssessedRun], Any]) -> list[Any]:
        return [value(row) for row in study.rows]

    def role(row: AssessedRun) -> str:
        return study.standard if row.is_reference else "best" if row.best else ""

    def values(index: int) -> list[float]:
        return of_rows(lambda row: float(row.values[index]))

    def per_cent(index: int) -> list[float]:
        return of_rows(lambda row: 100.0 * float(row.errors[index]))

    trials = [row.outcome.trial for row in study.rows]
    about = [
        column("result", [trial.out.name for trial in trials]),
        column("status", of_rows(lambda row: "failed" if row.outcome.failure else "complete")),
        column("role", of_rows(role)),
        *_settings(study),
        column("points x", [trial.setup.grid.shape[0] for trial in trials]),
        column("points y", [trial.setup.grid.shape[1] for trial in trials]),
        column("increments", of_rows(lambda row: row.outcome.increments)),
        column("time", of_rows(lambda row: row.outcome.seconds), "s"),
        column("operator applications", of_rows(lambda row: row.outcome.applications)),
    ]
    found = [column(str(one), values(i), one.units) for i, one in enumerate(study.quantities)]
    errors = [column(f"{study.difference} of {one}", per_cent(i), "%") for i, one in enumerate(study.quantities)]
    largest = "largest" if study.problem_keys else "worst"
    last = [
        column(f"{largest} {study.difference}", of_rows(lambda row: 100.0 * row.worst), "%"),
        column("reason", of_rows(lambda row: row.outcome.failure)),
    ]
    blank = [""] * (len(about) - 3)
    first = ["", study.reference_words, study.standard, *blank, *study.reference.tolist()]
    table_files.write_csv(path, [*about, *found, *errors, *last], () if study.reference_is_run else first)


def write_hdf5(path: Path, study: Assessment, advice: Sequence[str]) -> None:
    """Write the same as HDF5, errors as numbers instead of per cent. Raises FileError."""
    outcomes = [row.outcome for row in study.rows]
    trials = [outcome.trial for outcome in outcomes]
    attributes = {
        "case_yaml": study.finest.setup.case.source.text,
        "provenance": study.finest.header.provenance,
        study.standard: study.reference_words,
        "advice": "\n".join(advice),
    }
    about = [
        column("result", [trial.out.name for trial in trials], meaning="result file beside this one"),
        column("failure", [one.failure for one in outcomes], meaning="why there is no solution, or empty"),
        column(
            study.standard, [row.is_reference for row in study.rows], "1", "the run that the others are compared with"
        ),
        column("best", [row.best for row in study.rows], "1", "no other run is both cheaper and more accurate"),
    ]
    cost = [
        column("points", [trial.setup.grid.shape for trial in trials], "1", "grid points along x and y"),
        column("increments", [one.increments for one in outcomes], "1", "increments solved"),
        column("time", [one.seconds for one in outcomes], "s", "wall-clock time of the increments"),
        column(
            "operator_applications",
            [one.applications for one in outcomes],
            "1",
            "applications of an influence operator",
        ),
    ]
    values, errors = [], []
    for index, one in enumerate(study.quantities):
        meaning = f"{one.name} at the end of stage {one.stage}"
        told = {study.standard: study.reference[index], "scale": study.scales[index]}
        values.append(column(str(one), [row.values[index] for row in study.rows], one.units, meaning, **told))
        of_it = f"{study.difference} of {meaning}, over its scale"
        errors.append(column(str(one), [row.errors[index] for row in study.rows], "1", of_it))
    groups = {"": about, "settings": _settings(study), "cost": cost, "values": values, f"{study.difference}s": errors}
    table_files.write_hdf5(path, groups, attributes)


def _settings(study: Assessment) -> list[Column]:
    return [
        column(one.key, [row.outcome.trial.settings[index].value for row in study.rows], meaning="value as given")
        for index, one in enumerate(study.variations)
    ]
