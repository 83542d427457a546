"""The case file: read, validated, with the line of everything in it."""

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
