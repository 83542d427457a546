"""Regenerate the figures of the documents: certified values reached, residuals of the shipped cases, cost.

    python benchmarks/figures.py              # everything, about half an hour on one core
    python benchmarks/figures.py certified    # or one of: run, certified, steps, residuals, performance ...
    python benchmarks/figures.py --into README.md docs/verification.md docs/performance.md

Prints Markdown, or puts it between the marks ``<!-- figures: NAME -->`` and ``<!-- end of figures -->`` of a file.
References: closed forms (`closed_forms`) with the deviations of an independent, certified solve on 256 x 256
cells, ten increments per stage where pressure and shear act on each other. Deviations of the dissimilar bodies are
from the closed forms of the similar ones, which have the same contact modulus.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import bench_path
import compare_programs
import increments
import lines
import numpy as np
import precision
from helpers import printed, put_parts_into

import fretsolve
from fretsolve.cli.commands.check import cases_at, check_case
from fretsolve.reference.hertz import HertzContact, hertz_sphere
from fretsolve.reference.tangential import CattaneoMindlin, LubkinContact, cattaneo_mindlin, lubkin, spence_stick_ratio
from fretsolve.result.state import State
from fretsolve.simulation.problem_setup import set_up

CASES = Path(__file__).resolve().parent.parent / "cases"
CLOSED = "closed form"


@dataclass(frozen=True)
class Row:
    """A certified value and where it is found: the last state of a stage."""

    case: str
    quantity: str
    stage: int
    certified: float
    found: Callable[[State], float]
    reference: str = "other program"


def attribute(name: str) -> Callable[[State], float]:
    """Return a function that reads the history's scalar of that name."""
    return lambda state: float(getattr(state.summary, name))


