"""Draw the pictures of the documents from the shipped cases: docs/pictures/NAME.png.

    python benchmarks/gallery.py                         # all of them, about two minutes on one core
    python benchmarks/gallery.py figure_12 contact_map   # some
    python benchmarks/gallery.py -o FOLDER

`fretsolve.post.plots` draws pictures of one result, the code here pictures that compare several runs in one panel.
Figures with a number are those of Gallego, Nelias & Deyber, Wear 2009, whose numbers they have.
"""

from __future__ import annotations

import argparse
import io
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

import bulk_stress
import fatigue
import numpy as np
import rigs
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image

from fretsolve.post import plots
from fretsolve.post.plots.canvas import own_style
from fretsolve.post.plots.labels import CLOSED_FORM, marks, physical_name
from fretsolve.post.plots.reference import hertz_pressure, shear_form
from fretsolve.problem.model.materials import Compliances, compliances
from fretsolve.reference.hertz import HertzContact, hertz_sphere
from fretsolve.reference.tangential import cattaneo_mindlin, lubkin, spence_stick_ratio
from fretsolve.result import Result, open_result
from fretsolve.sweep.fit.least_squares import fit_loop
from fretsolve.sweep.fit.plan import FitRequest, make_fit_plan
from fretsolve.sweep.fit.plot import fit_picture
from fretsolve.sweep.fit.report import words
from fretsolve.sweep.manifest import read_manifest
from fretsolve.sweep.plot import running_condition_map
from fretsolve.sweep.table import collect
from fretsolve.system.arrays import DoubleArray

ROOT = Path(__file__).resolve().parent.parent
CASES = ROOT / "cases"

LOAD, RADIUS, FRICTION, TORQUE, DUNDURS = 400.0, 10.0, 0.1, 5.0, 0.1938
"""The base case: N, mm, 1, N mm, 1."""

MODE_1 = {"I.1": "mode1_similar_uncoupled", "I.2": "mode1_similar", "I.3": "mode1_dissimilar"}

_folder = tempfile.TemporaryDirectory(prefix="gallery")
FOLDER = Path(_folder.name)
"""Of the results and of cases from pages, removed at the end."""


@cache
def solved(case: Path, *overrides: str) -> Result:
    """Return the result of a case, which is run once."""
    out = FOLDER / f"{solved.cache_info().currsize}.h5"
    sets = [word for override in overrides for word in ("--set", override)]
    subprocess.run([sys.executable, "-m", "fretsolve", "run", case, "-o", out, "-q", *sets], check=True)
    return open_result(out)


def shipped(name: str, *overrides: str) -> Result:
    """Return the result of a shipped case."""
    return solved(CASES / f"{name}.yaml", *overrides)


def end_of_stage(result: Result, stage: int) -> int:
    """Return the last increment of a stage, counted from 1."""
    return int(np.flatnonzero(result.history["stage"] == stage)[-1])


def base_compliances() -> Compliances:
    """Return the compliances of the base case; the dissimilar bodies have the same contact modulus."""
    case = shipped("mode1_similar").case
    assert case is not None
    return compliances(*case.bodies)


def hertz(load: float = LOAD) -> HertzContact:
    """Return Hertz's contact of the base case."""
    return hertz_sphere(load, RADIUS, base_compliances().contact_modulus)


def along_x(result: Result, name: str, step: int) -> tuple[DoubleArray, DoubleArray]:
    """Return x/a and a field, or the length of a vector field, midway between the two middle rows of cells."""
    field = result.field(name, step)
    middle = field.shape[-1] // 2
    row = 0.5 * (field[..., middle - 1] + field[..., middle])
    return result.x / hertz().contact_radius, np.hypot(*row) if row.ndim == 2 else row


def panels(rows: int, columns: int, size: tuple[float, float], **options: bool) -> tuple[Figure, list[Axes]]:
    """Return a figure with its axes."""
    figure = Figure(figsize=(columns * size[0], rows * size[1]), layout="constrained")
    return figure, list(np.ravel(figure.subplots(rows, columns, squeeze=False, **options)))


