"""The rig in series with the contact: its compliance, and the motions of the actuator.

The actuator moves by D = delta + C F, with the motion delta of the contact, its resultants F and the symmetric
compliance C of all that gives between the two. Vectors and matrices follow the order of `PAIRS`: P, Mx, My, Qx, Qy, Mz.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fretsolve.case.history import ACTUATORS, COMPONENTS, PAIRS
from fretsolve.case.keys.rig_spec import STIFFNESSES
from fretsolve.case.keys.unrolled_path import imposed_after, imposed_at_start
from fretsolve.case.models import Case
from fretsolve.errors import FileError
from fretsolve.system.arrays import DoubleArray, Vector

RESULTANTS, MOTIONS = zip(*PAIRS, strict=True)

COLUMNS = ("Qx", "Qy", "P", "Mx", "My", "Mz")
"""The order of the columns in a file, and of the rows of their motions, where the file does not name them."""

ROUNDING = 1e-6
"""Largest part by which a compliance may differ from its transpose, or lie below 0, in units of its diagonal: what the
digits of a file lose."""


@dataclass(frozen=True, eq=False)
class Rig:
    """compliance: C, (6, 6) (mm/N, rad/N, rad/(N mm)), or per mm of a line contact."""

    compliance: DoubleArray

    def actuator(self, motions: Vector, resultants: Vector) -> dict[str, float]:
        """Return the motions of the actuator by their names; motions: of the contact, (6,), as the resultants."""
        found = motions + self.compliance @ resultants
        return dict(zip(ACTUATORS.values(), found.tolist(), strict=True))

    def energy(self, resultants: Vector) -> float:
        """Return the energy in the rig (mJ)."""
        return float(0.5 * resultants @ self.compliance @ resultants)

    def errors(self, resultants: Vector, of_motions: Vector, of_resultants: Vector) -> dict[str, float]:
        """Return the largest errors of the motions of the actuator, and of the energy, by their names.

        of_motions, of_resultants: errors of the contact's motions and of the resultants, each ``(6,)``.
        """
        size = np.abs(self.compliance)
        found = of_motions + size @ of_resultants
        energy = np.abs(self.compliance @ resultants) @ of_resultants + 0.5 * of_resultants @ size @ of_resultants
        return dict(zip(ACTUATORS.values(), found.tolist(), strict=True)) | {"spring_energy": float(energy)}


def driver(rig: Rig | None, motion: str) -> str:
    """Return what to impose where a motion of the contact drives it: with a rig that gives there, the actuator's."""
    return ACTUATORS[motion] if rig is not None and rig.compliance[MOTIONS.index(motion)].any() else motion


def rig_of(case: Case) -> Rig | None:
    """Return the rig of a case; None without one.

    Raises FileError where its file cannot be read, CaseError where the file holds no compliance.
    """
    spec = case.rig
    if spec is None:
        return None
    if spec.compliance is None:
        stiffness = {motion: getattr(spec, key, None) or math.inf for key, motion in STIFFNESSES.items()}
        return Rig(np.diag([1.0 / stiffness[motion] for motion in MOTIONS]))
    try:
        rig = Rig(_symmetric(_matrix_in(spec.compliance)))
    except ValueError as error:
        raise case.source.problem(f"{spec.compliance.name}: {error}", ("rig", "compliance")) from None
    _require_known_bending(case, rig)
    return rig


def _require_known_bending(case: Case, rig: Rig) -> None:
    """Refuse a motion imposed at the contact whose unknown load bends the rig of a motion imposed at the actuator."""
    imposed = dict(imposed_at_start(case.rig))
    for stage in case.stages():
        imposed = imposed_after(imposed, stage)
        for (_, motion, own), row in zip(COMPONENTS, rig.compliance, strict=True):
            for (_, _, actuator), couples in zip(COMPONENTS, row, strict=True):
                if motion in imposed and actuator in imposed and couples:
                    message = f"{motion} is imposed at the contact, but the rig couples it with {actuator}"
                    raise case.source.problem(f"{message}, which is held or moved; impose {own}", stage.place(motion))


