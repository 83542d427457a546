"""The runs of a study as files: ``study.csv`` and ``study.h5``."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fretsolve import __version__
from fretsolve.study.assessment import Assessment, Row
from fretsolve.system import atomic_files

CSV_NAME, HDF5_NAME = "study.csv", "study.h5"


def write_csv(path: Path, study: Assessment) -> None:
    """One row per run, by cost, units in the heading; a truth that is no run is the first row. Raises FileError."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(
        [
            *("result", "status", "role", *(variation.key for variation in study.variations)),
            *("points x", "points y", "increments", "time (s)", "operator applications"),
            *(f"{one} ({one.units})" for one in study.observables),
            *(f"{study.difference} of {one} (%)" for one in study.observables),
            *(f"{'largest' if study.problem_keys else 'worst'} {study.difference} (%)", "reason"),
        ]
    )
    if not study.truth_is_run:
        blank = [""] * (len(study.variations) + 5)
        writer.writerow(["", study.truth_words, study.standard, *blank, *map(_number, study.truth)])
    writer.writerows(_csv_row(study, row) for row in study.rows)
    with atomic_files.reported(path):
        atomic_files.write_text(path, text.getvalue())


def write_hdf5(path: Path, study: Assessment, advice: Sequence[str]) -> None:
    """The same as HDF5, errors as numbers (not in per cent), every dataset with units and meaning. Raises FileError."""
    with atomic_files.reported(path), atomic_files.new_hdf5(path, path.parent) as file:
        file.attrs["fretsolve_version"] = __version__
        file.attrs["case_yaml"] = study.finest.setup.case.source.text
        file.attrs["provenance"] = study.finest.header.provenance
        file.attrs[study.standard] = study.truth_words
        file.attrs["advice"] = "\n".join(advice)
        outcomes = [row.outcome for row in study.rows]
        trials = [outcome.trial for outcome in outcomes]
        _put(file, "result", [trial.out.name for trial in trials], "", "result file beside this one")
        _put(file, "failure", [outcome.failure for outcome in outcomes], "", "why there is no solution, or empty")
        references = [row.is_truth for row in study.rows]
        _put(file, study.standard, references, "1", "the run that the others are compared with")
        _put(file, "best", [row.best for row in study.rows], "1", "no other run is both cheaper and more accurate")
        for index, variation in enumerate(study.variations):
            chosen = [trial.combination.settings[index].value for trial in trials]
            _put(file, f"settings/{variation.key}", chosen, "", "value of the key, as given")
        shapes = np.array([trial.setup.grid.shape for trial in trials])
        _put(file, "cost/points", shapes, "1", "grid points along x and y")
        _put(file, "cost/increments", [outcome.increments for outcome in outcomes], "1", "increments solved")
        _put(file, "cost/time", [outcome.seconds for outcome in outcomes], "s", "wall-clock time of the increments")
        applications = [outcome.applications for outcome in outcomes]
        _put(file, "cost/operator_applications", applications, "1", "applications of an influence operator")
        for index, one in enumerate(study.observables):
            meaning = f"{one.name} at the end of stage {one.stage}"
            values, errors = zip(*((row.values[index], row.errors[index]) for row in study.rows), strict=True)
            dataset = _put(file, f"values/{one}", values, one.units, meaning)
            dataset.attrs[study.standard], dataset.attrs["scale"] = study.truth[index], study.scales[index]
            _put(file, f"{study.difference}s/{one}", errors, "1", f"{study.difference} of {meaning}, over its scale")


def _csv_row(study: Assessment, row: Row) -> list[str]:
    outcome = row.outcome
    nx, ny = outcome.trial.setup.grid.shape
    return [
        outcome.trial.out.name,
        "failed" if outcome.failure else "complete",
        study.standard if row.is_truth else "best" if row.best else "",
        *(setting.value for setting in outcome.trial.combination.settings),
        *map(str, (nx, ny, outcome.increments)),
        f"{outcome.seconds:.6g}",
        str(outcome.applications),
        *map(_number, row.values),
        *(_number(100.0 * error) for error in (*row.errors, row.worst)),
        outcome.failure,
    ]


def _number(value: float) -> str:
    return f"{value:.10g}" if np.isfinite(value) else ""


def _put(file: Any, name: str, values: Any, units: str, long_name: str) -> Any:
    data = np.asarray(values)
    if data.dtype.kind == "U":
        dataset = file.create_dataset(name, data=data.astype(object), dtype=h5py.string_dtype())
    else:
        dataset = file.create_dataset(name, data=data.astype(np.uint8) if data.dtype == bool else data)
    dataset.attrs["units"], dataset.attrs["long_name"] = units, long_name
    return dataset
