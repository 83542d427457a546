"""The case file. In comes a YAML file with its overrides, out comes a frozen `Case` in mm, N, MPa, rad.

Every mistake is a `CaseError` with its line. Only pydantic and YAML are loaded.

    case = load_case("cases/mode1_similar.yaml", ["friction=0.2", "stage.2.increments=20"])
"""

from __future__ import annotations

from .expectations import HISTORY_DIMENSIONS, Expectation
from .load_path_spec import CycleSpec, Stage, StageSpec
from .loading import CaseText, load_case, read_case
from .models import (
    Body,
    Case,
    ElasticBody,
    FrictionSpec,
    GridSpec,
    OutputSpec,
    RigidBody,
    SolverSpec,
)
from .problems import CaseErrors
from .quantities import Dimension
from .schema import case_schema
from .source import CaseSource
from .surface_specs import (
    ConeSurface,
    CylinderSurface,
    EllipsoidSurface,
    HeightsSurface,
    PunchSurface,
    SphereSurface,
    Surface,
)

__all__ = [
    "HISTORY_DIMENSIONS",
    "Body",
    "Case",
    "CaseErrors",
    "CaseSource",
    "CaseText",
    "ConeSurface",
    "CycleSpec",
    "CylinderSurface",
    "Dimension",
    "ElasticBody",
    "EllipsoidSurface",
    "Expectation",
    "FrictionSpec",
    "GridSpec",
    "HeightsSurface",
    "OutputSpec",
    "PunchSurface",
    "RigidBody",
    "SolverSpec",
    "SphereSurface",
    "Stage",
    "StageSpec",
    "Surface",
    "case_schema",
    "load_case",
    "read_case",
]