def _matrix_in(file: Path) -> DoubleArray:
    """Return the matrix in a text file, (6, 6), in the order of `PAIRS`.

    Its lines hold six numbers each, between commas, semicolons or blanks. A first line may name the loads, and a first
    column the motions. Raises FileError, ValueError.
    """
    try:
        text = file.read_text("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(f"the compliance cannot be read: {error}", file) from error
    lines = [(number, line.split("#")[0].strip()) for number, line in enumerate(text.splitlines(), start=1)]
    rows = [(number, [part for part in re.split(r"[,;\s]+", line) if part]) for number, line in lines if line]
    names = [part.split("(")[0] for part in rows[0][1]] if rows else []
    columns: tuple[str, ...] = COLUMNS
    if set(RESULTANTS) <= set(names):
        columns, rows = tuple(name for name in names if name in RESULTANTS), rows[1:]
    motion_of = dict(PAIRS)
    motions = tuple(motion_of[name] for name in columns)
    if rows and all(parts[0] in MOTIONS for _, parts in rows):
        motions, rows = tuple(parts[0] for _, parts in rows), [(number, parts[1:]) for number, parts in rows]
    if len(rows) != 6 or sorted(motions) != sorted(MOTIONS) or sorted(columns) != sorted(RESULTANTS):
        raise ValueError(f"it has {len(rows)} rows; 6 rows of 6 numbers, one per motion, are needed")
    values = np.empty((6, 6))
    for row, (number, parts) in enumerate(rows):
        if len(parts) != 6:
            raise ValueError(f"line {number} has {len(parts)} numbers; 6 are needed, with a point for decimals")
        for column, part in enumerate(parts):
            values[row, column] = _number(part, number)
    rows_of, columns_of = [motions.index(name) for name in MOTIONS], [columns.index(name) for name in RESULTANTS]
    ordered: DoubleArray = values[np.ix_(rows_of, columns_of)]
    return ordered


def _number(text: str, line: int) -> float:
    try:
        value = float(text)
    except ValueError:
        raise ValueError(f"line {line} has {text!r}, which is no number") from None
    if not math.isfinite(value):
        raise ValueError(f"line {line} has {text!r}; a finite number is needed")
    return value


def _symmetric(matrix: DoubleArray) -> DoubleArray:
    """Return a compliance without the rounding of its file.

    Raises ValueError where it is not symmetric, or has a negative eigenvalue.
    """
    diagonal = matrix.diagonal()
    if (diagonal < 0.0).any():
        mode = int(diagonal.argmin())
        raise ValueError(
            f"the compliance of {MOTIONS[mode]} under {RESULTANTS[mode]} is {diagonal[mode]:g}; it is below 0"
        )
    for mode in np.flatnonzero((diagonal == 0.0) & (matrix.any(axis=0) | matrix.any(axis=1))).tolist():
        raise ValueError(
            f"it is not positive: {MOTIONS[mode]} under {RESULTANTS[mode]} is 0, but other numbers of its row or column"
            " are not"
        )
    size = np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    scaled = matrix / np.outer(size, size)
    apart = np.abs(scaled - scaled.T)
    row, column = np.unravel_index(int(apart.argmax()), (6, 6))
    if apart[row, column] > ROUNDING:
        raise ValueError(
            f"it is not symmetric: {MOTIONS[row]} under {RESULTANTS[column]} is {matrix[row, column]:g}, but"
            f" {MOTIONS[column]} under {RESULTANTS[row]} is {matrix[column, row]:g}"
        )
    scaled = 0.5 * (scaled + scaled.T)
    least = float(np.linalg.eigvalsh(scaled)[0])
    if least < -ROUNDING:
        raise ValueError(
            f"it is not positive: with its diagonal scaled to 1 it has the eigenvalue {least:.4g}, so that some loads"
            " would gain energy"
        )
    return 0.5 * (matrix + matrix.T)
