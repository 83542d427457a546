"""Draw the pictures of the documents from the shipped cases: docs/pictures/NAME.png.

    python benchmarks/gallery.py                  # all of them, about two minutes on one core
    python benchmarks/gallery.py figure_12 loop   # some
    python benchmarks/gallery.py -o FOLDER

`fretsolve.plots` draws those that show one result; the code here and in `paper_figures` draws those that compare
several runs in one panel.
"""

from __future__ import annotations

import argparse
import io
import re
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import bulk_stress
import numpy as np
from gallery_results import (
    FOLDER,
    FRICTION,
    MODE_1,
    ROOT,
    base_compliances,
    end_of_stage,
    hertz,
    panels,
    shipped,
    solved,
)
from matplotlib.figure import Figure
from paper_figures import PAPER_FIGURES
from PIL import Image

from fretsolve import plots
from fretsolve.plots.canvas import own_style
from fretsolve.plots.labels import CLOSED_FORM, marks, physical_name
from fretsolve.plots.reference import hertz_pressure, shear_form
from fretsolve.reference.tangential import cattaneo_mindlin
from fretsolve.sweep.manifest import read_manifest
from fretsolve.sweep.plot import running_condition_map
from fretsolve.sweep.table import collect

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
    "convergence": convergence,
    "bulk_signs": bulk_stress.signs,
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
    parser.add_argument("names", nargs="*", choices=[*FIGURES, []], metavar="NAME")
    parser.add_argument("-o", "--output", type=Path, default=PICTURES)
    wanted = parser.parse_args(words)
    wanted.output.mkdir(parents=True, exist_ok=True)
    for name in wanted.names or FIGURES:
        with own_style():
            content = compact(FIGURES[name]())
        (wanted.output / f"{name}.png").write_bytes(content)
        print(f"{name}.png: {len(content) / 1000:.0f} kB")


if __name__ == "__main__":
    main(sys.argv[1:])