MODE_3 = {"III.1": "mode3_similar_uncoupled", "III.2": "mode3_similar", "III.3": "mode3_dissimilar"}
MODE_2_FRICTION = (0.01, 0.05, 0.1, 0.15, 0.2, 0.25)


def mode_2(friction: float, increments: int = 10) -> Result:
    """Return mode II with another coefficient of friction."""
    sets = f"friction={friction}", f"load_path.0.increments={increments}", "expect=[]"
    return shipped("mode2_dissimilar", *sets)


def figure_9() -> Figure:
    """Draw the angle of the slip in case I.2 at A."""
    result = shipped(MODE_1["I.2"])
    return plots.slip_angle(result, step=end_of_stage(result, 2))


def figures_10_and_11(name: str) -> Callable[[], Figure]:
    """Draw pressure, shear traction and slip at A and B."""

    def draw() -> Figure:
        result = shipped(MODE_1[name])
        return plots.profiles(result, steps=[end_of_stage(result, stage) for stage in (2, 3)])

    return draw


def figure_12() -> Figure:
    """Draw streamlines of the shear traction at A."""
    return _streamlines(MODE_1)


def figure_13() -> Figure:
    """Draw the fretting loops of mode I, with that of Mindlin."""
    figure, (axes,) = panels(1, 1, (5.6, 4.2))
    _mindlin_loop(axes)
    finer = [f"load_path.{stage}.increments=10" for stage in range(1, 6)]
    for mark, (name, case) in zip(marks(3), MODE_1.items(), strict=True):
        result = shipped(case, "expect=[]", *finer)
        shown = slice(end_of_stage(result, 1), None)
        displacement = 1e3 * result.history["delta_x"][shown]
        axes.plot(displacement, result.history["Qx"][shown], label=name, **mark.options(len(displacement)))
    axes.set(xlabel=r"rigid displacement $\delta_x$ (µm)", ylabel=r"tangential force $Q_x$ (N)")
    axes.legend()
    return figure


def _mindlin_loop(axes: Axes) -> None:
    force = np.linspace(0.0, 36.0, 60)
    contact, compliance = hertz(), base_compliances().tangential
    loading = np.array([cattaneo_mindlin(contact, FRICTION, q, compliance).delta_x for q in force])
    back = np.linspace(36.0, -36.0, 120)
    half = np.array([cattaneo_mindlin(contact, FRICTION, 0.5 * (36.0 - q), compliance).delta_x for q in back])
    unloading = loading[-1] - 2.0 * half
    displacement = np.concatenate([loading, unloading, -unloading])
    label = "Mindlin (closed form)"
    axes.plot(1e3 * displacement, np.concatenate([force, back, -back]), label=label, **CLOSED_FORM)


def figure_14() -> Figure:
    """Draw c/a over P in mode II."""
    figure, (axes,) = panels(1, 1, (5.6, 4.0))
    for mark, friction in zip(marks(len(MODE_2_FRICTION)), MODE_2_FRICTION, strict=True):
        history = mode_2(friction).history
        ratio = history["stick_radius"] / history["contact_radius"]
        axes.axhline(spence_stick_ratio(friction, DUNDURS), **CLOSED_FORM)
        axes.plot(history["P"], ratio, label=f"friction {friction:g}", **mark.options(len(ratio)))
    axes.plot([], [], label="Spence (closed form)", **CLOSED_FORM)
    axes.set(xlabel="normal force $P$ (N)", ylabel="c/a", ylim=(-0.03, 1.05))
    figure.legend(loc="outside right center", frameon=False)
    return figure


def figure_15() -> Figure:
    """Draw c/a over friction in mode II at the last load."""
    figure, (axes,) = panels(1, 1, (4.6, 3.6))
    friction = np.linspace(0.0, 0.26, 100)
    spence = [spence_stick_ratio(value, DUNDURS) for value in friction]
    axes.plot(friction, spence, label="Spence (closed form)", **CLOSED_FORM)
    for mark, increments in zip(marks(2), (10, 40), strict=True):
        found = [_final_ratio(mode_2(value, increments)) for value in MODE_2_FRICTION]
        axes.plot(MODE_2_FRICTION, found, label=f"{increments} increments", **mark.options(len(found)))
    axes.set(xlabel="coefficient of friction", ylabel="c/a")
    axes.legend()
    return figure


