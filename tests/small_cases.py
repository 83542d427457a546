"""Small cases as case files have them; each is solved within a second or two."""

from __future__ import annotations

from pathlib import Path

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

LONG = f"""\
title: long
bodies: {DISSIMILAR}
surface: {{sphere: {{radius: 10 mm}}}}
grid: {{points: 25}}
friction: 0.1
load_path:
  - {{P: 400 N, increments: 10}}
  - cycle: {{times: 2, stages: [{{Qx: 20 N, increments: 8}}, {{Qx: -20 N, increments: 8}}]}}
output: {{fields: [pressure, slip, gap], every: 7}}
"""
"""A case of 42 increments, each some tens of milliseconds long, which depend on all of a restart's fields."""

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

DRAWN_TITLE = "Fretting <mode> $I$ & $\\\\mathbf"

DRAWN = {
    "fretting": f"""\
title: "{DRAWN_TITLE}"
bodies: {DISSIMILAR}
surface: {{sphere: {{radius: 10 mm}}}}
grid: {{points: 32}}
friction: 0.1
load_path:
  - {{P: 400 N, increments: 3}}
  - {{Qx: 36 N, increments: 2}}
  - cycle: {{times: 2, stages: [{{Qx: -36 N, increments: 3}}, {{Qx: 36 N, increments: 3}}]}}
output: {{fields: [pressure, shear, slip, work_density, zone, gap]}}
""",
    "mindlin": f"""\
bodies: {SIMILAR}
surface: {{sphere: {{radius: 10 mm}}}}
grid: {{points: 48}}
friction: 0.1
coupling: none
load_path:
  - {{P: 400 N}}
  - {{Qx: 36 N, increments: 6}}
  - {{Qx: -36 N, increments: 12}}
  - {{Qx: 36 N, increments: 12}}
  - {{Qx: 10 N, increments: 2}}
output: {{every: 6}}
""",
    "torsion": f"""\
title: "{DRAWN_TITLE}"
bodies: {SIMILAR}
surface: {{sphere: {{radius: 10 mm}}}}
grid: {{points: 32}}
friction: 0.1
load_path:
  - {{P: 400 N}}
  - {{Mz: 5 N*mm, Qx: 0 N, Qy: 0 N, increments: 3}}
""",
    "hertz": f"""\
bodies: {SIMILAR}
surface: {{ellipsoid: {{radius_x: 10 mm, radius_y: 20 mm, angle: 30 deg, center: [0.03 mm, 0 mm]}}}}
grid: {{points: 40}}
load_path: [{{P: 100 N}}, {{P: 400 N, phi_y: 2e-3 rad}}]
output: {{fields: [pressure, zone]}}
""",
    "sliding": f"""\
bodies: {SIMILAR}
surface: {{sphere: {{radius: 10 mm}}}}
grid: {{points: 24}}
friction: 0.1
load_path: [{{P: 400 N}}, {{Qx: 60 N, increments: 6}}]
""",
}


def write_case(folder: Path, text: str = CASE, name: str = "case.yaml") -> Path:
    """The file of a case."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path
