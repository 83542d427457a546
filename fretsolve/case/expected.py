"""Check that a case will know what it expects: the cycles, and the side outputs that give the quantities."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from fretsolve.case.cycle_quantities import ACTUATOR, CYCLE_DIMENSIONS
from fretsolve.case.history import OF_RIG, OF_WEAR
from fretsolve.case.keys.output_spec import LIFE_CURVES, CrackSpec, OutputSpec
from fretsolve.case.keys.quantity_names import LIFE_NAMES, OF_WHOLE_RUN, OUTPUT_NAMES, WORST_NAMES
from fretsolve.case.keys.settings_spec import Expectation
from fretsolve.case.keys.unrolled_path import Stage
from fretsolve.errors import KeyPath

ADDED = {
    "stress": "output: {stress: {}}",
    "fatigue": "output: {fatigue: {material: steel.yaml, criteria: [swt]}}",
    "crack": "output: {crack: {material: steel.yaml}}",
}
"""What a case lacks without a side output."""


def unknown_quantities(
    expect: Sequence[Expectation], stages: Sequence[Stage], output: OutputSpec, *, rig: bool
) -> Iterator[tuple[KeyPath, str]]:
    """Yield the key, and a message, of each expectation that the result will not tell.

    stages: of the load path with its cycles unrolled; rig: whether the case has one.
    """
    cycles = len({(stage.cycle.cycle, stage.cycle.turn) for stage in stages if stage.cycle is not None})
    for index, one in enumerate(expect):
        name, key = one.quantity, ("expect", index)
        if not rig and (name in OF_RIG or name.startswith(ACTUATOR)):
            yield (*key, "quantity"), f"{name} is known with a rig alone; the case has none"
        elif name in CYCLE_DIMENSIONS:
            yield from ((key + place, message) for place, message in _of_cycle(one, cycles, output))
        elif one.cycle is not None:
            yield (*key, "cycle"), f"{name} is no quantity of a cycle; stage chooses the stage at whose end to compare"
        elif one.stage is not None and name in OF_WHOLE_RUN:
            message = f"{name} has one value of the whole run; output chooses the cycles that count, remove it"
            yield (*key, "stage"), message
        elif (lacking := lacking_of(name, output)) is not None:
            yield (*key, "quantity"), f"{name} {lacking}"


def unjudged_quantities(
    of: Sequence[str], stages: Sequence[Stage], *, rig: bool, wear: bool
) -> Iterator[tuple[KeyPath, str]]:
    """Yield the key, and a message, of each quantity that an accuracy is about and that the result will not have.

    stages: of the load path with its cycles unrolled; rig, wear: whether the case has them.
    """
    for index, name in enumerate(of):
        key = ("solver", "accuracy", "of", index)
        if not rig and (name in OF_RIG or name.startswith(ACTUATOR)):
            yield key, f"{name} is known with a rig alone; the case has none"
        elif not wear and name in OF_WEAR:
            yield key, f"{name} is known with wear alone; the case has none"
        elif wear and name in CYCLE_DIMENSIONS:
            yield key, f"{name} has no error bar with wear; columns of the history such as wear_volume have one"
        elif name in CYCLE_DIMENSIONS and all(stage.cycle is None for stage in stages):
            yield key, f"{name} is a quantity of a cycle, and the load path has none; another one is needed"


def _of_cycle(one: Expectation, cycles: int, output: OutputSpec) -> Iterator[tuple[KeyPath, str]]:
    """Yield what is wrong with an expectation of a cycle; cycles: the number of cycles that there may be."""
    name = one.quantity
    if one.stage is not None:
        yield ("stage",), f"{name} is a quantity of a cycle; cycle: 1 chooses the first cycle, the last one is compared"
    elif not cycles:
        yield ("quantity",), f"{name} is a quantity of a cycle, and the load path has none; another one is needed"
    elif one.cycle is not None and one.cycle > cycles:
        yield ("cycle",), f"{one.cycle} is beyond the load path; a cycle from 1 to {cycles} is needed"
    elif name == "slip_amplitude" and "slip" not in output.fields:
        yield ("quantity",), f"{name} follows from the slip; output.fields needs slip"


def lacking_of(name: str, output: OutputSpec) -> str | None:
    """Return what the case lacks for a quantity beside the result, None if it lacks nothing."""
    kind = next((kind for kind, names in OUTPUT_NAMES.items() if name in names), None)
    if kind is None:
        return None
    if getattr(output, kind) is None:
        return f"needs output.{kind}; add {ADDED[kind]}"
    if kind == "crack" and output.crack is not None:
        needs = list(_needs_of_crack(name, output.crack))
        return f"needs {', and '.join(needs)}" if needs else None
    criterion = WORST_NAMES.get(name) or LIFE_NAMES.get(name)
    if criterion is None or output.fatigue is None:
        return None
    if criterion not in output.fatigue.criteria:
        return f"needs the criterion {criterion}; add it to output.fatigue.criteria"
    curve = next((key for one, key in LIFE_CURVES.items() if one == criterion and name in LIFE_NAMES), None)
    if curve is not None and getattr(output.fatigue.material, curve) is None:
        return f"needs {curve} in output.fatigue.material"
    return None


def _needs_of_crack(name: str, crack: CrackSpec) -> Iterator[str]:
    """Yield what a quantity of a crack needs beside what `output.crack` gives."""
    material = crack.material
    wanted: list[tuple[str, ...]]
    if name == "crack_arrest_length":
        wanted = [("threshold_range",), ("fatigue_range",)]
    else:
        curves = LIFE_CURVES.values() if crack.criterion is None else [LIFE_CURVES[crack.criterion]]
        wanted = [("paris",), tuple(curves)]
        if (material.toughness, crack.final_length, crack.thickness) == (None, None, None):
            yield "an end of life, toughness in output.crack.material or output.crack.final_length"
    missing = [" or ".join(keys) for keys in wanted if all(getattr(material, key) is None for key in keys)]
    if missing:
        yield f"{' and '.join(missing)} in output.crack.material"