def _final_ratio(result: Result) -> float:
    return float(result.history["stick_radius"][-1] / result.history["contact_radius"][-1])


def figure_16() -> Figure:
    """Draw pressure and shear traction of mode II at the last load, and the largest pressure over friction."""
    figure, (profile, largest) = panels(1, 2, (4.8, 3.8))
    p0 = hertz().max_pressure
    for mark, friction in zip(marks(len(MODE_2_FRICTION)), MODE_2_FRICTION, strict=True):
        result = mode_2(friction)
        step = result.increments - 1
        for name, scale in (("pressure", p0), ("shear", friction * p0)):
            x, values = along_x(result, name, step)
            options = mark.options(len(x)) | {"linestyle": "--"} if name == "shear" else {"color": mark.color}
            label = f"friction {friction:g}" if name == "shear" else None
            profile.plot(x, values / scale, label=label, linewidth=1.0, **options)
    profile.set(xlabel="x/a", ylabel="p/p0, and dashed with markers |q|/μ p0", xlim=(-1.05, 1.05))
    figure.legend(loc="outside right center", frameon=False)
    ratio = [mode_2(friction).history["max_pressure"][-1] / p0 for friction in MODE_2_FRICTION]
    largest.plot(MODE_2_FRICTION, ratio, **marks(1)[0].options(len(ratio)))
    largest.set(xlabel="coefficient of friction", ylabel="largest pressure over Hertz's p0")
    return figure


def figure_17() -> Figure:
    """Draw the shear traction of mode II pressed in one, ten and forty increments."""
    figure, (axes,) = panels(1, 1, (5.8, 3.8))
    for mark, increments in zip(marks(3), (1, 10, 40), strict=True):
        result = mode_2(FRICTION, increments)
        x, shear = along_x(result, "shear", result.increments - 1)
        label = f"{increments} increment{'s' if increments > 1 else ''}"
        axes.plot(x, shear / (FRICTION * hertz().max_pressure), label=label, **mark.options(len(x)))
    axes.set(xlabel="x/a", ylabel="|q|/μ p0", xlim=(-1.05, 1.05))
    figure.legend(loc="outside right center", frameon=False)
    return figure


def figure_18() -> Figure:
    """Draw pressure and shear traction of mode II as the load rises."""
    figure, axes = panels(2, 3, (3.3, 2.5), sharex=True)
    p0 = hertz().max_pressure
    for column, friction in enumerate((0.01, 0.1, 0.25)):
        result = mode_2(friction)
        for mark, step in zip(marks(result.increments), range(result.increments), strict=True):
            for row, (name, scale) in enumerate((("pressure", p0), ("shear", friction * p0))):
                x, values = along_x(result, name, step)
                panel = axes[3 * row + column]
                panel.plot(x, values / scale, color=mark.color, linewidth=1.0, label=f"{result.history['P'][step]:g} N")
        axes[column].set_title(f"friction {friction:g}")
        axes[3 + column].set_xlabel("x/a")
    for step, away in ((0, -9.0), (-1, 2.0)):  # the curves between are in the order of the loads
        load, peak = result.history["P"][step], result.history["max_pressure"][step] / p0
        axes[2].annotate(f"{load:g} N", (0.0, peak), (0.0, away), textcoords="offset points", ha="center", fontsize=6.5)
    axes[2].margins(y=0.12)
    axes[0].set(ylabel="p/p0", xlim=(-1.05, 1.05))
    axes[3].set_ylabel("|q|/μ p0")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right center", frameon=False, title="P")
    return figure


def figure_19() -> Figure:
    """Draw streamlines of mode II."""
    return plots.streamlines(mode_2(FRICTION))


