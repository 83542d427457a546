"""The load path as the case file has it: stages, and cycles of stages or of an amplitude."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import ConfigDict, Discriminator, Field, Tag, ValidationError, model_validator
from pydantic.config import JsonDict, JsonValue

from fretsolve.case.base import CaseModel, Count, Length, PositiveLength, auto, refused_at
from fretsolve.case.dimensions import ANGLE, CYCLE_COUNT, FORCE, MOMENT, NUMBER, STRESS
from fretsolve.case.history import BULK, COMPONENTS
from fretsolve.case.quantities import InUnits, refused

MOST_CYCLES, CYCLE_TOLERANCE = 20, 0.01
"""By default: the most cycles of one that runs until it is periodic, and the tolerance of a cycle: the distance to the
limit, or the error of the worn volume by the jumps of a cycle that stands for others."""

Force = Annotated[float, InUnits(FORCE)]
Moment = Annotated[float, InUnits(MOMENT)]
Angle = Annotated[float, InUnits(ANGLE)]


@dataclass(frozen=True)
class WearJumps:
    """The cycles that one solved cycle stands for under wear, and the jumps between solved cycles.

    represents: cycles in all, >= 1; jump: cycles that one solved cycle stands for, None to choose it by the estimated
    error; tolerance: of the worn volume; max_depth: largest depth of one jump (mm), None for a part of the approach.
    """

    represents: float
    jump: float | None = None
    tolerance: float = CYCLE_TOLERANCE
    max_depth: float | None = None


def exclusive(modes: Sequence[Sequence[str]]) -> list[JsonValue]:
    """Return the conditions of a JSON Schema that allow one component of each mode at most."""
    return [{"not": {"required": [*pair]}} for names in modes for pair in combinations(names, 2)]


class BulkStress(CaseModel):
    """A uniform in-plane stress that stretches a body, and with it its surface. What is not named stays as it is."""

    model_config = ConfigDict(json_schema_extra={"minProperties": 1})

    xx: Annotated[float, InUnits(STRESS)] | None = Field(
        default=None, description="normal stress along x, tensile", examples=["70 MPa"]
    )
    yy: Annotated[float, InUnits(STRESS)] | None = Field(
        default=None, description="normal stress along y, tensile", examples=["70 MPa"]
    )
    xy: Annotated[float, InUnits(STRESS)] | None = Field(
        default=None, description="shear stress in the plane of the surface", examples=["70 MPa"]
    )

    @model_validator(mode="after")
    def _one_is_named(self) -> Self:
        if self.xx is None and self.yy is None and self.xy is None:
            raise refused("the bulk stress has no value; at least one of xx, yy, xy is needed")
        return self


class StageSpec(CaseModel):
    """A stage: the totals to which it moves the load components that it names. The rest stays as it is."""

    model_config = ConfigDict(json_schema_extra={"minProperties": 1, "allOf": exclusive(COMPONENTS)})

    nothing: ClassVar[str] = "the stage moves nothing"
    others: ClassVar[str] = "bulk_1, bulk_2, friction"

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
    actuator_x: Length | None = Field(
        default=None, description="with rig, displacement of the actuator along x", examples=["2 um"]
    )
    actuator_y: Length | None = Field(
        default=None, description="with rig, displacement of the actuator along y", examples=["2 um"]
    )
    actuator_z: Length | None = Field(
        default=None, description="with rig, approach of the bodies at the actuator", examples=["12 um"]
    )
    actuator_phi_x: Angle | None = Field(
        default=None, description="with rig, tilt of the actuator about x", examples=["0.01 deg"]
    )
    actuator_phi_y: Angle | None = Field(
        default=None, description="with rig, tilt of the actuator about y", examples=["0.01 deg"]
    )
    actuator_phi_z: Angle | None = Field(
        default=None, description="with rig, rotation of the actuator about z", examples=["0.01 deg"]
    )
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
        """The components that the stage moves, each with its new total (mm, N, N mm, rad, MPa), and its friction."""
        named = [(name, getattr(self, name)) for names in COMPONENTS for name in names]
        for body, stress in ((1, self.bulk_1), (2, self.bulk_2)):
            if stress is not None:
                named += zip(BULK[body], (stress.xx, stress.yy, stress.xy), strict=True)
        named.append(("friction", self.friction))
        return tuple((name, value) for name, value in named if value is not None)

    @model_validator(mode="after")
    def _one_of_each_pair(self) -> Self:
        named = {name for name, _ in self.targets}
        if not named:
            components = ", ".join(name for names in COMPONENTS for name in names[:2])
            raise refused(f"{self.nothing}; at least one of {components}, {self.others} is needed")
        pairs = [pair for names in COMPONENTS for pair in combinations(names, 2)]
        if both := [f"{one} and {other}" for one, other in pairs if {one, other} <= named]:
            raise refused(f"{', '.join(both)} cannot be imposed at once; keep one of the two")
        return self


class AmplitudeSpec(StageSpec):
    """Amplitudes of load components that move in phase (one below 0 moves the other way), or their means."""

    nothing: ClassVar[str] = "no component is given"
    others: ClassVar[str] = "bulk_1, bulk_2"
    friction: ClassVar[None] = None  # type: ignore[misc]
    increments: ClassVar[None] = None  # type: ignore[misc]
    spacing: ClassVar[None] = None  # type: ignore[misc]


class Repetition(CaseModel):
    """The number of times that a cycle is run, or that it stands for under wear."""

    times: Count | None = Field(default=None, description="number of repetitions, such as 3", examples=[3])
    until: Literal["periodic"] | None = Field(
        default=None,
        description="instead of times: periodic, to repeat the cycle until its dissipated energy and the values at its"
        " end are within the tolerance of their limits",
        examples=["periodic"],
    )
    at_most: Annotated[int, Field(strict=True, ge=2, le=10**9)] | None = Field(
        default=None, description=f"with until: the most repetitions, {MOST_CYCLES} if it is left out", examples=[20]
    )
    represents: Annotated[float, InUnits(CYCLE_COUNT, least=1)] | None = Field(
        default=None,
        description="instead of times: number of cycles that a few solved ones stand for, which wear needs; the cycle"
        " has to end at the loads that it begins with",
        examples=[1e5],
    )
    jump: (
        Annotated[
            Annotated[float, InUnits(CYCLE_COUNT, least=1), Tag("(number)")]
            | Annotated[Literal["auto"], Tag("(auto)")],
            Discriminator(lambda value: "(auto)" if value == "auto" else "(number)"),
        ]
        | None
    ) = Field(
        default=None,
        description="with represents: number of cycles that each solved one stands for, or auto: by the tolerance",
        examples=[1000],
    )
    max_depth: PositiveLength | None = Field(
        default=None,
        description="with represents: largest depth that is worn by one jump, such as 50 nm",
        examples=["50 nm"],
    )
    tolerance: Annotated[float, InUnits(NUMBER, above=0, below=1)] | None = Field(
        default=None,
        description="with until: the distance to the limit, over the energy and the ranges of the cycle; with"
        " represents: the error of the worn volume by the jumps, which a given jump may exceed; 1 % if it is left out",
        examples=["1 %"],
    )

    @property
    def jumps(self) -> WearJumps | None:
        """The cycles that it stands for under wear, None where it stands for itself."""
        if self.represents is None:
            return None
        jump = self.jump if isinstance(self.jump, float) else None
        return WearJumps(self.represents, jump, self.tolerance or CYCLE_TOLERANCE, self.max_depth)

    @property
    def most(self) -> int:
        """The number of repetitions, or the most of them; 1 for a cycle that stands for others."""
        return 1 if self.represents else self.times or self.at_most or MOST_CYCLES

    @model_validator(mode="before")
    @classmethod
    def _defaults_of_until(cls, value: Any) -> Any:
        if isinstance(value, dict) and value.get("until") == "periodic":
            return {"at_most": MOST_CYCLES, "tolerance": CYCLE_TOLERANCE, **value}
        if isinstance(value, dict) and "represents" in value:
            return {"jump": "auto", "tolerance": CYCLE_TOLERANCE, **value}
        return value

    @model_validator(mode="after")
    def _times_or_until_or_represents(self) -> Self:
        if self.represents is not None:
            self._only_represents(self.represents)
            return self
        given = [name for name in ("jump", "max_depth") if getattr(self, name) is not None]
        refused_at(((name,), "only represents takes it; remove it, or add represents: 1e5") for name in given)
        if self.until is None:
            given = [name for name in ("at_most", "tolerance") if getattr(self, name) is not None]
            refused_at(((name,), "only until: periodic takes it; remove it, or add until: periodic") for name in given)
            if self.times is None:
                raise ValidationError.from_exception_data(
                    "case", [{"type": "missing", "loc": ("times",), "input": None}]
                )
        elif self.times is not None:
            refused_at([(("times",), "times and until exclude each other; at_most limits a cycle with until")])
        return self

    def _only_represents(self, cycles: float) -> None:
        """Refuse what cannot stand beside `represents`, the number of `cycles`."""
        others = [name for name in ("times", "until") if getattr(self, name) is not None]
        others += ["at_most"] if self.at_most is not None and self.until is None else []
        refused_at(((name,), f"{name} and represents exclude each other; keep one of them") for name in others)
        if not cycles.is_integer():
            refused_at([(("represents",), f"{cycles:.17g} is not a whole number of cycles")])
        if isinstance(self.jump, float) and self.jump > cycles:
            message = f"{self.jump:g} cycles are more than the {cycles:g} that the cycle represents"
            refused_at([(("jump",), f"{message}; at most as many, or auto, are possible")])


_REPEATED: JsonDict = {"oneOf": [{"required": ["times"]}, {"required": ["until"]}, {"required": ["represents"]}]}


class Cycle(Repetition):
    """Stages that are repeated."""

    model_config = ConfigDict(json_schema_extra=_REPEATED)

    stages: tuple[LoadStep, ...] = Field(
        min_length=1,
        description="the stages of one cycle, a list; or an amplitude",
        examples=[[{"Qx": "-36 N", "increments": 20}, {"Qx": "36 N", "increments": 20}]],
    )

    @model_validator(mode="after")
    def _loop_is_simple(self) -> Self:
        if any(isinstance(step, CycleSpec) for step in self.stages):
            given = [name for name in ("until", "represents") if getattr(self, name) is not None]
            refused_at(
                ((name,), "its stages hold cycles, of which each may have its own; remove it here") for name in given
            )
        return self


class AmplitudeCycle(Repetition):
    """A cycle about a mean: from where it stands to mean + amplitude, then on each repetition to mean - amplitude and
    back."""

    model_config = ConfigDict(json_schema_extra=_REPEATED)

    amplitude: AmplitudeSpec = Field(
        description="amplitudes of the load components that move", examples=[{"delta_x": "2 um"}]
    )
    mean: AmplitudeSpec | None = Field(
        default=None, description="their means, 0 if left out", examples=[{"delta_x": "1 um"}]
    )
    increments: Annotated[Count | None, auto("20")] = Field(
        default=None,
        description="increments of one repetition, in two equal halves, and a quarter of them on the way to the first"
        " end (rounded up), or auto: as many as the case needs",
        examples=[20],
    )
    spacing: Literal["equal", "graded"] | None = Field(default=None, description="as in a stage")

    @property
    def middle(self) -> dict[str, float]:
        """The means by the names of the components."""
        return {} if self.mean is None else dict(self.mean.targets)

    def targets(self, sign: float) -> tuple[tuple[str, float], ...]:
        """Return the components at an end of the cycle: mean + sign * amplitude."""
        return tuple((name, self.middle.get(name, 0.0) + sign * value) for name, value in self.amplitude.targets)

    def count(self, parts: int) -> int | None:
        """Return the increments of a half (2) or a quarter (4) of the cycle, None if they are automatic."""
        return None if self.increments is None else -(-self.increments // parts)

    @model_validator(mode="after")
    def _mean_of_what_moves(self) -> Self:
        moved = dict(self.amplitude.targets)
        problems = [
            (("amplitude", name), "the amplitude is 0; another value is needed, or leave it out")
            for name, value in moved.items()
            if value == 0.0 and name in type(self.amplitude).model_fields
        ]
        problems += [
            (("mean", name), "it has no amplitude; a stage before the cycle sets what stays as it is")
            for name in self.middle
            if name not in moved
        ]
        refused_at(problems)
        if self.amplitude.P is not None and (mean := self.middle.get("P", 0.0)) < self.amplitude.P:
            message = f"{self.amplitude.P:g} is more than the mean of P ({mean:g}), so that P would fall below 0"
            refused_at([(("amplitude", "P"), f"{message}; a larger mean or a smaller amplitude is needed")])
        return self


def cycle_tag(value: object) -> str:
    """Return which kind of cycle `value` is."""
    amplitude = "amplitude" in value if isinstance(value, dict) else isinstance(value, AmplitudeCycle)
    return "(amplitude)" if amplitude else "(stages)"


class CycleSpec(CaseModel):
    """An entry of the load path that is a cycle."""

    cycle: Annotated[
        Annotated[Cycle, Tag("(stages)")] | Annotated[AmplitudeCycle, Tag("(amplitude)")], Discriminator(cycle_tag)
    ] = Field(
        description="stages, or an amplitude, that are repeated",
        examples=[{"amplitude": {"delta_x": "2 um"}, "times": 3, "increments": 20}],
    )


def step_tag(value: object) -> str:
    """Return which kind of entry of a load path `value` is."""
    # The tags appear in the locations of pydantic's errors and must differ from every key of the file.
    is_cycle = "cycle" in value if isinstance(value, dict) else isinstance(value, CycleSpec)
    return "(cycle)" if is_cycle else "(stage)"


LoadStep = Annotated[
    Annotated[StageSpec, Tag("(stage)")] | Annotated[CycleSpec, Tag("(cycle)")], Discriminator(step_tag)
]
