"""Compare rigs, layers and lines driven by displacement with certified values; draw what moves against what.

    python benchmarks/rigs.py                             # about 20 s
    python benchmarks/rigs.py --into docs/verification.md

The picture is drawn by gallery.py. Certified values come from an independent solver.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from helpers import parser_of, report
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle

from fretsolve import case_from_dict, run
from fretsolve.result.state import Summary

BODY = {"young_modulus": 200e3, "poisson_ratio": 0.3}
SPHERE: dict[str, Any] = {
    "bodies": [BODY, BODY], "surface": {"sphere": {"radius": 10.0}}, "friction": 0.1, "coupling": "none"
}  # fmt: skip
ON_RIG = {**SPHERE, "rig": {"stiffness_x": 50e3}}
LIMIT = 40.0
"""mu P of the sphere (N)."""

SOFT = {"young_modulus": 200e3, "poisson_ratio": 0.0}
MODULUS = 100e3
"""2/(1/G1 + 1/G2) of two bodies without Poisson's ratio (MPa)."""

LAYERS = {
    0.0: ((0.5812566, 0.793701), (1.2323785, 0.464159)),
    0.5: ((0.757686, 0.88396), (1.587442, 0.57548)),
    1.0: ((0.932632, 0.90423), (1.948503, 0.60871)),
}
"""By L E'/a: motion delta_x E'/(mu p0 a) and stick radius over a, at 0.5 and 0.9 mu P."""

LINE_BODY = {"young_modulus": 210e3, "poisson_ratio": 0.3}
LINE: dict[str, Any] = {
    "plane": "strain", "bodies": [LINE_BODY, LINE_BODY], "surface": {"cylinder": {"radius": 10.0}},
    "friction": 0.5, "reference_depth": 10.0,
}  # fmt: skip
LINE_MOTIONS = {0.2: 0.3319849, 0.5: 0.8437161, 0.9: 1.5729763}
"""delta_x (um) by Qx over mu P."""

GRIDS = (32, 64, 128)


def ends(case: Mapping[str, Any], path: list[dict[str, Any]], points: int, **grid: float) -> Iterator[Summary]:
    """Yield the history at the end of each stage."""
    whole = {**case, "grid": {"points": points, **grid}, "load_path": path, "output": {"fields": ["pressure"]}}
    found = [state.summary for state in run(case_from_dict(whole))]
    yield from (
        one for one, after in zip(found, [*found[1:], None], strict=True) if not after or after.stage != one.stage
    )


def rigs() -> None:
    """Print the comparison of a sphere on a rig."""
    turned = 1.2e-3 - 1e-5  # so small a part of the loop after the reversal that nearly all sticks
    path = [{"P": 400.0}, {"actuator_x": 1.2e-3, "increments": 10}, {"Qx": 36.0, "increments": 5}]
    slid = [{"P": 400.0}, {"actuator_x": 1.2e-3, "increments": 10}, {"actuator_x": turned, "increments": 1}]
    print("| | certified |" + "".join(f" {points} points |" for points in GRIDS))
    print("| --- | --- |" + " --- |" * len(GRIDS))
    rows: dict[str, list[float]] = {name: [] for name in _RIG}
    for points in GRIDS:
        _, driven, forced = ends(ON_RIG, path, points)
        _, before, after = ends(ON_RIG, slid, points)
        fallen = after.Qx - before.Qx
        values = (
            driven.Qx,
            1e3 * forced.actuator_x,
            fallen / (after.actuator_x - before.actuator_x),
            fallen / (after.delta_x - before.delta_x),
        )
        for row, value in zip(rows.values(), values, strict=True):
            row.append(value)
    for (name, certified), found in zip(_RIG.items(), rows.values(), strict=True):
        print(f"| {name} | {certified:.7g} |" + "".join(f" {value:.7g} |" for value in found))


_RIG = {
    "Qx at actuator_x = 1.2 um, N": 28.68037,
    "actuator_x at 36 N, um": 1.583748,
    "slope after a reversal at the actuator, N/mm": 26076.33,
    "slope after a reversal at the contact, N/mm": 54499.01,
}


