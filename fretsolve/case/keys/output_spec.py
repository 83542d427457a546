"""Validate `output`: the fields that the result keeps, stresses below the surface and fatigue parameters.

The constants of a material that fatigue parameters need are in MPa, with what follows from them.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import Field, GetJsonSchemaHandler, field_validator, model_validator
from pydantic_core import CoreSchema

from fretsolve.case.base import CaseModel, Count, PositiveLength, auto, each_once, refused_at
from fretsolve.case.dimensions import LENGTH, NUMBER, PRESSURE
from fretsolve.case.quantities import InUnits, refused
from fretsolve.errors import CaseError

Stress = Annotated[float, InUnits(PRESSURE, above=0)]
Exponent = Annotated[float, InUnits(NUMBER, least=-2, below=0)]


class LifeCurve(CaseModel):
    """Strain amplitudes over cycles N: (strength/modulus) (2N)^b + ductility (2N)^c. Both terms fall with N."""

    strength: Stress = Field(description="fatigue strength coefficient", examples=["1000 MPa"])
    strength_exponent: Exponent = Field(description="its exponent b, negative", examples=[-0.1])
    ductility: Annotated[float, InUnits(NUMBER, least=0)] = Field(
        default=0.0, description="fatigue ductility coefficient, a strain", examples=[0.5]
    )
    ductility_exponent: Exponent = Field(default=-0.6, description="its exponent c, negative", examples=[-0.6])


class Material(CaseModel):
    """Constants of a material; each criterion needs some of them."""

    name: str | None = Field(default=None, description="name of the material", examples=["Ti-6Al-4V"])
    sources: tuple[str, ...] = Field(default=(), description="where the constants come from, a list")
    tension_limit: Stress | None = Field(
        default=None, description="amplitude endured in fully reversed tension, s", examples=["300 MPa"]
    )
    torsion_limit: Stress | None = Field(
        default=None, description="amplitude endured in fully reversed torsion, t", examples=["190 MPa"]
    )
    mcdiarmid_limit: Stress | None = Field(
        default=None, description="McDiarmid's shear limit t_A or t_B; by default torsion_limit", examples=["190 MPa"]
    )
    tensile_strength: Stress | None = Field(default=None, description="tensile strength", examples=["700 MPa"])
    yield_stress: Stress | None = Field(default=None, description="yield stress", examples=["500 MPa"])
    fatemi_socie_factor: Annotated[float, InUnits(NUMBER, least=0)] = Field(
        default=1.0,
        description="Fatemi and Socie's factor k of the normal stress over the yield stress",
        examples=[1.0],
    )
    young_modulus: Stress | None = Field(default=None, description="Young's modulus; by default the body's")
    poisson_ratio: Annotated[float, InUnits(NUMBER, above=-1, most=0.5)] | None = Field(
        default=None, description="Poisson's ratio; by default the body's", examples=[0.3]
    )
    strain_life: LifeCurve | None = Field(
        default=None, description="life curve of normal strain, for Smith, Watson and Topper's parameter"
    )
    shear_strain_life: LifeCurve | None = Field(
        default=None, description="life curve of shear strain, for Fatemi and Socie's parameter"
    )

    def needed(self, name: str) -> float:
        """Return a constant. Raises CaseError if it is not given."""
        value = getattr(self, name)
        if value is None:
            dimension = NUMBER if name == "poisson_ratio" else PRESSURE
            raise CaseError(f"is missing; {dimension.wanted} is needed", (name,))
        return float(value)

    def limit_ratio(self, criterion: str, above: float, below: float = math.inf) -> float:
        """Return torsion_limit/tension_limit. Raises CaseError if it is not between the bounds of a criterion."""
        torsion, tension = self.needed("torsion_limit"), self.needed("tension_limit")
        ratio = torsion / tension
        if not above < ratio < below:
            bounds = f"above {above:.6g}" + (f" and below {below:.6g}" if below < math.inf else "")
            raise CaseError(
                f"torsion_limit/tension_limit is {torsion:g}/{tension:g} = {ratio:.4g};"
                f" a ratio {bounds} is needed for {criterion}",
                ("torsion_limit",),
            )
        return ratio

    @property
    def crossland_factor(self) -> float:
        """aC = 3 t/s - sqrt(3), of the largest hydrostatic stress."""
        return 3.0 * self.limit_ratio("crossland", 1.0 / math.sqrt(3.0)) - math.sqrt(3.0)

    @property
    def dang_van_factor(self) -> float:
        """aD = 3 t/s - 3/2, of the hydrostatic stress."""
        return 3.0 * self.limit_ratio("dang-van", 0.5) - 1.5

    @property
    def findley_factor(self) -> float:
        """k from s/t = 2/(1 + k/sqrt(1 + k^2)), of the largest normal stress."""
        sine = 2.0 * self.limit_ratio("findley", 0.5, 1.0) - 1.0
        return sine / math.sqrt(1.0 - sine**2)

    @property
    def findley_limit(self) -> float:
        """f = t sqrt(1 + k^2)."""
        return self.needed("torsion_limit") * math.hypot(1.0, self.findley_factor)

    @property
    def mcdiarmid_shear_limit(self) -> float:
        """t_A or t_B, by default t."""
        return self.needed("torsion_limit") if self.mcdiarmid_limit is None else self.mcdiarmid_limit

    @property
    def mcdiarmid_factor(self) -> float:
        """t_AB/(2 su), of the largest normal stress."""
        return self.mcdiarmid_shear_limit / (2.0 * self.needed("tensile_strength"))

    @property
    def shear_modulus(self) -> float:
        """G = E/(2 (1 + nu))."""
        return self.needed("young_modulus") / (2.0 * (1.0 + self.needed("poisson_ratio")))


Depth = Annotated[float, InUnits(LENGTH, least=0)]
Bodies = Annotated[
    tuple[Literal[1, 2], ...], Field(description="bodies; none for body 2, or 1 if that is rigid", examples=[[1, 2]])
]
Depths = Annotated[
    tuple[Depth, ...],
    Field(
        description="depths below the surface; none for the surface and graded ones to two contact radii",
        examples=[["0 mm", "5 um", "20 um"]],
    ),
]
StressComponent = Literal["xx", "yy", "zz", "xy", "xz", "yz"]

ALL_COMPONENTS: tuple[StressComponent, ...] = ("xx", "yy", "zz", "xy", "xz", "yz")


class StressSpec(CaseModel):
    """Stresses below the surface, computed at the end of the run and written beside the result (`NAME.stress.h5`)."""

    bodies: Bodies = ()
    depths: Depths = ()
    every: Annotated[Count | None, auto("10")] = Field(
        default=None,
        description="every n-th increment, if its fields are stored, and the last one, or auto: the ends of stages",
        examples=[10],
    )
    window: Literal["auto", "all"] = Field(
        default="auto",
        description="the cells: auto, the contact with a margin, as in `fretsolve stress`, or all, the whole grid",
    )
    components: tuple[StressComponent, ...] = Field(
        default=ALL_COMPONENTS, description="components to store; none to keep the largest stresses alone"
    )

    @field_validator("bodies", "depths", "components")
    @classmethod
    def _each_once(cls, values: tuple[object, ...]) -> tuple[object, ...]:
        return each_once(values)


CriterionName = Literal["crossland", "dang-van", "findley", "mcdiarmid", "fatemi-socie", "swt"]
AverageKind = Literal["point", "line", "volume"]

KINDS: tuple[AverageKind, ...] = ("point", "line", "volume")


class MaterialFile:
    """Annotation of a material: in the file, the name of a material file may stand in its place."""

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return {"anyOf": [{"type": "string"}, handler(schema)]}


class AverageSpec(CaseModel):
    """A length over which stresses are averaged before a parameter is taken, of one of three kinds."""

    point: PositiveLength | None = Field(
        default=None, description="the stress at half this length below the surface", examples=["20 um"]
    )
    line: PositiveLength | None = Field(
        default=None, description="its mean over depths from 0 to twice this length", examples=["20 um"]
    )
    volume: PositiveLength | None = Field(
        default=None, description="its mean over a cube of this side below the surface", examples=["20 um"]
    )

    @model_validator(mode="after")
    def _one(self) -> AverageSpec:
        given = [kind for kind in KINDS if getattr(self, kind) is not None]
        if len(given) != 1:
            there = f"{' and '.join(given)} are given" if given else "none is given"
            raise refused(f"one of {', '.join(KINDS)} is needed, such as {{point: 20 um}}; {there}")
        return self

    @property
    def kind(self) -> AverageKind:
        """The key that is given."""
        return next(kind for kind in KINDS if getattr(self, kind) is not None)

    @property
    def length(self) -> float:
        """Its length (mm)."""
        return float(getattr(self, self.kind))


class FatigueSpec(CaseModel):
    """Fatigue parameters over the last `cycle` of the load path, computed at the end of the run and written beside the
    result (`NAME.fatigue.h5`)."""

    material: Annotated[Material, MaterialFile()] = Field(
        description="constants of the material, or the name of a file of them, relative to the case file",
        examples=["steel.yaml"],
    )
    criteria: tuple[CriterionName, ...] = Field(min_length=1, description="criteria", examples=[["crossland", "swt"]])
    average: AverageSpec | None = Field(
        default=None, description="average stresses first", examples=[{"point": "20 um"}]
    )
    bodies: Bodies = ()
    depths: Depths = ()

    @field_validator("criteria", "bodies", "depths")
    @classmethod
    def _each_once(cls, values: tuple[object, ...]) -> tuple[object, ...]:
        return each_once(values)

    @model_validator(mode="after")
    def _depths_matter(self) -> FatigueSpec:
        if self.depths and self.average is not None:
            refused_at([(("depths",), "an average has depths of its own; remove one of the two")])
        return self


WearField = Literal["wear_depth", "wear_depth_1", "wear_depth_2"]
FieldName = Literal[
    "pressure", "shear", "slip", "slip_path", "work_density", "zone", "gap", "friction", "shear_bound", WearField
]
DEFAULT_FIELDS: tuple[FieldName, ...] = ("pressure", "shear", "slip", "zone")


class OutputSpec(CaseModel):
    """The fields that the result keeps; `shear` and `slip` stand for both of their components."""

    fields: tuple[FieldName, ...] = Field(
        default=DEFAULT_FIELDS, description="fields to store; with wear, wear_depth is among them if they are left out"
    )
    every: Count = Field(default=1, description="fields are stored at every n-th increment")
    stress: StressSpec | None = Field(
        default=None, description="stresses below the surface at the end of the run", examples=[{"bodies": [2]}]
    )
    fatigue: FatigueSpec | None = Field(default=None, description="fatigue parameters at the end of the run")

    @field_validator("fields")
    @classmethod
    def _each_once(cls, names: tuple[FieldName, ...]) -> tuple[FieldName, ...]:
        return each_once(names)
