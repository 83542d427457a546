"""Measure what Findley's parameter costs on a block of stresses, and what a scan of planes misses.

    python benchmarks/fatigue.py                               # about two minutes on one core
    python benchmarks/fatigue.py --points 64 --depths 5
    python benchmarks/fatigue.py --into docs/verification.md   # the table of the scan as well

The block has 128 x 128 x 20 points with 40 states, of a sphere of 10 mm on a flat, pressed and moved to and fro in
partial slip. Processor time of one core, without reading and writing.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from functools import partial

import numpy as np
from helpers import parser_of, report

from fretsolve.case.keys.material_spec import Material
from fretsolve.case.keys.quantity_names import STRESS_CRITERIA
from fretsolve.post.fatigue import criteria, critical_plane
from fretsolve.post.fatigue.criteria import fatigue_field
from fretsolve.system.arrays import DoubleArray

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
    import tempfile
    from pathlib import Path

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


def main() -> None:
    """Read the arguments and print what they ask for."""
    parser = parser_of(__doc__)
    parser.add_argument("--points", type=int, default=128, help="cells per side")
    parser.add_argument("--depths", type=int, default=20)
    asked = parser.parse_args()
    report({"fatigue costs": partial(print_costs, asked.points, asked.depths), "fatigue scan": print_scan}, asked.into)


if __name__ == "__main__":
    main()
