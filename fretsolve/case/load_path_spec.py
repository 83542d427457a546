"""The load path: stages and cycles as the case file has them, and unrolled."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Annotated, Any, Literal, Self

from pydantic import ConfigDict, Discriminator, Field, Tag, model_validator

from fretsolve.case.base import CaseModel, Count, Length, auto, refused_at
from fretsolve.case.dimensions import ANGLE, FORCE, MOMENT, NUMBER, PRESSURE
from fretsolve.case.history import BULK, PAIRS
from fretsolve.case.quantities import InUnits, refused, shown
from fretsolve.errors import KeyPath

LARGEST_STAGE_COUNT = 100_000

Force = Annotated[float, InUnits(FORCE)]
Moment = Annotated[float, InUnits(MOMENT)]
Angle = Annotated[float, InUnits(ANGLE)]


class BulkStress(CaseModel):
    """A uniform in-plane stress that stretches a body, and with it its surface. What is not named stays as it is."""

    model_config = ConfigDict(json_schema_extra={"minProperties": 1})

    xx: Annotated[float, InUnits(PRESSURE)] | None = Field(
        default=None, description="normal stress along x, tensile", examples=["70 MPa"]
    )
    yy: Annotated[float, InUnits(PRESSURE)] | None = Field(
        default=None, description="normal stress along y, tensile", examples=["70 MPa"]
    )
    xy: Annotated[float, InUnits(PRESSURE)] | None = Field(
        default=None, description="shear stress in the plane of the surface", examples=["70 MPa"]
    )

    @model_validator(mode="after")
    def _one_is_named(self) -> Self:
        if self.xx is None and self.yy is None and self.xy is None:
            raise refused("the bulk stress has no value; at least one of xx, yy, xy is needed")
        return self


class StageSpec(CaseModel):
    """A stage: the totals to which it moves the load components that it names. The rest stays as it is."""

    model_config = ConfigDict(
        json_schema_extra={"minProperties": 1, "allOf": [{"not": {"required": list(pair)}} for pair in PAIRS]}
    )

    P: Annotated[float, InUnits(FORCE, least=0)] | None = Field(default=None, description="normal force, compressive")
    delta_z: Length | None = Field(default=None, description="approach of the bodies", examples=["9 um"])
    Mx: Moment | None = Field(default=None, description="moment of the pressure, sum of y p dA")
    phi_x: Angle | None = Field(default=None, description="tilt that adds phi_x y to the approach")
    My: Moment | None = Field(default=None, description="moment of the pressure, sum of x p dA")
    phi_y: Angle | None = Field(default=None, description="tilt that adds phi_y x to the approach")
    Qx: Force | None = Field(default=None, description="tangential force along x")
    delta_x: Length | None = Field(default=None, description="rigid displacement along x", examples=["1.5 um"])
    Qy: Force | None = Field(default=None, description="tangential force along y")
    delta_y: Length | None = Field(default=None, description="rigid displacement along y", examples=["1.5 um"])
    Mz: Moment | None = Field(default=None, description="torque about the normal")
    phi_z: Angle | None = Field(default=None, description="rotation about the normal")
    bulk_1: BulkStress | None = Field(default=None, description="bulk stress of body 1")
    bulk_2: BulkStress | None = Field(default=None, description="bulk stress of body 2", examples=[{"xx": "70 MPa"}])
    friction: Annotated[float, InUnits(NUMBER, least=0)] | None = Field(
        default=None, description="coefficient of friction from here on", examples=[0.05]
    )
    increments: Annotated[Count | None, auto("10")] = Field(
        default=None, description="number of increments, or auto: as many as the case needs", examples=[10]
    )
    spacing: Literal["equal", "graded"] | None = Field(
        default=None,
        description="grading of the increments: equal, or graded, which are closer where the edges of contact and stick"
        " zone move fast; by default equal if their number is given, graded if it is auto",
    )

    @property
    def targets(self) -> tuple[tuple[str, float], ...]:
        """The components that the stage moves, each with its new total (mm, N, N*mm, rad, MPa), and its friction."""
        named = [(name, getattr(self, name)) for pair in PAIRS for name in pair]
        for body, stress in ((1, self.bulk_1), (2, self.bulk_2)):
            if stress is not None:
                named += zip(BULK[body], (stress.xx, stress.yy, stress.xy), strict=True)
        named.append(("friction", self.friction))
        return tuple((name, value) for name, value in named if value is not None)

    @model_validator(mode="after")
    def _one_of_each_pair(self) -> Self:
        named = {name for name, _ in self.targets}
        if not named:
            components = ", ".join(name for pair in PAIRS for name in pair)
            raise refused(f"the stage moves nothing; at least one of {components}, bulk_1, bulk_2, friction is needed")
        if both := [f"{force} and {motion}" for force, motion in PAIRS if {force, motion} <= named]:
            raise refused(f"{', '.join(both)} cannot be imposed at once; keep one of the two")
        return self


class Cycle(CaseModel):
    """Stages that are repeated."""

    times: Count = Field(description="number of repetitions, such as 3", examples=[3])
    stages: tuple[LoadStep, ...] = Field(
        min_length=1,
        description="the stages of one cycle, a list",
        examples=[[{"Qx": "-36 N", "increments": 20}, {"Qx": "36 N", "increments": 20}]],
    )


class CycleSpec(CaseModel):
    """An entry of the load path that is a cycle."""

    cycle: Cycle


def step_tag(value: object) -> str:
    """Return which kind of entry of a load path `value` is."""
    # The tags appear in the locations of pydantic's errors and must differ from every key of the file.
    is_cycle = "cycle" in value if isinstance(value, dict) else isinstance(value, CycleSpec)
    return "(cycle)" if is_cycle else "(stage)"


LoadStep = Annotated[
    Annotated[StageSpec, Tag("(stage)")] | Annotated[CycleSpec, Tag("(cycle)")], Discriminator(step_tag)
]
Cycle.model_rebuild()


@dataclass(frozen=True)
class Stage:
    """A stage of the unrolled load path, numbered from 1.

    key: where it stands in the case file; targets: components with their new totals (mm, N, N*mm, rad, MPa);
    increments: None for as many as the case needs; spacing: None for what goes with that.
    """

    number: int
    key: KeyPath
    targets: tuple[tuple[str, float], ...]
    increments: int | None
    spacing: Literal["equal", "graded"] | None = None


def unrolled(load_path: Sequence[StageSpec | CycleSpec]) -> tuple[Stage, ...]:
    """Return the stages in the order in which they are run."""
    return tuple(
        Stage(number, key, stage.targets, stage.increments, stage.spacing)
        for number, (key, stage) in enumerate(_walk(load_path, ("load_path",)), start=1)
    )


def stage_friction(load_path: Sequence[StageSpec | CycleSpec]) -> tuple[float, ...]:
    """Return the coefficients of friction that stages of a load path set, each once."""
    found: list[float] = []
    for step in load_path:
        if isinstance(step, CycleSpec):
            found += stage_friction(step.cycle.stages)
        elif step.friction is not None:
            found.append(step.friction)
    return tuple(dict.fromkeys(found))


def with_cycle_friction(stages: Sequence[Stage], coefficient: Callable[[int], float]) -> Iterator[Stage]:
    """Yield the stages with the coefficient of friction of their cycles among the targets.

    Cycles are counted over the path from 1; the stages before the first one, and those after a cycle, belong to it.
    """
    number = 0
    last: KeyPath = ()
    for stage in stages:
        key, outer = stage.key, stage.key.index("cycle") if "cycle" in stage.key else 0
        if outer and (key[:outer] != last[:outer] or key == last or _place(key, outer) < _place(last, outer)):
            number += 1
        last = key if outer else ()
        yield replace(stage, targets=(*stage.targets, ("friction", coefficient(max(number, 1)))))


def _place(key: KeyPath, outer: int) -> int:
    """Return which entry of the cycle at `outer` a key is in."""
    return int(key[outer + 2])


def bulk_keys(load_path: Sequence[StageSpec | CycleSpec]) -> tuple[KeyPath, ...]:
    """Return where bulk stresses stand in a load path, as (0, "bulk_2")."""
    found = (
        (*key, name)
        for key, stage in _walk(load_path, ())
        for name in ("bulk_1", "bulk_2")
        if getattr(stage, name) is not None
    )
    return tuple(dict.fromkeys(found))


def stage_count(load_path: Any) -> int:
    """Return the number of stages of a load path, validated or as written in the file."""
    cycles = map(_cycle, load_path if isinstance(load_path, list | tuple) else ())
    return sum(1 if cycle is None else stage_count(cycle[0]) * cycle[1] for cycle in cycles)


def stage_key(load_path: Any, number: str | int) -> KeyPath:
    """Return where stage `number` (from 1, cycles unrolled) stands in a load path as written. Raises LookupError."""
    count = stage_count(load_path)
    if not isinstance(number, int) or not 1 <= number <= min(count, LARGEST_STAGE_COUNT):
        raise LookupError(f"the load path has no stage {shown(number)}; its stages are 1 to {count}")
    return next(islice(_walk(load_path, ("load_path",)), number - 1, None))[0]


def _walk(steps: Any, parent: KeyPath) -> Iterator[tuple[KeyPath, Any]]:
    """Yield the place of each stage in turn, and the stage, from steps that are validated or as written."""
    for index, step in enumerate(steps if isinstance(steps, list | tuple) else ()):
        key, cycle = (*parent, index), _cycle(step)
        if cycle is None:
            yield key, step
        else:
            for _ in range(cycle[1] if cycle[0] else 0):
                yield from _walk(cycle[0], (*key, "cycle", "stages"))


def _cycle(step: Any) -> tuple[Any, int] | None:
    """Return the stages of a cycle and how often they are run; None for a stage."""
    if isinstance(step, CycleSpec):
        return step.cycle.stages, step.cycle.times
    cycle = step.get("cycle") if isinstance(step, dict) else None
    if not isinstance(cycle, dict):
        return None
    times = cycle.get("times")
    return cycle.get("stages"), times if isinstance(times, int) else 1


def check_load_path(load_path: tuple[StageSpec | CycleSpec, ...]) -> tuple[StageSpec | CycleSpec, ...]:
    """Refuse a path that is too long to unroll, or whose first stage presses nothing together."""
    if (count := stage_count(load_path)) > LARGEST_STAGE_COUNT:
        raise refused(f"the load path unrolls to {count} stages; at most {LARGEST_STAGE_COUNT} are possible")
    key, first = next(_walk(load_path, ()))
    if first.P is None and first.delta_z is None:
        refused_at([(key, "the first stage presses nothing together; P or delta_z is needed in it")])
    return load_path
