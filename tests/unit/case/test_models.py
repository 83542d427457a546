"""Cases that are right: what their values become, and that they survive being written and read again."""

from __future__ import annotations

import json
import math
from dataclasses import fields
from pathlib import Path

import pytest
import yaml
from small_cases import write_case

from fretsolve.case.history import BULK, HISTORY_DIMENSIONS, SPOTS
from fretsolve.case.keys.body_specs import (
    ConeSurface,
    CylinderSurface,
    ElasticBody,
    EllipsoidSurface,
    HeightsSurface,
    PunchSurface,
    SphereSurface,
    Surface,
)
from fretsolve.case.loading import load_case
from fretsolve.case.models import Case
from fretsolve.result.state import Summary

FULL = """\
title: Fretting mode I, dissimilar bodies
bodies:
  - {young_modulus: 200 GPa, poisson_ratio: 0.06}
  - {young_modulus: 200 GPa, poisson_ratio: 0.42}
surface: {sphere: {radius: 10 mm}}
grid:
  points: 128
  size: [0.72 mm, 0.72 mm]
  center: [0 mm, 0.01 mm]
friction: 0.1
coupling: auto
load_path:
  - {P: 400 N, increments: 10}
  - {Qx: 36 N, increments: 10}
  - cycle: {times: 3, stages: [{Qx: -36 N, increments: 20}, {Qx: 36 N, increments: 20}]}
  - {delta_x: 1.5 um, increments: 5}
solver: {tolerance: 1e-6, precision: double, max_iterations: 2000}
output: {fields: [pressure, shear, slip, zone], every: 1}
expect:
  - {quantity: stick_radius, value: 0.1398 mm, rel: 0.01, stage: 2}
"""

MINIMAL = """\
bodies: [{young_modulus: 1, poisson_ratio: 0.3}, rigid]
surface: {sphere: {radius: 1}}
grid: {points: 8}
load_path: [{P: 1}]
"""


def load(folder: Path, text: str) -> Case:
    return load_case(write_case(folder, text))


def with_surface(folder: Path, surface: str) -> tuple[Surface, ...]:
    return load(folder, MINIMAL.replace("{sphere: {radius: 1}}", surface)).surface


def test_full_case_in_internal_units(tmp_path: Path) -> None:
    case = load(tmp_path, FULL)
    assert case.title == "Fretting mode I, dissimilar bodies"
    assert case.bodies == (
        ElasticBody(young_modulus=200e3, poisson_ratio=0.06),
        ElasticBody(young_modulus=200e3, poisson_ratio=0.42),
    )
    assert case.surface == (SphereSurface(radius=10.0),)
    assert (case.grid.points, case.grid.size, case.grid.center) == ((128, 128), (0.72, 0.72), (0.0, 0.01))
    assert case.friction.coefficient == 0.1
    assert case.coupling == "auto"
    assert (case.solver.tolerance, case.solver.precision, case.solver.max_iterations) == (1e-6, "double", 2000)
    assert (case.output.fields, case.output.every) == (("pressure", "shear", "slip", "zone"), 1)
    (expected,) = case.expect
    assert (expected.quantity, expected.value, expected.rel, expected.abs) == ("stick_radius", 0.1398, 0.01, None)
    assert expected.stage == 2
    assert case.source.text == FULL
    assert case.source.locate(("friction",)) == 10


def test_cycles_unroll_in_order_with_their_keys(tmp_path: Path) -> None:
    stages = load(tmp_path, FULL).stages()
    assert [stage.number for stage in stages] == list(range(1, 10))
    assert [stage.targets for stage in stages] == [
        (("P", 400.0),),
        (("Qx", 36.0),),
        *[(("Qx", -36.0),), (("Qx", 36.0),)] * 3,
        (("delta_x", 1.5e-3),),
    ]
    assert [stage.increments for stage in stages] == [10, 10, 20, 20, 20, 20, 20, 20, 5]
    assert stages[2].key == stages[4].key == ("load_path", 2, "cycle", "stages", 0)
    assert stages[3].key == ("load_path", 2, "cycle", "stages", 1)
    assert stages[8].key == ("load_path", 3)


def test_stage_moves_several_components(tmp_path: Path) -> None:
    text = MINIMAL.replace("[{P: 1}]", "[{Mz: 5 N mm, delta_z: 2 um, phi_x: 0.1 deg, increments: auto}]")
    (stage,) = load(tmp_path, text).stages()
    assert stage.increments is None
    assert dict(stage.targets) == pytest.approx({"delta_z": 2e-3, "phi_x": math.radians(0.1), "Mz": 5.0})


@pytest.mark.parametrize(
    ("text", "surface"),
    [
        ("{sphere: {radius: -2 cm, center: [1 mm, 2]}}", SphereSurface(radius=-20.0, center=(1.0, 2.0))),
        (
            "{ellipsoid: {radius_x: 1, radius_y: 2, angle: 90 deg}}",
            EllipsoidSurface(radius_x=1.0, radius_y=2.0, angle=math.pi / 2),
        ),
        ("{cylinder: {radius: 1, axis: x}}", CylinderSurface(radius=1.0, axis=0.0)),
        (
            "{cylinder: {radius: 1, axis: y, length: 3, end_radius: 0.5, crown_radius: 100}}",
            CylinderSurface(radius=1.0, axis=math.pi / 2, length=3.0, end_radius=0.5, crown_radius=100.0),
        ),
        ("{cylinder: {radius: 1, axis: 180 deg}}", CylinderSurface(radius=1.0, axis=math.pi)),
        ("{cone: {angle: 2 deg}}", ConeSurface(angle=math.radians(2))),
        ("{punch: {radius: 1 mm, edge_radius: 0.1}}", PunchSurface(radius=1.0, edge_radius=0.1)),
        ("{punch: {half_width: 1 mm}}", PunchSurface(half_width=1.0)),
    ],
)
def test_kinds_of_surfaces(tmp_path: Path, text: str, surface: Surface) -> None:
    assert with_surface(tmp_path, text) == (surface,)


