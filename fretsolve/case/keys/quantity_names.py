"""Names of stresses, fatigue parameters, lives and cracks, and the dimensions of all that a case may expect."""

from __future__ import annotations

from typing import Literal, get_args

from fretsolve.case.cycle_quantities import CYCLE_DIMENSIONS, LINE_CYCLE_DIMENSIONS
from fretsolve.case.dimensions import CYCLE_COUNT, LENGTH, NUMBER, RUIZ, STRESS, Dimension
from fretsolve.case.history import HISTORY_DIMENSIONS, LINE_DIMENSIONS
from fretsolve.case.keys.output_spec import CriterionName

CRITERIA: tuple[CriterionName, ...] = get_args(CriterionName)
"""Names of the criteria."""

SLIP_CRITERIA: tuple[CriterionName, ...] = ("ruiz-1", "ruiz-2")
"""Criteria of the surface, which need slip."""

STRESS_CRITERIA = tuple(name for name in CRITERIA if name not in SLIP_CRITERIA)
"""Criteria of stresses alone."""


def dataset_name(criterion: str) -> str:
    """Return the name of a criterion in files, such as dang_van."""
    return criterion.replace("-", "_")


LIFE_NAMES = {"swt_life": "swt", "fatemi_socie_life": "fatemi-socie"}
"""Names of the shortest lives by criteria with a life curve, which sweeps collect, with their criteria."""

CRACK_NAMES = ("crack_arrest_length", "crack_life")
"""What sweeps collect of a crack: the length (mm) at which it stops, 0 without one and inf where it goes through, and
its life in cycles."""

WORST_NAMES = {f"{dataset_name(criterion)}_max": criterion for criterion in CRITERIA}
"""Names of the largest values of the parameters, which sweeps collect, with their criteria."""

Invariant = Literal["mises", "tension", "tresca"]

INVARIANTS: tuple[Invariant, ...] = ("mises", "tension", "tresca")

PEAK_NAMES = tuple(f"max_{name}" for name in INVARIANTS)
"""Columns with the largest stresses."""

BESIDE_DIMENSIONS: dict[str, Dimension] = {
    **dict.fromkeys((*PEAK_NAMES, *WORST_NAMES), STRESS),
    **dict.fromkeys(("ruiz_1_max", "ruiz_2_max"), RUIZ),
    "fatemi_socie_max": NUMBER,
    **dict.fromkeys((*LIFE_NAMES, "crack_life"), CYCLE_COUNT),
    "crack_arrest_length": LENGTH,
}
"""Dimensions of what stands in files beside a result."""

EXPECTED_DIMENSIONS = {**HISTORY_DIMENSIONS, **CYCLE_DIMENSIONS, **BESIDE_DIMENSIONS}
"""All that a case may expect: of the history, of a cycle, and of the files beside a result."""

LINE_EXPECTED_DIMENSIONS = {**LINE_DIMENSIONS, **LINE_CYCLE_DIMENSIONS, **BESIDE_DIMENSIONS}
"""The same in a line contact."""

OF_WHOLE_RUN = (*WORST_NAMES, *LIFE_NAMES, *CRACK_NAMES)
"""Quantities with one value of the whole run, which the cycles that the case chooses give."""

MAYBE_ENDLESS = (*LIFE_NAMES, *CRACK_NAMES)
"""Quantities that may be infinite: nothing breaks, or a crack goes through."""

OUTPUT_NAMES = {"stress": PEAK_NAMES, "fatigue": (*WORST_NAMES, *LIFE_NAMES), "crack": CRACK_NAMES}
"""Quantities of files beside a result, by the key of `output` that asks for the file."""
