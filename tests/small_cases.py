"""Small cases as case files have them; each is solved within a second or two."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from fretsolve.case.loading import load_case
from fretsolve.errors import CaseError

SIMILAR = "[{young_modulus: 200 GPa, poisson_ratio: 0.3}, {young_modulus: 200 GPa, poisson_ratio: 0.3}]"
DISSIMILAR = "[{young_modulus: 200 GPa, poisson_ratio: 0.06}, {young_modulus: 200 GPa, poisson_ratio: 0.42}]"
UNLIKE = f"bodies={DISSIMILAR}"

SPHERE = """\
bodies:
  - {young_modulus: 200 GPa, poisson_ratio: 0.3}
  - {young_modulus: 200 GPa, poisson_ratio: 0.3}
surface: {sphere: {radius: 10 mm}}
grid: {points: 16}
friction: 0.1
"""
"""A case that lacks its load path."""

CASE = f"""\
title: tiny
{SPHERE}load_path:
  - {{P: 400 N, increments: 1}}
  - {{Qx: 20 N, increments: 4}}
expect:
  - {{quantity: delta_z, value: 9.066544 um, rel: 1 %}}
  - {{quantity: Qx, value: 0 N, abs: 1e-6 N, stage: 1}}
"""

SWEPT = f"""\
title: small
{SPHERE.replace("16", "12")}load_path:
  - {{P: 400 N, increments: 1}}
  - {{Qx: 36 N, increments: 2}}
"""
"""The case of the sweep in `sweeping`."""

LOOP = f"""\
title: loop
{SPHERE.replace("16", "12")}coupling: none
load_path:
  - {{P: 400 N}}
  - {{Qx: 36 N, increments: 1}}
  - cycle: {{times: 1, stages: [{{Qx: -36 N, increments: 1}}, {{Qx: 18 N, increments: 1}}]}}
"""


TWO_CYCLES = f"""\
title: loop
{SPHERE.replace("friction: 0.1", "friction: 0.4")}load_path:
  - {{P: 400 N}}
  - {{Qx: 100 N, increments: 2}}
  - cycle: {{times: 2, stages: [{{Qx: -100 N, increments: 2}}, {{Qx: 100 N, increments: 2}}]}}
"""
"""Two cycles of four states each, for stresses and fatigue parameters."""

CYCLES_UNDER_BULK = """\
bodies:
  - {young_modulus: 200 GPa, poisson_ratio: 0.3}
  - {young_modulus: 70 GPa, poisson_ratio: 0.33}
surface: {sphere: {radius: 10 mm}}
grid: {points: 24}
friction: 0.4
coupling: tangential
load_path:
  - {P: 400 N}
  - cycle: {times: 2, stages: [{Qx: 80 N, bulk_2: {xx: 50 MPa}, increments: 2}, {Qx: -80 N, increments: 2}]}
"""
"""Two cycles of force and bulk stress between unlike bodies, for stresses."""

WORN = f"""\
title: worn
{SPHERE.replace("16", "24")}wear: {{law: energy, alpha: 1e-4 mm^3/J, share: [0.25, 0.75]}}
load_path:
  - {{P: 400 N}}
  - {{Qx: 36 N, increments: 1}}
  - cycle: {{represents: 1e4, jump: 5000, stages: [{{Qx: -36 N, increments: 1}}, {{Qx: 36 N, increments: 1}}]}}
output: {{fields: [pressure, shear, slip, zone, wear_depth, wear_depth_1]}}
"""
"""Partial slip that wears."""

DRAWN_TITLE = "Fretting <mode> $I$ & $\\\\mathbf"


def case_of(load_path: str, *, bodies: str = SIMILAR, points: int = 32, surface: str = "", more: str = "") -> str:
    """Return a case of a sphere of 10 mm, or of another surface."""
    surface = surface or "{sphere: {radius: 10 mm}}"
    head = f"bodies: {bodies}\nsurface: {surface}\ngrid: {{points: {points}}}\nfriction: 0.1\n"
    return f"{head}load_path: [{load_path}]\n{more}"


LONG = "title: long\n" + case_of(
    "{P: 400 N, increments: 10}, {cycle: {times: 2, stages: [{Qx: 20 N, increments: 8}, {Qx: -20 N, increments: 8}]}}",
    bodies=DISSIMILAR,
    points=112,
    more="output: {fields: [pressure, slip, gap], every: 7}\n",
)
"""A case of 42 increments, which take several times the pause between saves and depend on all of a restart's fields."""

DRAWN = {
    "fretting": f'title: "{DRAWN_TITLE}"\n'
    + case_of(
        "{P: 400 N, increments: 3}, {Qx: 36 N, increments: 2},"
        " {cycle: {times: 2, stages: [{Qx: -36 N, increments: 3}, {Qx: 36 N, increments: 3}]}}",
        bodies=DISSIMILAR,
        more="output: {fields: [pressure, shear, slip, work_density, zone, gap]}\n",
    ),
    "mindlin": case_of(
        "{P: 400 N}, {Qx: 36 N, increments: 6}, {Qx: -36 N, increments: 12}, {Qx: 36 N, increments: 12},"
        " {Qx: 10 N, increments: 2}",
        points=48,
        more="coupling: none\noutput: {every: 6}\n",
    ),
    "torsion": f'title: "{DRAWN_TITLE}"\n' + case_of("{P: 400 N}, {Mz: 5 N mm, Qx: 0 N, Qy: 0 N, increments: 3}"),
    "hertz": case_of(
        "{P: 100 N}, {P: 400 N, phi_y: 2e-3 rad}",
        surface="{ellipsoid: {radius_x: 10 mm, radius_y: 20 mm, angle: 30 deg, center: [0.03 mm, 0 mm]}}",
        points=40,
        more="output: {fields: [pressure, zone]}\n",
    ).replace("friction: 0.1\n", ""),
    "sliding": case_of("{P: 400 N}, {Qx: 60 N, increments: 6}", points=24),
}


def write_case(folder: Path, text: str = CASE, name: str = "case.yaml") -> Path:
    """The file of a case."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def case_error(path: Path, overrides: Sequence[str] = ()) -> CaseError:
    """Return the error with which a case is refused."""
    with pytest.raises(CaseError) as caught:
        load_case(path, overrides)
    return caught.value