def figure_20() -> Figure:
    """Draw the shear traction of mode III along x."""
    figure, (axes,) = panels(1, 1, (6.2, 3.8))
    contact = hertz()
    scale = FRICTION * contact.max_pressure
    form = lubkin(contact, FRICTION, TORQUE, base_compliances().torsional)
    x = np.linspace(-1.0, 1.0, 401)
    shear = np.abs(form.shear(np.abs(x) * contact.contact_radius)) / scale
    axes.plot(x, shear, label="Lubkin (closed form)", **CLOSED_FORM)
    for mark, (name, case) in zip(marks(3), MODE_3.items(), strict=True):
        result = shipped(case)
        at, found = along_x(result, "shear", result.increments - 1)
        axes.plot(at, found / scale, label=name, **mark.options(len(at)))
    axes.set(xlabel="x/a", ylabel="|q|/μ p0", xlim=(-1.05, 1.05))
    figure.legend(loc="outside right center", frameon=False)
    return figure


def figure_21() -> Figure:
    """Draw the radial share of the shear traction in mode III between equal bodies."""
    figure, axes = panels(1, 2, (3.6, 3.1))
    for panel, name in zip(axes, ("III.1", "III.2"), strict=True):
        result = shipped(MODE_3[name])
        shear = result.field("shear")
        x, y = np.meshgrid(result.x, result.y, indexing="ij")
        length = np.hypot(x, y) * np.hypot(*shear)
        touching = result.field("pressure") > 0.0
        share = np.divide(x * shear[0] + y * shear[1], length, out=np.full_like(x, np.nan), where=touching)
        edges = np.array([result.x[0], result.x[-1], result.y[0], result.y[-1]]) / hertz().contact_radius
        image = panel.imshow(share.T, origin="lower", extent=tuple(edges), cmap="RdBu_r", vmin=-0.05, vmax=0.05)
        panel.set(xlabel="x/a", ylabel="y/a", title=f"{name}: at most {np.nanmax(np.abs(share)):.2g}")
        panel.grid(False)
    figure.colorbar(image, ax=axes, label="radial part of the shear traction")
    return figure


def figure_22() -> Figure:
    """Draw streamlines of the shear traction of mode III."""
    return _streamlines(MODE_3)


def _streamlines(cases: dict[str, str]) -> Figure:
    figure, axes = panels(1, len(cases), (3.9, 3.4))
    for panel, (name, case) in zip(axes, cases.items(), strict=True):
        result = shipped(case)
        plots.streamlines(result, panel, step=end_of_stage(result, 2))
        panel.set_title(f"{name}: shear traction (MPa)")
        handles = panel.get_legend().legend_handles
        panel.get_legend().remove()
    figure.legend(handles=handles, loc="outside lower center", ncols=2, frameon=False)
    return figure


PAPER_FIGURES: dict[str, Callable[[], Figure]] = {
    "figure_09": figure_9,
    "figure_10_11_I1": figures_10_and_11("I.1"),
    "figure_10_11_I2": figures_10_and_11("I.2"),
    "figure_10_11_I3": figures_10_and_11("I.3"),
    "figure_12": figure_12,
    "figure_13": figure_13,
    "figure_14": figure_14,
    "figure_15": figure_15,
    "figure_16": figure_16,
    "figure_17": figure_17,
    "figure_18": figure_18,
    "figure_19": figure_19,
    "figure_20": figure_20,
    "figure_21": figure_21,
    "figure_22": figure_22,
}


PICTURES = ROOT / "docs" / "pictures"

DPI, COLORS, FEWEST_COLORS = 200, 256, 32
MOST_BYTES = 250_000


def yaml_of(page: str, name: str) -> str:
    """Return the YAML of a how-to page that begins with the name of its file."""
    text = (ROOT / "docs" / "howto" / f"{page}.md").read_text()
    found = re.search(rf"```yaml\n(# {name}.yaml\n.*?)```", text, re.DOTALL)
    assert found is not None
    return found[1]


def tutorial() -> Figure:
    """Draw the loop of the tutorial's case."""
    case = FOLDER / "mode1.yaml"
    case.write_text(yaml_of("tutorial", "mode1"))
    return plots.loop(solved(case))


