"""Compare spheres under bulk stress with certified values and closed forms; draw the signs and the stick zones.

    python benchmarks/bulk_stress.py                             # about 20 s
    python benchmarks/bulk_stress.py --into docs/verification.md

The pictures are drawn by gallery.py. A sphere of 10 mm, P = 400 N, friction 0.1, Q = 24 N along x; tension in body 2.
"""

from __future__ import annotations

import numpy as np
from helpers import parser_of, report
from matplotlib.figure import Figure

from fretsolve import run
from fretsolve.case.keys.body_specs import ElasticBody
from fretsolve.case.line_case import LineCase
from fretsolve.case.models import Case
from fretsolve.post.plots.labels import CLOSED_FORM, marks
from fretsolve.problem.model.materials import compliances
from fretsolve.reference.hertz import HertzLine, hertz_sphere
from fretsolve.reference.line_slip import LinePartialSlip
from fretsolve.reference.tangential import SphereUnderBulk
from fretsolve.result.state import State

BODY = {"young_modulus": 200e3, "poisson_ratio": 0.3}
LOAD, FORCE, FRICTION, RADIUS = 400.0, 24.0, 0.1, 10.0
LINE_LOAD, LINE_FRICTION = 100.0, 0.3
MATCHED = -0.3 / 3.1
"""De_yy over De_xx with which an eccentric circle sticks."""

CERTIFIED = {
    (3.333685e-4, "matched"): (0.1001, 0.7384, 0.50802, 7.87),
    (3.333685e-4, "uniaxial"): (0.0987, 0.7378, 0.50810, 15.1),
    (3.333685e-4, "none across"): (0.1008, 0.7381, 0.50807, 11.1),
    (6.667370e-4, "matched"): (0.2002, 0.7383, 0.52306, 8.49),
    (6.667370e-4, "uniaxial"): (0.1961, 0.7360, 0.52336, 26.3),
    (6.667370e-4, "none across"): (0.2015, 0.7380, 0.52327, 14.8),
}
"""Middle and radius (counted) of the stick zone over a, delta_x (um)
and largest |qy| (MPa) of an independent solve on 80 cells per a."""

RATIOS = {"matched": MATCHED, "uniaxial": -0.3, "none across": 0.0}