def central_shear(state: State) -> float:
    """Return the mean |shear| of the four cells about the centre."""
    shear = np.hypot(*state.fields.shear)
    nx, ny = shear.shape
    return float(shear[nx // 2 - 1 : nx // 2 + 1, ny // 2 - 1 : ny // 2 + 1].mean())


def ratio_to_contact(state: State) -> float:
    """Return the stick radius over the contact radius."""
    return state.summary.stick_radius / state.summary.contact_radius


def base_forms() -> tuple[HertzContact, CattaneoMindlin, LubkinContact]:
    """Return the closed forms of the base case: pressed, sheared or twisted."""
    material = set_up(fretsolve.load_case(CASES / "mode1_similar.yaml")).model.compliances
    hertz = hertz_sphere(400.0, 10.0, material.contact_modulus)
    mindlin = cattaneo_mindlin(hertz, 0.1, 36.0, material.tangential)
    return hertz, mindlin, lubkin(hertz, 0.1, 5.0, material.torsional)


def certified_rows() -> list[Row]:
    """Return the certified values, from closed forms and deviations."""
    hertz, mindlin, torsion = base_forms()
    p0, dz, a = hertz.max_pressure, hertz.delta_z, hertz.contact_radius
    return [
        Row("mode1_similar", "delta_z, mm", 1, dz, attribute("delta_z"), CLOSED),
        Row("mode1_similar", "p0, MPa", 1, p0, attribute("max_pressure"), CLOSED),
        Row("mode1_similar", "a, mm", 1, a, attribute("contact_radius"), CLOSED),
        Row("mode1_similar", "c at A, mm", 2, mindlin.stick_radius, attribute("stick_radius"), CLOSED),
        Row("mode1_similar", "shear traction at the centre at A, MPa", 2, 1.0013 * mindlin.center_shear, central_shear),
        Row("mode1_similar", "delta_x at A, mm", 2, (1 - 0.00084) * mindlin.delta_x, attribute("delta_x")),
        Row("mode1_similar", "dissipated energy A to E, mJ", 6, 1.40881e-2, attribute("work_total")),
        Row("mode1_dissimilar", "p0 at A, MPa", 2, 1.0167 * p0, attribute("max_pressure")),
        Row("mode1_dissimilar", "delta_z at A, mm", 2, (1 - 0.00057) * dz, attribute("delta_z")),
        Row("mode1_dissimilar", "delta_x at A, mm", 2, 1.2091 * mindlin.delta_x, attribute("delta_x")),
        Row("mode1_dissimilar", "c at A, mm", 2, 0.0675, attribute("stick_radius")),
        Row("mode1_dissimilar", "c at B, mm", 3, 0.2459, attribute("stick_radius")),
        Row("mode1_dissimilar", "c at E, mm", 6, 0.1300, attribute("stick_radius")),
        Row("mode1_dissimilar", "delta_x at B, mm", 3, 0.345111e-3, attribute("delta_x")),
        Row("mode1_dissimilar", "delta_x at C, mm", 4, -0.685202e-3, attribute("delta_x")),
        Row("mode1_dissimilar", "delta_x at D, mm", 5, 0.013253e-3, attribute("delta_x")),
        Row("mode1_dissimilar", "delta_x at E, mm", 6, 0.986285e-3, attribute("delta_x")),
        Row("mode2_dissimilar", "c/a", 1, 0.487, ratio_to_contact),
        Row("mode2_dissimilar", "p0, MPa", 1, 1.0369 * p0, attribute("max_pressure")),
        Row("mode3_similar", "c, mm", 2, 1.0013 * torsion.stick_radius, attribute("stick_radius")),
        Row("mode3_similar", "phi_z, rad", 2, (1 - 0.00022) * 1.45053e-3, attribute("phi_z")),
        Row("mode3_dissimilar", "p0, MPa", 2, 1.0379 * p0, attribute("max_pressure")),
        Row("mode3_dissimilar", "c, mm", 2, (1 - 0.636) * torsion.stick_radius, attribute("stick_radius")),
        Row("mode3_dissimilar", "delta_z, mm", 2, (1 - 0.00160) * dz, attribute("delta_z")),
        Row("mode3_dissimilar", "phi_z, rad", 2, 1.179 * torsion.phi_z, attribute("phi_z")),
    ]


@dataclass(frozen=True)
class PaperRow:
    """A value of the paper and of the independent solve, as deviations from a closed form, and where to find it."""

    case: str
    quantity: str
    stage: int
    closed_form: float
    paper: str
    certified: str
    found: Callable[[State], float]


def paper_rows() -> list[PaperRow]:
    """Return the tables 1 and 2 of the paper and its figure 15; "-" where no certified value is known."""
    hertz, mindlin, torsion = base_forms()
    dissimilar = set_up(fretsolve.load_case(CASES / "mode2_dissimilar.yaml")).model.compliances
    spence = spence_stick_ratio(0.1, dissimilar.dundurs_constant)
    p0, dz, a, c, dx = (hertz.max_pressure, hertz.delta_z, hertz.contact_radius, mindlin.stick_radius, mindlin.delta_x)
    stick, turn, pressure = attribute("stick_radius"), attribute("phi_z"), attribute("max_pressure")
    plain, equal, unlike = "mode1_similar_uncoupled", "mode1_similar", "mode1_dissimilar"
    return [
        PaperRow(plain, "a", 1, a, "+0.75", "+0.06", attribute("contact_radius")),
        PaperRow(plain, "p0", 1, p0, "+0.001", "-", pressure),
        PaperRow(plain, "delta_z", 1, dz, "0.006", "-", attribute("delta_z")),
        PaperRow(plain, "c at A", 2, c, "0.61", "-", stick),
        PaperRow(plain, "delta_x at A", 2, dx, "+0.012", "-", attribute("delta_x")),
        PaperRow(equal, "c at A", 2, c, "+10.62", "+0.0", stick),
        PaperRow(equal, "shear traction at the centre at A", 2, mindlin.center_shear, "0.485", "+0.13", central_shear),
        PaperRow(equal, "delta_x at A", 2, dx, "0.116", "-0.084", attribute("delta_x")),
        PaperRow(unlike, "p0 at A", 2, p0, "+1.461", "+1.67", pressure),
        PaperRow(unlike, "delta_z at A", 2, dz, "0.061", "-0.057", attribute("delta_z")),
        PaperRow(unlike, "delta_x at A", 2, dx, "+19.6", "+20.91", attribute("delta_x")),
        PaperRow("mode2_dissimilar", "c/a", 1, spence, "-", "-4.5", ratio_to_contact),
        PaperRow("mode2_dissimilar", "p0", 1, p0, "up to 4", "+3.69", pressure),
        PaperRow("mode3_similar_uncoupled", "phi_z", 2, torsion.phi_z, "7.471", "-", turn),
        PaperRow("mode3_similar", "c", 2, torsion.stick_radius, "+1.232", "+0.13", stick),
        PaperRow("mode3_similar", "phi_z", 2, torsion.phi_z, "0.043", "-0.022", turn),
        PaperRow("mode3_dissimilar", "p0", 2, p0, "+3.209", "+3.79", pressure),
        PaperRow("mode3_dissimilar", "c", 2, torsion.stick_radius, "59.70", "-63.6", stick),
        PaperRow("mode3_dissimilar", "delta_z", 2, dz, "0.160", "-0.160", attribute("delta_z")),
        PaperRow("mode3_dissimilar", "phi_z", 2, torsion.phi_z, "78.31", "+17.9", turn),
    ]


@cache
def stage_ends(case: str) -> dict[int, State]:
    """Return the last state of each stage on 128 x 128 cells."""
    loaded = fretsolve.load_case(CASES / f"{case}.yaml", ["grid.points=128"])
    return {state.summary.stage: state for state in fretsolve.run(loaded)}


def print_certified() -> None:
    """Print certified values against those found on 128 x 128 cells."""
    rows = certified_rows()
    ends = {case: stage_ends(case) for case in dict.fromkeys(row.case for row in rows)}
    cell = set_up(fretsolve.load_case(CASES / "mode1_similar.yaml", ["grid.points=128"])).grid.dx
    print(f"128 x 128 cells; a cell is {cell:.4f} mm.\n")
    print("| case | quantity | reference | certified | found | deviation, % |")
    print("| --- | --- | --- | --- | --- | --- |")
    for row in rows:
        found = row.found(ends[row.case][row.stage])
        if row.quantity.startswith("dissipated"):  # the path begins with the rise to A, which is not part of the cycle
            found -= row.found(ends[row.case][2])
        deviation = f"{100 * (found / row.certified - 1):+.3f}"
        if row.quantity[:2] in ("a,", "c ", "c,"):
            deviation += f" ({(found - row.certified) / cell:+.2f} cells)"
        print(f"| {row.case} | {row.quantity} | {row.reference} | {row.certified:.6g} | {found:.6g} | {deviation} |")


def print_published() -> None:
    """Print the values of ``cases/external``, of each the kind of its reference and its source, and what is found."""
    print("| case | quantity | reference | published | found |")
    print("| --- | --- | --- | --- | --- |")
    for case in cases_at(CASES / "external")[0]:
        references = re.findall(r"\{quantity: .*\} *# (.+)", case.read_text(encoding="utf-8"))
        for comparison, reference in zip(check_case(case).comparisons, references, strict=True):
            _, quantity, expected, found, *_ = comparison.cells()
            print(f"| {case.stem} | {quantity} | {reference} | {expected} | {found} |")


def print_paper() -> None:
    """Print the paper's values beside the certified ones and those found on 128 x 128 cells."""
    print("| case | quantity | closed form | paper, % | certified, % | found, % |")
    print("| --- | --- | --- | --- | --- | --- |")
    for row in paper_rows():
        found = 100.0 * (row.found(stage_ends(row.case)[row.stage]) / row.closed_form - 1.0)
        values = f"{row.closed_form:.6g} | {row.paper} | {row.certified} | {found:+.3f}"
        print(f"| {row.case} | {row.quantity} | {values} |")


def print_steps() -> None:
    """Return what the number of increments does to the same case, which no certificate can tell."""
    print("| increments per stage | p0 at A, MPa | delta_x at A, mm | dissipated energy 0 to A, mJ |")
    print("| --- | --- | --- | --- |")
    for count in (5, 10, 20, 40, 80):
        settings = [f"load_path.{stage}.increments={count}" for stage in (0, 1)]
        case = fretsolve.load_case(CASES / "mode1_dissimilar.yaml", ["grid.points=48", "expect=[]", *settings])
        for state in fretsolve.run(case):
            if state.summary.stage == 2 and state.summary.step == 2 * count - 1:
                found = state.summary
                break
        print(f"| {count} | {found.max_pressure:.2f} | {found.delta_x:.5e} | {found.work_total:.4e} |")


def print_residuals() -> None:
    """Print the worst residual of the certificate over each shipped case, at the tolerance it asks for."""
    names = ("gap", "stick", "slip", "bound", "load")
    print("| case | increments | tolerance |", " | ".join(names), "|")
    print("| --- " * (3 + len(names)) + "|")
    for path in cases_at(CASES)[0]:
        case = fretsolve.load_case(path)
        summaries = [state.summary for state in fretsolve.run(case)]
        worst = [max(getattr(s, f"residual_{name}") for s in summaries) for name in names]
        values = " | ".join(f"{value:.1e}" for value in worst)
        print(f"| {path.stem} | {len(summaries)} | {case.solver.tolerance:.0e} | {values} |")


def print_performance() -> None:
    """Print what increments on large grids cost, and the memory of the coupled one."""
    bench_path.print_large()
    sizes = ", ".join(f"{bench_path.bytes_per_cell(points):.0f} on {points} x {points}" for points in (1024, 2048))
    print(f"\nPeak memory of mode I.3 in bytes per cell, beyond the interpreter and its libraries: {sizes}.")


def print_savings() -> None:
    """Print memory and time of single precision."""
    precision.print_savings([512, 1024, 2048])


def print_programs() -> None:
    """Print the figures of other open programs on the base case, as far as they can be installed."""
    compare_programs.main(["512"])


def print_run() -> None:
    """Return what the first command of the README prints after its progress; it installs no compiler."""
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(CASES, Path(folder) / "cases")
        command = [sys.executable, "-m", "fretsolve", "run", "cases/mode1_similar.yaml"]
        plain = os.environ | {"FRETSOLVE_NUMBA": "0"}
        child = subprocess.run(command, cwd=folder, env=plain, capture_output=True, text=True, check=True)
    progress = child.stdout.rindex("step=")
    table = child.stdout.index("\n\n", progress)
    print(f"```text\n{child.stdout[table:].strip(chr(10))}\n```")


PARTS = {
    "run": print_run,
    "certified": print_certified,
    "published": print_published,
    "paper": print_paper,
    "steps": print_steps,
    "increments": increments.print_table,
    "line orders": lines.print_orders,
    "unlike lines": lines.print_unlike,
    "bulk lines": lines.print_bulk,
    "residuals": print_residuals,
    "performance": print_performance,
    "small grids": bench_path.print_small,
    "savings": print_savings,
    "programs": print_programs,
}


def main() -> None:
    """Read the arguments and print the parts that are named, or all, or put them into pages."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PARTS))
    parser.add_argument("--into", type=Path, nargs="+", metavar="PAGE", help="pages with marks, which get the figures")
    asked = parser.parse_args()
    unknown = [name for name in asked.parts if name not in PARTS]
    if unknown:
        parser.error(f"no such part: {', '.join(unknown)}; there are {', '.join(PARTS)}")
    for page in asked.into or ():
        put_parts_into(page, PARTS)
    if not asked.into:
        for name in asked.parts or PARTS:
            print(f"\n### {name}\n\n{printed(PARTS[name])}")


if __name__ == "__main__":
    main()
