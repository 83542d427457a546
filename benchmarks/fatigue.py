"""Measure what fatigue parameters cost, what a scan of planes misses, and how right stress intensities of cracks are.

    python benchmarks/fatigue.py                               # about a minute on one core
    python benchmarks/fatigue.py --points 64 --depths 5
    python benchmarks/fatigue.py --into docs/verification.md   # the tables of the scan and of cracks

The picture of the size effect is drawn by gallery.py. The block of stresses has 128 x 128 x 20 points with 40 states,
of a sphere of 10 mm on a flat, pressed and moved to and fro in partial slip. Its processor time is of one core, without
reading and writing.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from helpers import parser_of, report
from matplotlib.figure import Figure

from fretsolve.case.keys.material_spec import Material
from fretsolve.case.keys.quantity_names import STRESS_CRITERIA
from fretsolve.post.fatigue import criteria, critical_plane
from fretsolve.post.fatigue.criteria import fatigue_field
from fretsolve.system.arrays import DoubleArray

if TYPE_CHECKING:
    from fretsolve.post.crack.analysis import Crack

MATERIAL = Material(
    tension_limit=300.0,
    torsion_limit=190.0,
    tensile_strength=700.0,
    yield_stress=500.0,
    young_modulus=200e3,
    poisson_ratio=0.3,
)
STATES = 40


def loop(points: int, depths: int) -> Iterator[DoubleArray]:
    """Yield the stresses (states, 6, points) of each layer of a fretting loop, solved on the way."""
    from fretsolve import open_result
    from fretsolve.cli.commands.run import run_case
    from fretsolve.post.stress.cycles import cycles_of
    from fretsolve.post.stress.request import layers, stress_request
    from fretsolve.post.stress.tractions import TractionHistory
    from fretsolve.system.signals import StopRequest

    steel = "{young_modulus: 200 GPa, poisson_ratio: 0.3}"
    half = STATES // 2
    text = f"""\
bodies: [{steel}, {steel}]
surface: {{sphere: {{radius: 10 mm}}}}
grid: {{points: {points}}}
friction: 0.4
load_path:
  - {{P: 400 N}}
  - {{Qx: 100 N, increments: {half}}}
  - cycle: {{times: 1, stages: [{{Qx: -100 N, increments: {half}}}, {{Qx: 100 N, increments: {half - 1}}}]}}
"""
    with tempfile.TemporaryDirectory() as folder:
        case = Path(folder) / "loop.yaml"
        case.write_text(text)
        with StopRequest() as stop:
            run_case(case, None, (), stop, quiet=True)
        with open_result(case.with_suffix(".h5")) as result:
            tractions = TractionHistory(result)
            steps = cycles_of(result)[-1].states
            radius = float(result.history["contact_radius"][-1])
            wanted = tuple(np.linspace(0.0, radius, depths))
            request = stress_request(tractions, steps, (2,), wanted, window="all")
            stress = np.empty((len(steps), 6, points * points))
            for layer in layers(tractions, request):
                stress[layer.step_index] = layer.stress.reshape(6, -1)
                if layer.step_index == len(steps) - 1:
                    yield stress


def print_costs(points: int, depths: int) -> None:
    """Print the time of each criterion for all layers together, and how many points were refined."""
    print(f"{points} x {points} x {depths} points, {STATES} states, processor time of one core.")
    print()
    print("| criterion | s | us per point | refined points | worst |")
    print("| --- | --- | --- | --- | --- |")
    seconds, refined, worst = (dict.fromkeys(STRESS_CRITERIA, 0.0) for _ in range(3))
    for stress in loop(points, depths):
        for name in STRESS_CRITERIA:
            options = {"known": worst[name]} if worst[name] and name not in STRESS_CRITERIA[:2] else {}
            began = time.process_time()
            field = fatigue_field(name, MATERIAL, stress, **options)
            seconds[name] += time.process_time() - began
            worst[name] = max(worst[name], float(field.value.max()))
            refined[name] += 0.0 if field.refined is None else float(field.refined.sum())
    for name in STRESS_CRITERIA:
        each = 1e6 * seconds[name] / (points * points * depths)
        print(f"| {name} | {seconds[name]:.1f} | {each:.0f} | {refined[name]:.0f} | {worst[name]:.5g} |")


def random_histories(count: int) -> DoubleArray:
    """Return stresses (40, 6, count): a third each proportional with a mean, elliptic, and with a second harmonic."""
    random = np.random.default_rng(5)
    angle = (2.0 * np.pi * np.arange(STATES) / STATES)[:, None, None]
    mean, sine, cosine, second = 100.0 * random.normal(size=(4, 6, count))
    stress = mean + sine * np.sin(angle)
    third = count // 3
    stress[:, :, third:] += (cosine * np.cos(angle))[:, :, third:]
    stress[:, :, 2 * third :] += (0.5 * second * np.cos(2.0 * angle))[:, :, 2 * third :]
    return stress


def print_scan(count: int = 600) -> None:
    """Print what a scan misses of the refined value, over its step, with and without the parabola."""
    print(f"Worst (mean) of {count} random histories, in per cent of the refined value.")
    print()
    print("| step, degrees | planes | findley | fatemi-socie | swt | findley, improved | fatemi-socie | swt |")
    print("| --- " * 8 + "|")
    stress = random_histories(count)
    planes = [getattr(criteria, name)(MATERIAL) for name in ("findley", "fatemi_socie", "swt")]
    exact = [critical_plane.search(plane, stress, refine_all=True).value for plane in planes]
    for step in (15.0, 10.0, 5.0, 2.0):
        cells = []
        for improve in (False, True):
            for plane, best in zip(planes, exact, strict=True):
                value = critical_plane.Scan(plane, step).best(stress, improve=improve)[0]
                known = best > 0.1 * best.max()
                missed = 100.0 * (1.0 - value[known] / best[known]).clip(0.0)
                cells.append(f"{missed.max():.2g} ({missed.mean():.2g})")
        print(f"| {step:g} | {len(critical_plane.scan_normals(step))} | {' | '.join(cells)} |")


CASES = Path(__file__).parents[1] / "cases"

CERTIFIED = {0.05: 0.33122, 0.2: 0.47769, 1.0: 0.64965}
"""K_I over p0 sqrt(pi a) by b/a: mu 0.75, Q = 0.6 mu P, bulk stress 0.5904 p0 in phase, crack at the trailing edge."""

TESTED = (12.5, 25.0, 37.5, 50.0, 75.0, 100.0, 125.0, 150.0)
"""Radii of the tests' pads (mm)."""

