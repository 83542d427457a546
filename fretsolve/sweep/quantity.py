"""Quantities that sweeps collect and studies compare: columns of the history at the end of a stage."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from fretsolve.case.cycle_quantities import ACTUATOR
from fretsolve.case.dimensions import NUMBER, TIME
from fretsolve.case.history import ACTUATORS, COMPONENTS, DISPLACEMENTS, HISTORY_DIMENSIONS, OF_RIG, SHEARING
from fretsolve.case.keys.quantity_names import OF_WHOLE_RUN, OUTPUT_NAMES, dataset_name
from fretsolve.case.keys.settings_spec import Expectation
from fretsolve.case.other_names import close_name
from fretsolve.errors import CaseError
from fretsolve.post.names import UNITS
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result.cycles.table import AT_ACTUATOR, CORRECTED_CYCLE_NAMES, CYCLE_NAMES, CYCLES
from fretsolve.result.layout import ERRORS, HISTORY, RIG_ERRORS, RIG_HISTORY, WEAR_HISTORY
from fretsolve.result.state import CORRECTED, CORRECTED_SUFFIX, ERROR_SUFFIX, ESTIMATED
from fretsolve.sweep.manifest import index_list

USUAL_OF_WEAR, ERROR_OF_WEAR = ("wear_volume", "wear_depth_max"), "wear_error"
"""Columns that are collected of cases with wear; the last one by sweeps alone, as grids have no order in it."""

WEAR_NAMES = (*USUAL_OF_WEAR, ERROR_OF_WEAR)
"""Columns that can be collected of cases with wear."""

NAMES = (
    *(
        column.name
        for column in HISTORY
        if HISTORY_DIMENSIONS.get(column.name, NUMBER) not in (NUMBER, TIME) and column.name != "work"
    ),
    *WEAR_NAMES,
    *OF_RIG,
)
"""Columns that can be collected; the dissipated energy of one increment depends on how many there are."""

CORRECTED_NAMES = (
    *(name + CORRECTED_SUFFIX for name in NAMES if name in (*CORRECTED, *OF_RIG)),
    *CORRECTED_CYCLE_NAMES,
)
"""Columns that can be collected too, from runs with error bars."""

ALL_NAMES = tuple(
    dict.fromkeys(
        (*NAMES, *CORRECTED_NAMES, *(name for names in OUTPUT_NAMES.values() for name in names), *CYCLE_NAMES)
    )
)
"""All columns that can be collected: of the history, of the table of cycles, and of the files beside a result."""

_COLUMN_UNITS = {column.name: column.units for column in (*HISTORY, *WEAR_HISTORY, *ERRORS, *CYCLES)}
_COLUMN_UNITS |= {column.name: column.units for column in (*RIG_HISTORY, *RIG_ERRORS, *AT_ACTUATOR)}
_COLUMN_UNITS |= UNITS

NAMES_OF_RIG = tuple(name for name in ALL_NAMES if name.startswith((ACTUATOR, *OF_RIG)))
"""Columns that can be collected of cases with a rig."""

ENERGIES = tuple(
    name
    for name in ALL_NAMES
    if name not in NAMES_OF_RIG and _COLUMN_UNITS.get(name.removesuffix(CORRECTED_SUFFIX)) == "mJ"
)
"""Columns of dissipated energy."""

NEEDED_KEYS = {"wear": WEAR_NAMES, "rig": NAMES_OF_RIG}
"""Keys of the case without which there are no such quantities."""

LAST_STAGE = 1_000_000_000
"""Stands for the last stage where the number of stages is not known."""


@dataclass(frozen=True)
class StageQuantity:
    """A column of the history, by name, at the end of a stage (from 1, cycles unrolled; or `LAST_STAGE`).

    For a column of the table of cycles, `stage` is the number of the cycle (or `LAST_STAGE`, for the last one).
    """

    name: str
    stage: int

    @property
    def units(self) -> str:
        """The unit of its values."""
        return _COLUMN_UNITS[self.name.removesuffix(CORRECTED_SUFFIX)]

    def __str__(self) -> str:
        return f"{self.name}@{self.stage}" if self.stage != LAST_STAGE else self.name


def read_quantity(text: str, stages: int = LAST_STAGE) -> StageQuantity:
    """Read ``NAME`` or ``NAME@STAGE``, by default at the last of `stages`; or ``NAME@CYCLE``. Raises CaseError.

    Hyphens and underscores in a name mean the same.
    """
    name, at, stage = (part.strip() for part in plain(text).partition("@"))
    if name not in ALL_NAMES:
        shown = text.partition("@")[0].strip()
        raise _refused(f"{shown!r} is not a quantity that can be compared; {_right_name(name)}", text)
    if name in CYCLE_NAMES:
        if at and not (stage.isdecimal() and len(stage) < 10 and int(stage) >= 1):
            raise _refused(f"there is no cycle {stage!r}; one from 1 on is needed", text)
        return StageQuantity(name, int(stage) if at else LAST_STAGE)
    if at and not (stage.isdecimal() and len(stage) < 10 and 1 <= int(stage) <= stages):
        ends = "on" if stages == LAST_STAGE else f"to {stages}"
        raise _refused(f"there is no stage {stage!r}; one from 1 {ends} is needed", text)
    if at and name in OF_WHOLE_RUN and int(stage) != stages:
        raise _refused(f"{name} has one value of the whole run, not one of each stage; leave @{stage} out", text)
    return StageQuantity(name, int(stage) if at else stages)


def plain(text: str) -> str:
    """Return ``NAME`` or ``NAME@STAGE`` with the name as it stands in tables, with underscores for hyphens."""
    name, at, stage = text.partition("@")
    return dataset_name(name) + at + stage


def read_quantities(text: str, judged: Sequence[int], stages: int) -> tuple[StageQuantity, ...]:
    """Read ``NAME@STAGE``, or ``NAME`` for the ends of all `judged` ones of `stages`. Raises CaseError.

    A column of the table of cycles has one value, which the last cycle gives, and one of fatigue or of a crack, too.
    """
    one = read_quantity(text, stages)
    if "@" in text or one.name in CYCLE_NAMES or one.name in OF_WHOLE_RUN:
        return (one,)
    return tuple(replace(one, stage=stage) for stage in judged)


def _right_name(name: str) -> str:
    """Return which name would be right instead of one that is not known."""
    as_run = name.removesuffix(ERROR_SUFFIX).removesuffix(CORRECTED_SUFFIX)
    if as_run != name and as_run in (*ESTIMATED, *OF_RIG) and as_run in NAMES:
        value = name.removesuffix(ERROR_SUFFIX)
        if value != name and value in ALL_NAMES:
            return f"error bars stand beside their values; use {value}"
        return f"{as_run} is not corrected for the number of increments; use {as_run}"
    groups = {
        "": NAMES,
        "of stresses": OUTPUT_NAMES["stress"],
        "of fatigue": OUTPUT_NAMES["fatigue"],
        "of a crack": OUTPUT_NAMES["crack"],
        "of cycles": [one for one in CYCLE_NAMES if one not in CORRECTED_NAMES],
    }
    names = dict.fromkeys(one for names in groups.values() for one in names)
    meant = close_name(name, names)
    begun = [meant] if meant else [one for one in names if name and one.startswith(f"{name}_")]
    if 0 < len(begun) < 4:
        return f"did you mean {' or '.join(map(repr, begun))}?"
    lists = (f"{where + ': ' if where else ''}{', '.join(names)}" for where, names in groups.items())
    return f"one of these is needed: {'; '.join(lists)}"


def needed_key(name: str) -> str:
    """Return the key of the case without which a quantity is not known, such as output.stress; empty for none."""
    keys = {**{f"output.{key}": names for key, names in OUTPUT_NAMES.items()}, **NEEDED_KEYS}
    return next((key for key, names in keys.items() if name in names), "")


def usual_quantities(setup: ProblemSetup, stages: Sequence[int] = ()) -> tuple[StageQuantity, ...]:
    """Return the responses to the load path and what the case expects, without what is imposed.

    stages: at whose ends the responses are, by default the last stage.
    """
    ends = stages or [len(setup.load_path.last_steps)]
    found = [StageQuantity(name, stage) for name in _moved(setup) for stage in ends] + list(expected_values(setup))
    imposed = setup.load_path.imposed
    last = len(imposed)
    return in_order([quantity for quantity in found if quantity.name not in imposed[min(quantity.stage, last) - 1]])


def expected_values(setup: ProblemSetup) -> dict[StageQuantity, float]:
    """Return what the case expects; of two values of one quantity the first."""
    last = len(setup.load_path.last_steps)
    return {quantity_of(one, last): one.value for one in reversed(setup.case.expect) if one.quantity in ALL_NAMES}


def quantity_of(expected: Expectation, stages: int) -> StageQuantity:
    """Return what a case expects as a quantity at the end of one of `stages`, or of a cycle."""
    if expected.quantity in CYCLE_NAMES:
        return StageQuantity(expected.quantity, expected.cycle or LAST_STAGE)
    return StageQuantity(expected.quantity, expected.stage or stages)


def listed(quantities: Iterable[StageQuantity]) -> str:
    """Return quantities in words, as ``delta_z (stages 1-4), work_total (stage 4)``."""
    by_name: dict[str, list[int]] = {}
    for one in quantities:
        by_name.setdefault(one.name, []).append(one.stage)
    return ", ".join(f"{name} ({place_of(name, of)})" for name, of in by_name.items())


def place_of(name: str, stages: Sequence[int]) -> str:
    """Return in words where a quantity is taken, as ``stages 1-4`` or ``cycle 2 and last cycle``."""
    kind, numbers = "cycle" if name in CYCLE_NAMES else "stage", [one for one in stages if one != LAST_STAGE]
    places = [f"{kind}{'s' * (len(numbers) > 1)} {index_list(numbers)}"] if numbers else []
    return " and ".join([*places, *([f"last {kind}"] if LAST_STAGE in stages else [])])


def in_order(quantities: Iterable[StageQuantity]) -> tuple[StageQuantity, ...]:
    """Return each quantity once, in the order of the history and of the stages."""
    return tuple(sorted(set(quantities), key=lambda quantity: (ALL_NAMES.index(quantity.name), quantity.stage)))


def _moved(setup: ProblemSetup) -> list[str]:
    """Return the components of each mode that is moved, and what describes the contact."""
    moved = {name for load in setup.load_path.imposed for name, value in load.items() if value}
    gives = setup.case.rig.gives if setup.case.rig is not None else ()
    left_out = {actuator for motion, actuator in ACTUATORS.items() if motion not in gives}
    names = [name for one in COMPONENTS if moved & set(one) for name in one if name not in left_out]
    if setup.model.line:  # whose displacements have a free constant
        unknown = ("delta_y", "actuator_y") if setup.case.reference_depth else DISPLACEMENTS
        names = [name for name in names if name not in unknown]
    names += ["max_pressure", "contact_radius"]
    if setup.model.has_shear and (moved & SHEARING or setup.model.terms.normal_tangential_coupling):
        names += ["stick_radius", "work_total"]
    return [*names, *(USUAL_OF_WEAR if setup.case.wear is not None else ())]


def _refused(message: str, text: str) -> CaseError:
    return CaseError(message, (), f"--quantity {text if text.isprintable() else repr(text)}")