def case_of(cells: int, bulk: dict[str, float], coupling: str = "auto") -> Case:
    """Return the case with `cells` cells per contact radius."""
    points = 2 * cells + 2 * max(3, cells // 20)
    path = [{"P": LOAD}, {"Qx": FORCE, "bulk_2": bulk, "increments": 1}]
    parts = {"bodies": [BODY, BODY], "surface": {"sphere": {"radius": RADIUS}}, "friction": FRICTION}
    grid = {"points": points, "size": points * HERTZ.contact_radius / cells}
    return Case.model_validate({**parts, "grid": grid, "coupling": coupling, "load_path": path})


ELASTIC = ElasticBody.model_validate(BODY)
MATERIAL = compliances(ELASTIC, ELASTIC)
HERTZ = hertz_sphere(LOAD, RADIUS, MATERIAL.contact_modulus)


def stresses(mismatch: float, ratio: float) -> dict[str, float]:
    """Return the bulk stress (MPa) that strains a body by `mismatch` along x and `ratio` times that along y."""
    scale = BODY["young_modulus"] / (1.0 - BODY["poisson_ratio"] ** 2) * mismatch
    return {"xx": scale * (1.0 + 0.3 * ratio), "yy": scale * (ratio + 0.3)}


def closed_form(mismatch: float) -> SphereUnderBulk:
    """Return the eccentric circle."""
    return SphereUnderBulk(HERTZ, FRICTION, (MATERIAL.A, MATERIAL.B), FORCE, mismatch)


def last(case: Case) -> State:
    """Return the last state of a case."""
    *_, state = run(case)
    return state


def certified() -> None:
    """Print the comparison with the certified values."""
    a = HERTZ.contact_radius
    print("| De_xx | tension across | bulk stress xx, MPa | middle of the stick zone/a: certified, closed form, found"
          " | its radius/a: certified, closed form, counted, found"
          " | delta_x, um: certified, closed form, found | largest qy, MPa: certified, found |")  # fmt: skip
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for (mismatch, kind), (center, radius, delta_x, across) in CERTIFIED.items():
        bulk, form = stresses(mismatch, RATIOS[kind]), closed_form(mismatch)
        state = last(case_of(80, bulk))
        closed = ("-", "-", "-")
        if kind == "matched":
            closed = f"{form.stick_center / a:.4f}", f"{1e3 * form.delta_x:.5f}", f"{form.stick_radius / a:.4f}"
        found = state.summary
        counted = np.sqrt(found.stick_cells / np.pi) / 80
        middle = f"{center:.4f}, {closed[0]}, {found.stick_center_x / a:.4f}"
        print(
            f"| {mismatch:.6e} | {kind} | {bulk['xx']:.3f} | {middle} |"
            f" {radius:.4f}, {closed[2]}, {counted:.4f}, {found.stick_radius / a:.4f} |"
            f" {delta_x:.5f}, {closed[1]}, {1e3 * found.delta_x:.5f} |"
            f" {across:g}, {np.abs(state.fields.shear[1]).max():.3g} |"
        )


def orders() -> None:
    """Print the errors against the closed form as the grid is refined, without uy from qx."""
    mismatch = 3.333685e-4
    form = closed_form(mismatch)
    print("| cells per radius | delta_x, relative | middle of the stick zone, cells | its half-widths, cells |")
    print("| --- | --- | --- | --- |")
    errors = []
    for cells in (10, 20, 40, 80, 160):
        found, side = last(case_of(cells, stresses(mismatch, 0.0), "none")).summary, HERTZ.contact_radius / cells
        middle = abs(found.stick_center_x - form.stick_center) / side
        widths = [abs(w - form.stick_radius) / side for w in (found.stick_half_width_x, found.stick_half_width_y)]
        errors.append((cells, abs(found.delta_x / form.delta_x - 1.0)))
        print(f"| {cells} | {errors[-1][1]:.1e} | {middle:.1e} | {widths[0]:.1e}, {widths[1]:.1e} |")
    order = -np.polyfit(*np.log(np.array(errors)).T, 1)[0]
    print(f"\nThe observed order of delta_x is {order:.1f}.")


def stick_zone() -> Figure:
    """Draw the ends of the stick zone along x over the bulk stress."""
    figure = Figure(figsize=(5.6, 3.9), layout="constrained")
    axes, a = figure.subplots(), HERTZ.contact_radius
    tension = np.linspace(-600.0, 600.0, 33)
    ratio = stresses(1.0, MATCHED)
    for mark, (label, across) in zip(
        marks(2), {"matched across": ratio["yy"] / ratio["xx"], "uniaxial": 0.0}.items(), strict=True
    ):
        found = [last(case_of(24, {"xx": xx, "yy": across * xx})).summary for xx in tension]
        center = np.array([one.stick_center_x for one in found]) / a
        half = np.array([one.stick_half_width_x for one in found]) / a
        for ends, name in ((center - half, label), (center + half, None)):
            axes.plot(tension, ends, label=name, **mark.options(len(tension)))
    e = closed_form(1e-6).stick_center / a / 1e-6  # per mismatch
    c = closed_form(0.0).stick_radius / a
    mismatch = np.array([-1.0, 1.0]) * (1.0 - c) / e
    for side, name in ((-1.0, "eccentric circle (closed form)"), (1.0, None)):
        axes.plot(mismatch * ratio["xx"], e * mismatch + side * c, label=name, **CLOSED_FORM)
    axes.axhline(1.0, color="0.5", linewidth=0.8)
    axes.axhline(-1.0, color="0.5", linewidth=0.8, label="edge of the contact")
    axes.set(xlabel="bulk stress xx in body 2 (MPa)", ylabel="ends of the stick zone, x/a", ylim=(-1.1, 1.1))
    figure.legend(loc="outside lower center", ncols=2, frameon=False)
    return figure


def line_stick_zone() -> Figure:
    """Draw the ends of the stick zone of a cylinder, in plane strain, over the bulk stress: with a force, and alone."""
    figure = Figure(figsize=(5.6, 3.9), layout="constrained")
    axes, strain = figure.subplots(), (1.0 - BODY["poisson_ratio"] ** 2) / BODY["young_modulus"]
    hertz = HertzLine(LINE_LOAD, RADIUS, MATERIAL.contact_modulus)
    a = hertz.half_width
    tension, closed = np.linspace(-600.0, 600.0, 25), np.linspace(-600.0, 600.0, 201)
    for mark, force in zip(marks(2), (0.6 * LINE_FRICTION * LINE_LOAD, 0.0), strict=True):
        ends = np.array([ends_of_stick_zone(line_case(force, xx)) for xx in tension]) / a
        label = f"Qx = {force:g} N/mm" if force else "bulk stress alone"
        axes.plot(tension, ends, **mark.options(len(tension)), label=label)
        forms = [LinePartialSlip(hertz, LINE_FRICTION, force, MATERIAL.A, strain * xx) for xx in closed]
        axes.plot(closed, np.array([form.stick_zone for form in forms]) / a, **CLOSED_FORM, label="closed forms")
    for side in (-1.0, 1.0):
        axes.axhline(side, color="0.5", linewidth=0.8, label="edge of the contact")
    axes.set(xlabel="bulk stress xx in body 2 (MPa)", ylabel="ends of the stick zone, x/a", ylim=(-1.1, 1.1))
    named = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    figure.legend(named.values(), named.keys(), loc="outside lower center", ncols=2, frameon=False)
    return figure


def line_case(force: float, tension: float) -> LineCase:
    """Return a cylinder under a force (N/mm) and a tension (MPa) of body 2 at once, from full stick."""
    path = [{"P": LINE_LOAD}, {"Qx": force, "bulk_2": {"xx": tension}, "increments": 1}]
    parts = {"plane": "strain", "bodies": [BODY, BODY], "surface": {"cylinder": {"radius": RADIUS}}}
    return LineCase.model_validate({**parts, "friction": LINE_FRICTION, "grid": {"points": 257}, "load_path": path})


def ends_of_stick_zone(case: LineCase) -> tuple[float, float]:
    """Return both ends of the stick zone along x (mm) at the end of the path."""
    found = last(case).summary
    return found.stick_center_x - found.stick_half_width_x, found.stick_center_x + found.stick_half_width_x


def signs() -> Figure:
    """Draw which body is pulled, which way the force acts on it, and where the stick zone goes."""
    figure = Figure(figsize=(6.4, 3.4), layout="constrained")
    axes = figure.subplots()
    axes.axis("off")
    axes.set(xlim=(-3.4, 3.4), ylim=(-1.75, 1.85), aspect="equal")
    turn = np.linspace(np.pi * 1.18, np.pi * 1.82, 60)
    axes.fill(1.9 * np.cos(turn), 1.9 + 1.9 * np.sin(turn), color="0.88")
    axes.fill([-2.5, 2.5, 2.5, -2.5], [0.0, 0.0, -0.95, -0.95], color="0.8")
    axes.plot([-1.0, 1.0], [0.0, 0.0], color="0.35", linewidth=5.0, solid_capstyle="butt")
    axes.plot([-0.45, 0.85], [0.0, 0.0], color="tab:blue", linewidth=5.0, solid_capstyle="butt")
    arrow = {"arrowstyle": "-|>", "color": "black", "linewidth": 1.6}
    pull = arrow | {"color": "tab:red"}
    for start, end, look, text, place in (
        ((0.0, 1.8), (0.0, 1.1), arrow, "P", (0.12, 1.5)),
        ((0.35, 0.75), (1.25, 0.75), arrow, "Qx: body 1 pushes body 2", (1.35, 0.68)),
        ((2.5, -0.5), (3.3, -0.5), pull, "bulk_2 xx > 0", (2.0, -1.3)),
        ((-2.5, -0.5), (-3.3, -0.5), pull, "", (0.0, 0.0)),
        ((-2.9, 0.75), (-2.3, 0.75), arrow, "x", (-2.22, 0.68)),
        ((-2.9, 0.75), (-2.9, 0.15), arrow, "z", (-3.0, -0.1)),
    ):
        axes.annotate("", end, start, arrowprops=look)
        axes.text(*place, text)
    axes.text(0.0, 0.3, "body 1", ha="center")
    axes.text(-1.2, -0.6, "body 2, held and pulled", ha="center")
    axes.annotate("stick zone, shifted towards +x", (0.6, -0.03), (0.05, -1.7), color="tab:blue", ha="center",
                  arrowprops={"arrowstyle": "-", "color": "tab:blue"})  # fmt: skip
    return figure


if __name__ == "__main__":
    report({"bulk": certified, "bulk orders": orders}, parser_of(__doc__).parse_args().into)