def layers() -> None:
    """Print the comparison of spheres with a layer."""
    print("| L E'/a | Q over mu P | delta_x E'/(mu p0 a): certified |" + "".join(f" {n} points |" for n in GRIDS)
          + " stick radius over a: certified |" + "".join(f" {n} points |" for n in GRIDS))  # fmt: skip
    print("| --- | --- | --- |" + " --- |" * (2 * len(GRIDS) + 1))
    a = (0.75 * 400.0 * 10.0 / 100e3) ** (1.0 / 3.0)
    unit = 0.1 * 1.5 * 400.0 / (np.pi * a**2) * a / MODULUS
    for ratio, pairs in LAYERS.items():
        case = {**SPHERE, "bodies": [SOFT, SOFT]}
        if ratio:
            case["interface"] = {"shear_compliance": ratio * a / MODULUS}
        path = [{"P": 400.0}, {"Qx": 0.5 * LIMIT, "increments": 1}, {"Qx": 0.9 * LIMIT, "increments": 1}]
        found = [list(ends(case, path, points))[1:] for points in GRIDS]
        for number, (part, (motion, radius)) in enumerate(zip((0.5, 0.9), pairs, strict=True)):
            motions = "".join(f" {one[number].delta_x / unit:.6f} |" for one in found)
            radii = "".join(f" {one[number].stick_radius / a:.5f} |" for one in found)
            print(f"| {ratio:g} | {part} | {motion:.7g} |{motions} {radius:.6g} |{radii}")


def lines() -> None:
    """Print the comparison of a line contact with a reference depth."""
    print("| Qx over mu P | delta_x, um: certified |" + "".join(f" {points} points |" for points in GRIDS))
    print("| --- | --- |" + " --- |" * len(GRIDS))
    path = [{"P": 100.0}, *({"Qx": 50.0 * part, "increments": 1} for part in LINE_MOTIONS)]
    found = [list(ends(LINE, path, points))[1:] for points in GRIDS]
    for number, (part, certified) in enumerate(LINE_MOTIONS.items()):
        print(f"| {part} | {certified:.7g} |" + "".join(f" {1e3 * one[number].delta_x:.7g} |" for one in found))


def motions() -> Figure:
    """Draw actuator, rig, bodies and layer, and what moves against what."""
    figure = Figure(figsize=(6.8, 3.2), layout="constrained")
    axes = figure.subplots()
    axes.axis("off")
    axes.set(xlim=(-5.8, 5.0), ylim=(-2.35, 3.1), aspect="equal")
    axes.add_patch(Rectangle((-2.9, -1.7), 5.8, 1.6, color="0.8"))
    axes.add_patch(Rectangle((-0.55, -0.1), 1.1, 0.1, color="tab:orange"))
    axes.add_patch(Circle((0.0, 1.15), 1.15, color="0.88"))
    axes.add_patch(Rectangle((-5.6, 0.9), 0.7, 0.9, color="0.55"))
    _spring(axes, -4.9, -1.1, 1.35)
    arrow = {"arrowstyle": "-|>", "color": "black", "linewidth": 1.6}
    for start, end, text, place in (
        ((-5.25, 2.05), (-4.35, 2.05), "D = actuator_x", (-4.25, 1.97)),
        ((0.0, 1.35), (1.5, 1.35), "delta_x", (1.6, 1.27)),
        ((0.0, 3.05), (0.0, 2.35), "P", (0.15, 2.7)),
        ((-1.9, 0.35), (-0.9, 0.35), "Qx = k (D - delta_x)", (-4.6, 0.27)),
    ):
        axes.annotate("", end, start, arrowprops=arrow)
        axes.text(*place, text)
    axes.text(-3.0, 0.85, "rig: k", ha="center")
    axes.text(0.0, 0.6, "body 1", ha="center")
    axes.text(0.0, -1.1, "body 2, held", ha="center")
    axes.annotate("layer: shears by L q", (0.5, -0.05), (1.3, 0.35), color="tab:orange",
                  arrowprops={"arrowstyle": "-", "color": "tab:orange"})  # fmt: skip
    axes.text(-2.9, -2.2, "delta_x: far parts of body 1 against far parts of body 2", color="0.3")
    return figure


def _spring(axes: Axes, first: float, last: float, height: float) -> None:
    turns = np.linspace(first + 0.4, last - 0.4, 13)
    sides = height + 0.16 * np.array([0.0, *([1.0, -1.0] * 6)][:13])
    axes.plot([first, *turns, last], [height, *sides, height], color="0.3", linewidth=1.4)


if __name__ == "__main__":
    report({"rig": rigs, "layer": layers, "line motions": lines}, parser_of(__doc__).parse_args().into)
