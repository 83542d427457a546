"""Validate the constants of a material that fatigue parameters and cracks need, with what follows from them.

Stresses are in MPa, stress intensities in MPa m^0.5, the growth of a crack in m per cycle.
"""

from __future__ import annotations

import math
import re
from typing import Annotated

from pydantic import BeforeValidator, Field, ValidationInfo

from fretsolve.case.base import CaseModel
from fretsolve.case.dimensions import LENGTH, NUMBER, PRESSURE, STRESS_INTENSITY
from fretsolve.case.quantities import InUnits, QuantityError, refused, shown, to_internal
from fretsolve.errors import CaseError

Stress = Annotated[float, InUnits(PRESSURE, above=0)]
StressIntensity = Annotated[float, InUnits(STRESS_INTENSITY, above=0)]
Exponent = Annotated[float, InUnits(NUMBER, least=-2, below=0)]


class LifeCurve(CaseModel):
    """Strain amplitudes over cycles N: (strength/modulus) (2N)^b + ductility (2N)^c. Both terms fall with N."""

    strength: Stress = Field(description="fatigue strength coefficient", examples=["1000 MPa"])
    strength_exponent: Exponent = Field(description="its exponent b, negative", examples=[-0.1])
    ductility: Annotated[float, InUnits(NUMBER, least=0)] = Field(
        default=0.0, description="fatigue ductility coefficient, a strain", examples=[0.5]
    )
    ductility_exponent: Exponent = Field(default=-0.6, description="its exponent c, negative", examples=[-0.6])


_GROWTH = re.compile(
    r"^\s*(?P<number>[^\s/(]+)\s*(?P<length>[a-zµ]+)\s*(?:/\s*cycle)?\s*"
    r"(?:/\s*\(\s*(?P<unit>MPa[^()]*(?:\([^()]*\))?)\s*\)\s*\^\s*(?P<power>[0-9.]+))?\s*(?:/\s*cycle)?\s*$"
)
"""A coefficient with units: a length per cycle, over a unit of stress intensity to the power of the exponent."""


def read_growth(value: object, info: ValidationInfo) -> float:
    """Return Paris's coefficient in m per cycle with the range in MPa m^0.5, from a number or a text with units."""
    wanted = "a number in m per cycle with the range in MPa m^0.5, such as 1e-11, or a text such as"
    wanted = f"{wanted} '5e-13 mm/(MPa mm^0.5)^3' is needed"
    exponent = info.data.get("exponent", 0.0)
    try:
        match = _GROWTH.match(value) if isinstance(value, str) else None
        if match is None:
            found = to_internal(value, NUMBER)
        else:
            found = 1e-3 * to_internal(f"{match['number']} {match['length']}", LENGTH)
            found /= to_internal(f"1 {match['unit']}", STRESS_INTENSITY) ** exponent if match["unit"] else 1.0
    except (QuantityError, ValueError, OverflowError):
        raise refused(f"{shown(value)} is not a coefficient of Paris's law; {wanted}") from None
    if match is not None and match["unit"] is not None and float(match["power"]) != exponent:
        raise refused(f"{shown(value)} has the power {match['power']}, the exponent is {exponent:g}; {wanted}")
    if not 0.0 < found < 1.0:
        raise refused(f"{shown(value)} is out of range; {wanted}")
    return found


class ParisLaw(CaseModel):
    """Growth of a crack in a cycle: C times the range of stress intensity to the power m (Paris & Erdogan 1963)."""

    exponent: Annotated[float, InUnits(NUMBER, above=0, most=20)] = Field(description="its exponent m", examples=[3])
    coefficient: Annotated[float, BeforeValidator(read_growth)] = Field(
        description="its coefficient C, bare in m per cycle with the range in MPa m^0.5; as '5e-13 mm/(MPa mm^0.5)^3'"
        " in units of its own",
        examples=[1e-11],
    )
    walker_exponent: Annotated[float, InUnits(NUMBER, above=0, most=1)] = Field(
        default=1.0,
        description="exponent g of Walker: the range that counts is K_max (1 - R)^g, with the ratio R of the least to"
        " the largest stress intensity, at least 0; 1 counts the range itself",
        examples=[0.5],
    )


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
    threshold_range: StressIntensity | None = Field(
        default=None, description="range of stress intensity below which a long crack stops", examples=["2.1 MPa m^0.5"]
    )
    fatigue_range: Stress | None = Field(
        default=None,
        description="range of stress that a smooth specimen endures, at the ratio of stresses of threshold_range",
        examples=["248 MPa"],
    )
    surface_factor: Annotated[float, InUnits(NUMBER, least=1)] = Field(
        default=1.0,
        description="factor of the fatigue range in the length b_0 of El Haddad; 1.12 takes the free surface into it",
        examples=[1.12],
    )
    paris: ParisLaw | None = Field(default=None, description="law of crack growth")
    toughness: StressIntensity | None = Field(
        default=None, description="stress intensity at which the body breaks", examples=["30 MPa m^0.5"]
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
