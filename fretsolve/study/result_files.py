"""The runs of a study as files: ``study.csv`` and ``study.h5``."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from fretsolve.errors import FileError
from fretsolve.study.assessment import Assessment
from fretsolve.sweep.manifest import OF_A_CASE, require_own_names
from fretsolve.sweep.quantity import place_of
from fretsolve.sweep.table import Column, column, write_table_csv, write_table_hdf5
from fretsolve.system.foreign_files import PICTURE_MARK, open_hdf5, require_own

CSV_NAME, HDF5_NAME, PICTURE_NAME = "study.csv", "study.h5", "study.png"

_OWN_NAME = re.compile(rf"{OF_A_CASE.pattern}|study\.(csv|h5|png)(\..*tmp)?$")
_FIRST_COLUMNS = b"result,status,role,"
"""Beginning of the table as CSV."""


def require_own_folder(folder: Path) -> None:
    """Raise FileError if there are files in `folder` that a study may not replace: those that it has not written.

    Once there is a study's table, others may lie beside it.
    """
    table = folder / HDF5_NAME
    if os.path.lexists(table):
        own = False
        with suppress(OSError, FileError), open_hdf5(table) as file:
            own = all(name in file for name in ("result", "failure", "reference", "best"))
        if not own:
            message = "is not the table of a study, so it is not replaced: move it away, or give another folder with -o"
            raise FileError(message, table)
    else:
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
    """Write the same as HDF5, errors as numbers instead of per cent. Raises FileError."""
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