BETWEEN = (14.0, 16.0, 18.0, 20.0, 22.0)
"""Radii (mm) between the first ones of the tests."""

RAN_OUT, BROKE = 0.28, 0.38
"""Half-widths (mm) up to which specimens ran out at 1e7 cycles, and from which on they broke, as later papers quote
Nowell's first series. The numbers could not be compared with the original."""


def crack_under(radius: float, *overrides: str) -> tuple[float, Crack]:
    """Return p0 (MPa) and the crack of the shipped case under a pad of a radius (mm); overrides: of the case."""
    from fretsolve import open_result
    from fretsolve.cli.commands.run import run_case
    from fretsolve.post.crack.analysis import crack_of
    from fretsolve.post.crack.request import CrackRequest
    from fretsolve.post.fatigue.material import read_material
    from fretsolve.post.stress.tractions import TractionHistory
    from fretsolve.system.signals import StopRequest

    share = radius / 50.0
    loads = f"stage.1.P={share * 93.24894} N/mm", f"load_path.1.cycle.amplitude.Qx={share * 41.96202} N/mm"
    sets = (f"surface.0.cylinder.radius={radius} mm", *loads, "output={fields: [pressure, shear]}", *overrides)
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "crack.h5"
        with StopRequest() as stop:
            run_case(CASES / "crack.yaml", out, sets, stop, quiet=True)
        with open_result(out) as result:
            material = read_material(str(CASES / "materials" / "al-4cu.yaml"))
            crack = crack_of(TractionHistory(result), CrackRequest(material, thickness=12.5))
            return float(result.history["max_pressure"][-1]), crack


def print_cracks() -> None:
    """Print the error of stress intensities in a solved line contact, and its error bar, over the grid."""
    print("| points | cells per half-width |" + "".join(f" b/a = {share}: error | bar |" for share in CERTIFIED))
    print("| --- " * (2 + 2 * len(CERTIFIED)) + "|")
    for points in (65, 129, 257, 513):
        pressure, crack = crack_under(50.0, f"grid.points={points}")
        unit = pressure * np.sqrt(1e-3 * np.pi * crack.half_width)
        cells = []
        for share, certified in CERTIFIED.items():
            at, places = np.log(share * crack.half_width), np.log(crack.lengths)
            found, bar = (float(np.interp(at, places, of)) for of in (crack.K[0].max(axis=0), crack.K_error))
            cells += [f"{found / unit / certified - 1.0:.1e}", f"{bar / unit / certified:.1e}"]
        print(f"| {points} | {crack.half_width / crack.cell:.0f} | {' | '.join(cells)} |")


def size_effect() -> Figure:
    """Draw the life under pads of equal pressure over the half-width of the contact, beside what tests found."""
    figure = Figure(figsize=(5.6, 3.4), layout="constrained")
    axes = figure.subplots()
    found = {radius: crack_under(radius)[1] for radius in sorted({*TESTED, *BETWEEN})}
    through = [crack for crack in found.values() if crack.verdict == "goes through"]
    stops = [crack.half_width for crack in found.values() if crack.verdict != "goes through"]
    tests = np.array([found[radius].half_width for radius in TESTED])
    ran_out = tests[tests < 0.5 * (RAN_OUT + BROKE)]
    axes.axvspan(RAN_OUT, BROKE, color="0.9")
    axes.plot([crack.half_width for crack in through], [crack.growth.life for crack in through], "o-", markersize=4,
              label="computed: the crack goes through")  # fmt: skip
    axes.plot(stops, np.full(len(stops), 2.5e7), "^", color="C0", label="computed: the crack stops")
    axes.plot(ran_out, np.full(len(ran_out), 1e7), "^", color="C1", label="tested: ran out at 1e7 cycles")
    broke = tests[len(ran_out) :]
    axes.plot(broke, np.full(len(broke), 1e7), "v", color="C3", label="tested: broke before")
    axes.set(xscale="log", yscale="log", xlabel="half-width of the contact $a$ (mm)", ylabel="life (cycles)")
    axes.set_ylim(1e6, 1.2e8)
    axes.set_xticks([0.1, 0.2, 0.3, 0.5, 1.0], ["0.1", "0.2", "0.3", "0.5", "1"])
    axes.minorticks_off()
    axes.legend(fontsize=8, loc="upper right")
    return figure


def main() -> None:
    """Read the arguments and print what they ask for."""
    parser = parser_of(__doc__)
    parser.add_argument("--points", type=int, default=128, help="cells per side")
    parser.add_argument("--depths", type=int, default=20)
    asked = parser.parse_args()
    report(
        {
            "fatigue costs": partial(print_costs, asked.points, asked.depths),
            "fatigue scan": print_scan,
            "cracks": print_cracks,
        },
        asked.into,
    )


if __name__ == "__main__":
    main()