def test_several_surfaces_add_up_in_a_list(tmp_path: Path) -> None:
    kinds = [surface.kind for surface in with_surface(tmp_path, "[{sphere: {radius: 1}}, {cone: {angle: 0.1}}]")]
    assert kinds == ["sphere", "cone"]


def test_heights_file_is_relative_to_the_case(tmp_path: Path) -> None:
    text = "{heights: {file: maps/rough.h5, dataset: z, spacing: 2 um, unit: um, invert: true}}"
    (heights,) = with_surface(tmp_path, text)
    assert isinstance(heights, HeightsSurface)
    assert heights.file == tmp_path / "maps" / "rough.h5"
    assert heights.spacing == pytest.approx((2e-3, 2e-3))
    assert heights.unit == pytest.approx(1e-3)
    assert heights.invert
    (heights,) = with_surface(tmp_path, "{heights: {file: /data/rough.npy, spacing: [1, 2]}}")
    assert heights == HeightsSurface.model_validate({"file": "/data/rough.npy", "spacing": [1, 2]})
    assert (heights.unit, heights.invert) == (None, False)


def test_heights_file_is_absolute_for_a_relative_case(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_case(tmp_path, MINIMAL.replace("sphere: {radius: 1}", "heights: {file: a.npy}"))
    monkeypatch.chdir(tmp_path)
    (heights,) = load_case("case.yaml").surface
    assert isinstance(heights, HeightsSurface)
    assert heights.file == tmp_path / "a.npy"


@pytest.mark.parametrize(
    ("written", "shorthand"),
    [
        ("points: [8, 8]", "points: 8"),
        ("points: 8, size: [2 mm, 2 mm]", "points: 8, size: 2 mm"),
        ("points: 8, size: auto", "points: 8"),
        ("points: 8, center: [0, 0]", "points: 8"),
    ],
)
def test_grid_shorthands(tmp_path: Path, written: str, shorthand: str) -> None:
    assert load(tmp_path, MINIMAL.replace("points: 8", written)) == load(
        tmp_path, MINIMAL.replace("points: 8", shorthand)
    )


ROUND_TRIPS = [
    FULL,
    MINIMAL,
    MINIMAL.replace("{sphere: {radius: 1}}", "[{cylinder: {radius: 1, axis: y}}, {punch: {half_width: 1}}]"),
    MINIMAL.replace("{sphere: {radius: 1}}", "{heights: {file: a.h5, dataset: z, unit: um}}"),
    MINIMAL.replace("[{P: 1}]", "[{cycle: {times: 2, stages: [{P: 1, phi_z: 0.1 deg}, {delta_z: 1e-9 m}]}}]"),
    MINIMAL + "friction: 0.3\nexpect: [{quantity: work, value: 1 uJ, abs: 1e-7}]\ntitle: 'yes'\n",
]


@pytest.mark.parametrize("text", ROUND_TRIPS)
@pytest.mark.parametrize("dump", [json.dumps, yaml.safe_dump])
def test_effective_case_loads_as_an_equal_case(tmp_path: Path, text: str, dump: object) -> None:
    case = load(tmp_path, text)
    assert callable(dump)
    again = load(tmp_path, dump(case.effective()))
    assert again == case
    assert again.stages() == case.stages()
    assert again.effective() == case.effective()


def test_effective_case_has_every_default(tmp_path: Path) -> None:
    assert load(tmp_path, MINIMAL).effective() == {
        "bodies": [{"young_modulus": 1.0, "poisson_ratio": 0.3}, "rigid"],
        "surface": [{"sphere": {"center": [0.0, 0.0], "radius": 1.0}}],
        "grid": {"points": [8, 8], "size": "auto", "center": [0.0, 0.0]},
        "friction": {"coefficient": 0.0},
        "coupling": "auto",
        "load_path": [{"P": 1.0, "increments": "auto"}],
        "solver": {"tolerance": 1e-6, "precision": "double", "max_iterations": 2000, "error_bars": False},
        "output": {"fields": ["pressure", "shear", "slip", "zone"], "every": 1},
        "expect": [],
    }


def test_every_scalar_of_the_history_can_be_expected() -> None:
    scalars = {field.name for field in fields(Summary)} - {"step", "stage", *BULK[1], *BULK[2], *SPOTS}
    assert set(HISTORY_DIMENSIONS) == scalars


@pytest.mark.parametrize(
    ("quantity", "value", "internal"),
    [
        ("P", "1 kN", 1000.0),
        ("Mz", "5 N*m", 5000.0),
        ("delta_x", "1 um", 1e-3),
        ("phi_z", "180 deg", math.pi),
        ("stick_area", "1 cm^2", 100.0),
        ("max_pressure", "2 GPa", 2000.0),
        ("work_total", "1 mJ", 1.0),
        ("residual_gap", "1 %", 0.01),
        ("iterations_normal", "30", 30.0),
        ("wall_time", "1 min", 60.0),
    ],
)
def test_expected_value_has_the_dimension_of_its_quantity(
    tmp_path: Path, quantity: str, value: str, internal: float
) -> None:
    text = f"expect: [{{quantity: {quantity}, value: {value}, abs: {value}}}]"
    (expected,) = load(tmp_path, MINIMAL + text).expect
    assert expected.value == pytest.approx(internal, rel=1e-14)
    assert expected.abs == expected.value
