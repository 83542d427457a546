"""The rig in series with the contact, and the layer between the bodies, as the case file has them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Self

from pydantic import ConfigDict, Field, ValidationInfo, field_validator, model_validator

from fretsolve.case.base import CaseModel, PositiveLength, refused_at
from fretsolve.case.dimensions import LAYER_COMPLIANCE, PRESSURE, STIFFNESS, TURNING_STIFFNESS
from fretsolve.case.history import ACTUATORS
from fretsolve.case.keys.map_keys import file_in_case_folder
from fretsolve.case.quantities import InUnits, refused

Stiffness = Annotated[float, InUnits(STIFFNESS, above=0)]
TurningStiffness = Annotated[float, InUnits(TURNING_STIFFNESS, above=0)]
Modulus = Annotated[float, InUnits(PRESSURE, above=0)]
LayerCompliance = Annotated[float, InUnits(LAYER_COMPLIANCE, above=0)]

STIFFNESSES = {f"stiffness_{motion.removeprefix('delta_')}": motion for motion in ACTUATORS}
"""The stiffness of each motion, by the keys of a rig."""


class RigSpec(CaseModel):
    """Springs along the contact's motions, or a compliance matrix, between the contact and the actuator."""

    model_config = ConfigDict(json_schema_extra={"minProperties": 1})

    stiffness_x: Stiffness | None = Field(default=None, description="stiffness along x", examples=["50 kN/mm"])
    stiffness_y: Stiffness | None = Field(default=None, description="stiffness along y", examples=["50 kN/mm"])
    stiffness_z: Stiffness | None = Field(
        default=None, description="stiffness along the normal", examples=["200 kN/mm"]
    )
    stiffness_phi_x: TurningStiffness | None = Field(
        default=None, description="stiffness against tilts about x", examples=["5e6 N mm/rad"]
    )
    stiffness_phi_y: TurningStiffness | None = Field(
        default=None, description="stiffness against tilts about y", examples=["5e6 N mm/rad"]
    )
    stiffness_phi_z: TurningStiffness | None = Field(
        default=None, description="stiffness against turns about z", examples=["5e6 N mm/rad"]
    )
    compliance: Path | None = Field(
        default=None,
        description="instead of stiffnesses: text file with the 6 x 6 compliance in mm/N, rad/N, rad/(N mm); columns"
        " Qx, Qy, P, Mx, My, Mz, rows delta_x, delta_y, delta_z, phi_x, phi_y, phi_z",
        examples=["rig.csv"],
    )

    @property
    def gives(self) -> frozenset[str]:
        """The motions in which actuator and contact may differ; all of them under a compliance matrix."""
        if self.compliance is not None:
            return frozenset(ACTUATORS)
        return frozenset(motion for key, motion in STIFFNESSES.items() if getattr(self, key, None) is not None)

    @field_validator("compliance", mode="before")
    @classmethod
    def _in_the_folder_of_the_case(cls, value: object, info: ValidationInfo) -> Path | None:
        return None if value is None else file_in_case_folder(value, info, "rig.csv")

    @model_validator(mode="after")
    def _springs_or_matrix(self) -> Self:
        named = [key for key in STIFFNESSES if getattr(self, key, None) is not None]
        if self.compliance is not None:
            refused_at(((key,), f"{key} and compliance exclude each other; keep one of the two") for key in named)
        elif not named:
            raise refused("the rig is rigid; at least one stiffness, such as stiffness_x: 50 kN/mm, is needed")
        return self


class InterfaceSpec(CaseModel):
    """A thin layer between the bodies that shears and is compressed: a third body, an oxide, asperities.

    It moves by the traction at its place alone.
    """

    model_config = ConfigDict(json_schema_extra={"minProperties": 1})

    shear_compliance: LayerCompliance | None = Field(
        default=None, description="tangential displacement per shear traction", examples=["2e-5 mm/MPa"]
    )
    normal_compliance: LayerCompliance | None = Field(
        default=None, description="approach per pressure", examples=["1e-5 mm/MPa"]
    )
    thickness: PositiveLength | None = Field(
        default=None, description="thickness of the layer, with its moduli", examples=["5 um"]
    )
    shear_modulus: Modulus | None = Field(
        default=None, description="with thickness, instead of shear_compliance: shear modulus", examples=["2 GPa"]
    )
    normal_modulus: Modulus | None = Field(
        default=None,
        description="with thickness, instead of normal_compliance: modulus of a layer that cannot widen (oedometric)",
        examples=["6 GPa"],
    )

    @property
    def tangential(self) -> float:
        """Tangential displacement per shear traction (mm/MPa)."""
        return _compliance(self.shear_compliance, self.thickness, self.shear_modulus)

    @property
    def normal(self) -> float:
        """Approach per pressure (mm/MPa)."""
        return _compliance(self.normal_compliance, self.thickness, self.normal_modulus)

    @model_validator(mode="after")
    def _either_compliance_or_modulus(self) -> Self:
        moduli = [name for name in ("shear_modulus", "normal_modulus") if getattr(self, name) is not None]
        for name in moduli:
            other = name.replace("modulus", "compliance")
            if getattr(self, other) is not None:
                refused_at([((name,), f"{name} and {other} exclude each other; keep one of the two")])
        if moduli and self.thickness is None:
            refused_at([((moduli[0],), "a modulus needs the layer's thickness; add thickness: 5 um")])
        if self.thickness is not None and not moduli:
            refused_at([(("thickness",), "a thickness needs a modulus; add shear_modulus: 2 GPa, or normal_modulus")])
        if not moduli and self.shear_compliance is None and self.normal_compliance is None:
            raise refused("the layer is rigid; shear_compliance, such as 2e-5 mm/MPa, or a modulus is needed")
        return self


def _compliance(given: float | None, thickness: float | None, modulus: float | None) -> float:
    if given is not None:
        return given
    return thickness / modulus if thickness is not None and modulus is not None else 0.0