def fitted_loop() -> Figure:
    """Draw the measured loop of the page on rigs, with the fitted loop."""
    case, page = FOLDER / "rig.yaml", (ROOT / "docs" / "howto" / "rig.md").read_text()
    case.write_text(yaml_of("rig", "rig"))
    script = re.search(r"```python\n(.*?)```", page, re.DOTALL)
    assert script is not None
    subprocess.run([sys.executable, "-m", "fretsolve", "run", case.name, "-q"], check=True, cwd=FOLDER)
    subprocess.run([sys.executable, "-c", script[1]], check=True, cwd=FOLDER)
    guesses = ("friction=0.14", "rig.stiffness_x=80 kN/mm")
    request = FitRequest(case, guesses, FOLDER / "measured.csv", ("friction", "rig.stiffness_x"))
    fit = fit_loop(make_fit_plan(request))
    detail = ", ".join(words(fit, place) for place in range(2))
    return fit_picture(fit, "a measured loop, and the loop that was fitted", detail)


def running_condition() -> Figure:
    """Draw the running-condition map of the page on sweeps, with 12 values on each axis."""
    for name in ("sphere", "conditions"):
        (FOLDER / f"{name}.yaml").write_text(yaml_of("sweeps", name).replace("count: 6", "count: 12"))
    command = [sys.executable, "-m", "fretsolve", "sweep", "run", "conditions.yaml", "-q"]
    subprocess.run(command, check=True, cwd=FOLDER)
    table = collect(read_manifest(FOLDER / "conditions.sweep"))
    return running_condition_map(table, [setting.name for setting in table.settings][:2])


def contact_map() -> Figure:
    """Draw mode I between dissimilar bodies at A."""
    result = shipped(MODE_1["I.3"])
    return plots.contact_map(result, step=end_of_stage(result, 2))


def wear(case: str) -> Callable[[], Figure]:
    """Draw the scar of a shipped case over its cycles."""
    return lambda: plots.wear(shipped(case))


def stress_map() -> Figure:
    """Draw the stresses of case I.2 at A."""
    result = shipped(MODE_1["I.2"])
    return plots.stress_map(result, step=end_of_stage(result, 2))


def fatigue_map() -> Figure:
    """Draw where cracks may begin in the loop of docs/howto/crack_initiation.md."""
    titanium = "{young_modulus: 116 GPa, poisson_ratio: 0.34}"
    forward, back = (f"{{Qx: {q} N/mm, bulk_2: {{xx: {5 * q} MPa}}, increments: 20}}" for q in (20, -20))
    result = shipped(
        "line_fatigue",
        "title=Crack initiation",
        f"bodies=[{titanium}, {titanium}]",
        "grid={points: 256, size: 0.6 mm}",
        "friction=0.4",
        f"load_path=[{{P: 100 N/mm}}, {forward}, {{cycle: {{times: 2, stages: [{back}, {forward}]}}}}]",
        "expect=[]",
        "output.fatigue={material: materials/ti-6al-4v.yaml, criteria: [findley, swt]}",
    )
    return plots.fatigue_map(result)


def stick_history() -> Figure:
    return plots.stick_history(shipped(MODE_1["I.1"]))


def convergence() -> Figure:
    """Draw the errors of case I.1 at A against closed forms as the grid is refined."""
    figure, (axes,) = panels(1, 1, (6.6, 4.0))
    contact = hertz()
    form = cattaneo_mindlin(contact, FRICTION, 36.0, base_compliances().tangential)
    truths = {
        "delta_z": contact.delta_z,
        "max_pressure": contact.max_pressure,
        "contact_radius": contact.contact_radius,
        "delta_x": form.delta_x,
        "stick_radius": form.stick_radius,
    }
    points = (24, 32, 48, 64, 96, 128, 192, 256, 384, 512)
    load_path = "load_path=[{P: 400 N}, {Qx: 36 N, increments: 1}]"
    runs = [shipped(MODE_1["I.1"], f"grid.points={count}", load_path, "expect=[]") for count in points]
    cells = np.array([2.0 * contact.contact_radius / (run.x[1] - run.x[0]) for run in runs])
    for mark, (name, truth) in zip(marks(len(truths)), truths.items(), strict=True):
        error = np.abs([run.history[name][-1] / truth - 1.0 for run in runs])
        axes.loglog(cells, 100.0 * error, label=physical_name(name), **mark.options(len(cells)))
    axes.loglog(cells, 0.5 * (20.0 / cells) ** 1.5, label="power -1.5", **CLOSED_FORM)
    axes.set(xlabel="cells across the contact", ylabel="error (%)")
    axes.set_xticks([20, 50, 100, 200, 400], ["20", "50", "100", "200", "400"])
    axes.minorticks_off()
    figure.legend(loc="outside right center", frameon=False)
    return figure


