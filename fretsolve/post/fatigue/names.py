"""Names of fatigue parameters in files and tables. Loads no NumPy."""

from __future__ import annotations

from pathlib import Path
from typing import get_args

from fretsolve.case.keys.output_spec import CriterionName

CRITERIA: tuple[CriterionName, ...] = get_args(CriterionName)
"""Names of the criteria."""


def dataset_name(criterion: str) -> str:
    """Return the name of a criterion in files, such as dang_van."""
    return criterion.replace("-", "_")


WORST_NAMES = {f"{dataset_name(criterion)}_max": criterion for criterion in CRITERIA}
"""Names of the largest values of the parameters, which sweeps collect, with their criteria."""


def fatigue_path(source: Path) -> Path:
    """Return the name of the file of fatigue parameters beside a result or a file of stresses."""
    return source.with_name(source.name.removesuffix(source.suffix).removesuffix(".stress") + ".fatigue.h5")
