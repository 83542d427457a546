"""Compare the histories and fields of two checkouts, bit by bit, on all shipped cases and on random ones.

    python benchmarks/same_bits.py ../older                  # 200 random cases, five minutes on two cores
    python benchmarks/same_bits.py ../older --random 20 --kernels numpy

The cases are written as files once, so that both checkouts read the same ones by `fretsolve.load_case`. No transform is
planned by measurements, which differ from one to the next, and other plans round otherwise. Compiled kernels have the
same bits only if both checkouts compile them anew. A difference is over the scale of its kind: P, delta_z, the
contact's radius and area, the largest pressure, shear and dissipated energy.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
SOLVE = "--solve"
KERNELS = {"numba": "1", "numpy": "0"}
SEEDS, MOST_INCREMENTS = range(101, 105), 120
MEASURES = ("residual", "operator", "wall_time", "iterations", "alternations")
"""Beginnings of columns that tell of the way to a solution and not of the solution."""


def write_cases(folder: Path, count: int) -> None:
    """Write the shipped cases, and `count` random ones, into a folder."""
    import yaml
    from random_scenes import unseen_cases

    for kind in (ROOT / "cases", ROOT / "cases" / "external"):
        for file in kind.iterdir():
            if file.is_file():
                shutil.copy(file, folder)
    (maps := folder / "maps").mkdir()
    for seed in SEEDS:
        for one in unseen_cases(seed, count // len(SEEDS), maps):
            text = yaml.safe_dump(one.case().effective(), sort_keys=False)
            (folder / f"random-{one.name.split()[0]}.yaml").write_text(text)


def estimate_all_plans() -> None:
    """Let FFTW estimate the plans that it is asked to measure."""
    from fretsolve.elastic.fftw import pyfftw

    def estimated(*arrays: Any, flags: Sequence[str], **options: Any) -> Any:
        return planned(*arrays, flags=[flag.replace("FFTW_MEASURE", "FFTW_ESTIMATE") for flag in flags], **options)

    planned, pyfftw.FFTW = pyfftw.FFTW, estimated


def solve(folder: Path, out: Path) -> None:
    """Write the history of each case, and a digest of its fields, as JSON."""
    import numpy as np

    import fretsolve

    estimate_all_plans()
    found: dict[str, Any] = {}
    for file in sorted(folder.glob("*.yaml")):
        rows, digest, why = [], hashlib.sha256(), ""
        try:
            for state in fretsolve.run(fretsolve.load_case(file)):
                rows.append({name: value for name, value in vars(state.summary).items() if name != "wall_time"})
                for field in vars(state.fields).values():
                    if field is not None:
                        digest.update(np.ascontiguousarray(field).tobytes())
                if len(rows) == MOST_INCREMENTS:
                    break
        except fretsolve.errors.FretsolveError as error:
            why = type(error).__name__
        found[file.stem] = {"history": rows, "fields": digest.hexdigest(), "why": why}
    out.write_text(json.dumps(found))


def scale(name: str, history: Sequence[Mapping[str, Any]]) -> float:
    """Return the scale of a column's differences."""

    def largest(column: str) -> float:
        return max(abs(row[column]) for row in history if row[column] == row[column])

    radius, approach = largest("contact_radius"), max((abs(row["delta_z"]) for row in history), default=0.0)
    approach = approach if approach > 0.0 else 1e-2 * radius  # unknown in line contacts
    kinds = {"P": largest("P"), "Q": largest("P"), "M": largest("P") * radius, "d": approach, "phi": approach / radius}
    kinds |= {"work": largest("work_total"), "contact_area": largest("contact_area")}
    kinds |= {"stick_area": largest("contact_area"), "contact": radius, "stick": radius}
    return next((kinds[kind] for kind in sorted(kinds, key=len, reverse=True) if name.startswith(kind)), largest(name))


def with_columns_of(old: Mapping[str, Any], new: Mapping[str, Any]) -> dict[str, Any]:
    """Return a solved case with the columns of the history that the older one has."""
    known = set().union(*old["history"])
    rows = [{name: value for name, value in row.items() if name in known} for row in new["history"]]
    return {**new, "history": rows}


def difference(old: Mapping[str, Any], new: Mapping[str, Any]) -> tuple[float, str]:
    """Return the largest difference of two solved cases over its scale, and its column."""
    if len(old["history"]) != len(new["history"]) or old["why"] != new["why"]:
        return float("inf"), f"{len(old['history'])} and {len(new['history'])} increments {old['why']} {new['why']}"
    worst = (0.0, "")
    for before, after in zip(old["history"], new["history"], strict=True):
        for name, value in before.items():
            if value != after.get(name) and value == value and not name.startswith(MEASURES):
                size = scale(name, old["history"])
                worst = max(worst, (abs(value - after[name]) / size if size else float("inf"), name))
    return worst


def main() -> None:
    """Solve the cases with both checkouts, and print what differs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("older", type=Path, help="the root of another checkout")
    parser.add_argument("--random", type=int, default=200, help="number of random cases (200)")
    parser.add_argument("--kernels", choices=KERNELS, action="append", help="numba or numpy; both by default")
    parser.add_argument(SOLVE, type=Path, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.solve is not None:
        solve(asked.older, asked.solve)
        return
    with tempfile.TemporaryDirectory() as name:
        folder, cache = Path(name) / "cases", Path(name) / "cache"
        folder.mkdir()
        write_cases(folder, asked.random)
        for kernels in asked.kernels or KERNELS:
            solved = []
            for number, root in enumerate((asked.older.resolve(), ROOT)):
                out = Path(name) / f"{number}.json"
                own = {"PYTHONPATH": str(root), "FRETSOLVE_NUMBA": KERNELS[kernels], "FRETSOLVE_CACHE": str(cache)}
                subprocess.run(
                    [sys.executable, __file__, str(folder), SOLVE, str(out)], env=os.environ | own, check=True
                )
                solved.append(json.loads(out.read_text()))
            old, new = solved
            shared = {case: with_columns_of(old[case], one) for case, one in new.items()}
            differing = [case for case in old if old[case] != shared[case]]
            for size, column, case in sorted((*difference(old[case], new[case]), case) for case in differing)[-10:]:
                print(f"{case}: {column or 'fields'} differs by {size:.2g}")
            old_cost, new_cost = (
                sum(row["operator_applications"] for case in one.values() for row in case["history"])
                for one in (old, new)
            )
            ratio = new_cost / old_cost
            print(
                f"{kernels}: {len(differing)} of {len(old)} cases differ; operator applications {ratio:.4f} of before"
            )


if __name__ == "__main__":
    main()
