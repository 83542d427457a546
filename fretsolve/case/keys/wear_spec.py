"""Wear as written in the case file, and what a load path needs for it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from typing import Annotated, Any, Literal, NamedTuple, Self

from pydantic import ConfigDict, Field, ValidationError, model_validator

from fretsolve.case.base import CaseModel, refused_at
from fretsolve.case.dimensions import NUMBER, PRESSURE, WEAR_COEFFICIENT, Dimension
from fretsolve.case.keys.unrolled_path import INITIAL, Stage, imposed_after
from fretsolve.case.quantities import InUnits, refused, shown
from fretsolve.errors import KeyPath

COEFFICIENTS = {"energy": "alpha", "archard": "k"}
"""The coefficient of each law."""

Share = Annotated[float, InUnits(NUMBER, least=0, most=1)]


class WearSpec(CaseModel):
    """Wear: a depth that slip wears off, by the dissipated energy or by Archard's law, and its share in both bodies."""

    model_config = ConfigDict(
        json_schema_extra={"oneOf": [{"required": [name]} for name in sorted(COEFFICIENTS.values())]}
    )

    law: Literal["energy", "archard"] = Field(
        description="energy, depth = alpha times dissipated energy per area, or archard, depth = k times pressure times"
        " path of slip",
        examples=["energy"],
    )
    alpha: Annotated[float, InUnits(WEAR_COEFFICIENT, above=0)] | None = Field(
        default=None,
        description="worn volume of both bodies per dissipated energy, with law: energy, such as 1e-4 mm^3/J; a number"
        " without a unit is 1000 times as much, in mm^3/(N mm)",
    )
    k: Annotated[float, InUnits(WEAR_COEFFICIENT, above=0)] | None = Field(
        default=None,
        description="worn volume of both bodies per normal force and path of slip, with law: archard, such as 1e-7"
        " mm^3/(N mm)",
        examples=["1e-7 mm^3/(N mm)"],
    )
    exponent: Annotated[float, InUnits(NUMBER, above=0, most=3)] | None = Field(
        default=None,
        description="with law: archard, m of a depth k p (p/reference_pressure)^(m - 1) times path",
        examples=[1.5],
    )
    reference_pressure: Annotated[float, InUnits(PRESSURE, above=0)] | None = Field(
        default=None, description="with exponent, pressure at which k is the given one", examples=["1 GPa"]
    )
    share: tuple[Share, Share] = Field(
        default=(0.5, 0.5),
        description="part of the depth in body 1 and body 2, which add up to 1",
        examples=[[0.5, 0.5]],
    )

    @model_validator(mode="before")
    @classmethod
    def _known_law(cls, value: Any) -> Any:
        if isinstance(value, dict) and "law" in value and value["law"] not in COEFFICIENTS:
            refused_at([(("law",), f"{shown(value['law'])} is not a law of wear; energy or archard is needed")])
        return value

    @model_validator(mode="after")
    def _keys_fit(self) -> Self:
        needed = COEFFICIENTS[self.law]
        for name in ("alpha", "k", "exponent", "reference_pressure"):
            if getattr(self, name) is not None and name != needed and (name == "alpha" or self.law == "energy"):
                owner = "energy" if name == "alpha" else "archard"
                refused_at([((name,), f"{name} belongs to law: {owner}; {needed} is the coefficient of {self.law}")])
        if getattr(self, needed) is None:
            raise ValidationError.from_exception_data("wear", [{"type": "missing", "loc": (needed,), "input": None}])
        if (self.exponent is None) != (self.reference_pressure is None):
            raise refused("exponent and reference_pressure belong together; give both or neither")
        if not math.isclose(sum(self.share), 1.0, rel_tol=1e-9):
            message = f"{self.share[0]:g} and {self.share[1]:g} add up to {sum(self.share):g}; 1 is needed"
            refused_at([(("share",), message)])
        return self


def check_wear(
    wear: WearSpec | None, stages: Sequence[Stage], friction: float | None, dimensions: Mapping[str, Dimension]
) -> None:
    """Refuse cycles that stand for others without wear, that do not close or end without P, and wear without friction.

    friction: the coefficient, None where it varies; dimensions: of the load components.
    """
    cycles = dict.fromkeys(stage.cycle.key for stage in stages if stage.cycle is not None and stage.cycle.jumps)
    if wear is None:
        message = "only wear makes a cycle stand for others; add wear: {law: energy, alpha: 1e-4 mm^3/J}, or give times"
        refused_at(((*key, "represents"), message) for key in cycles)
        return
    if friction == 0.0 and not any("friction" in dict(stage.targets) for stage in stages):
        refused_at([(("wear",), "friction is 0, so that nothing is dissipated; friction above 0 is needed")])
    ends = list(_ends_of_cycles(stages))
    refused_at(_open_cycles(ends, friction, dimensions))
    message = (
        "at its end the cycle changes the surfaces by their pressure, but P is 0 there; let it begin and end where"
    )
    message += " they are pressed together"
    refused_at((end.pressed_at, message) for end in ends if end.after.get("P") == 0.0)


class _End(NamedTuple):
    """The end of a repetition of a cycle that stands for others.

    before, after: what is imposed before it and at its end; pressed_at: where P at its end stands in the file.
    """

    key: KeyPath
    before: dict[str, float]
    after: dict[str, float]
    pressed_at: KeyPath


def _ends_of_cycles(stages: Sequence[Stage]) -> Iterator[_End]:
    """Yield the ends of the repetitions of cycles that stand for others."""
    after, pressed_at = dict(INITIAL), stages[0].key
    for cycle, of_cycle in groupby(stages, key=lambda stage: stage.cycle):
        before = after
        for stage in of_cycle:
            after = imposed_after(after, stage)
            pressed_at = stage.place("P") if "P" in dict(stage.targets) else pressed_at
        if cycle is not None and cycle.jumps is not None:
            yield _End(cycle.key, before, after, pressed_at)


def _as_written(name: str, value: str) -> str:
    """Return a load component with its value as a stage of the case file has it."""
    if not name.startswith("bulk_"):
        return f"{name}: {value}"
    body, component = name.rsplit("_", 1)
    return f"{body}: {{{component}: {value}}}"


def _open_cycles(
    ends: Iterable[_End], friction: float | None, dimensions: Mapping[str, Dimension]
) -> Iterator[tuple[KeyPath, str]]:
    """Yield where a cycle that stands for others does not end as it begins, and a message."""
    for key, before, after, _ in ends:
        for name, end in after.items():
            free = 0.0 if name.startswith("bulk_") else friction if name == "friction" else None
            begin = before.get(name, free)
            if begin is None or not math.isclose(begin, end, rel_tol=1e-9):
                unit = f" {dimensions[name].unit}" if name in dimensions else ""
                advice = f"a stage {{{_as_written(name, f'{end:g}{unit}')}}} before it would do"
                if name == "P" and end == 0.0:  # a cycle that begins so is refused, too
                    advice = "let it begin and end where the bodies are pressed together"
                stands = "is imposed in it alone" if begin is None else f"is {begin:g}{unit} before it"
                yield (
                    key,
                    f"a cycle that represents others has to close, but {name} {stands} and {end:g}{unit} at its end;"
                    f" {advice}",
                )
                break