def line_shear() -> Figure:
    """Draw pressure and shear traction of the line contacts in partial slip with their closed forms."""
    figure, axes = panels(1, 3, (3.7, 3.3))
    for panel, name in zip(axes, ("line_cylinder", "line_fatigue", "line_punch"), strict=True):
        result = shipped(name)
        step, case = end_of_stage(result, 2), result.case
        assert case is not None
        pressure, shear = hertz_pressure(result, step), shear_form(result, step)
        assert pressure is not None and shear is not None
        limit = case.friction.coefficient
        x = np.linspace(result.x[0], result.x[-1], 2001)
        for values in (limit * pressure.at(x, np.zeros_like(x)), shear.at(x, np.zeros_like(x))[0]):
            panel.plot(x, values, label="closed forms", **CLOSED_FORM)
        found = (limit * result.field("pressure", step)[:, 0], result.field("shear_x", step)[:, 0])
        for mark, values, label in zip(marks(2), found, ("friction limit μp", "shear traction q"), strict=True):
            panel.plot(result.x, values, label=label, **mark.options(len(values)))
        panel.set(xlabel="x (mm)", ylabel="MPa", title=case.title.partition(", ")[2] if case.title else "")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles[1:], labels[1:], loc="outside lower center", ncols=3, frameon=False)
    return figure


FIGURES: dict[str, Callable[[], Figure]] = {
    "tutorial_loop": tutorial,
    "contact_map": contact_map,
    "stick_history": stick_history,
    "running_condition": running_condition,
    "stress_map": stress_map,
    "wear_partial_slip": wear("wear_partial_slip"),
    "wear_gross_slip": wear("wear_gross_slip"),
    "fatigue_map": fatigue_map,
    "size_effect": fatigue.size_effect,
    "convergence": convergence,
    "bulk_signs": bulk_stress.signs,
    "fitted_loop": fitted_loop,
    "rig_motions": rigs.motions,
    "bulk_stick_zone": bulk_stress.stick_zone,
    "line_stick_zone": bulk_stress.line_stick_zone,
    "line_shear": line_shear,
    **PAPER_FIGURES,
}


def compact(figure: Figure) -> bytes:
    """Return the picture as a PNG of few colours."""
    whole = io.BytesIO()
    figure.savefig(whole, format="png", dpi=DPI, facecolor="white")
    image = Image.open(whole).convert("RGB")
    colors = COLORS
    while True:
        small = io.BytesIO()
        image.quantize(colors, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(small, "png", optimize=True)
        if small.tell() < MOST_BYTES or colors <= FEWEST_COLORS:
            return small.getvalue()
        colors //= 2


def main(words: Sequence[str]) -> None:
    """Draw the pictures that are named, or all."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(FIGURES))
    parser.add_argument("-o", "--output", type=Path, default=PICTURES)
    wanted = parser.parse_args(words)
    unknown = [name for name in wanted.names if name not in FIGURES]
    if unknown:
        parser.error(f"no such picture: {', '.join(unknown)}; there are {', '.join(FIGURES)}")
    wanted.output.mkdir(parents=True, exist_ok=True)
    for name in wanted.names or FIGURES:
        with own_style():
            content = compact(FIGURES[name]())
        (wanted.output / f"{name}.png").write_bytes(content)
        print(f"{name}.png: {len(content) / 1000:.0f} kB")


if __name__ == "__main__":
    main(sys.argv[1:])
