"""Drive the solver to its extremes: families of cases over wide ranges, each against the limit that theory gives.

    python benchmarks/extremes.py                          # all of them, some six minutes on one core
    python benchmarks/extremes.py "mode II" torque         # the families whose names contain one of these
    python benchmarks/extremes.py --picture extremes.png   # and a picture of the distances, and of friction x Dundurs
    python benchmarks/extremes.py --precision single       # the same in single precision, with limits of its own
    python benchmarks/extremes.py --random 300             # so many new random cases of each kind instead
    python benchmarks/extremes.py --into docs/robustness.md    # the counts, and all rows to data/extremes_double.csv

Prints a Markdown table with a row for each family, and then every probe that does not end as it has to. In single
precision the table has the families alone that end in another way than in double precision. ``--into`` also writes all
rows to ``data/extremes_double.csv`` or ``data/extremes_single.csv``. The families stand in
``tests/extremes/families``; the tests there drive the quick part of them, and random cases.
"""

from __future__ import annotations

import csv
import os
import re
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from helpers import data_file, parser_of, report, write_csv

TESTS = Path(__file__).resolve().parents[1] / "tests"
sys.path[:0] = [str(TESTS), str(TESTS / "extremes")]

from families import FAMILIES  # noqa: E402
from families.driving import Family, Probe, Verdict, in_single, judge  # noqa: E402
from families.pairs import elastic  # noqa: E402

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FRICTIONS = (1e-8, 1e-4, 1e-2, 0.03, 0.1, 0.3, 1.0, 2.0, 3.0, 5.0, 10.0, 100.0, 1e4, 1e6)
RATIOS = (0.5, 0.42, 0.3, 0.2, 0.1, 0.0)
"""Poisson's ratios of a body under a rigid one: Dundurs' constant is (1 - 2 nu)/2(1 - nu), 0 to 1/2."""

PAGE = TESTS.parent / "docs" / "robustness.md"
HEADINGS = ("case", "range", "outcome", "worst_residual", "limit", "distance", "allowed", "seconds")

COLUMNS = ("case", "range", "outcome", "limit of theory", "distance (allowed)")
"""Of the printed tables."""

PARTS = {"double": "extremes", "single": "extremes in single precision"}
"""Marks of the counts of each precision."""

KINDS = {
    "indentation": ({"P": 400.0, "increments": 5},),
    "Q = mu P/2": ({"P": 400.0, "increments": 5}, {"Qx": 0.5, "increments": 5}),
    "gross slip": ({"P": 400.0, "increments": 5}, {"delta_x": 1.0, "increments": 2}),
}
"""Load paths of the map; Qx there is a share of mu P."""


@dataclass(frozen=True)
class Row:
    """A family and how its probes ended."""

    family: Family
    verdicts: list[Verdict]

    @property
    def outcome(self) -> str:
        """In words: how many were certified, refused, and failed."""
        failed = sum(bool(verdict.problem) for verdict in self.verdicts)
        refused = sum(bool(verdict.message) and not verdict.problem for verdict in self.verdicts)
        counts = {"certified": len(self.verdicts) - failed - refused, "refused": refused, "**failed**": failed}
        return ", ".join(f"{count} {what}" for what, count in counts.items() if count)

    @property
    def residual(self) -> float:
        """Worst of all certified increments."""
        return max(verdict.findings.residual for verdict in self.verdicts)

    @property
    def measured(self) -> list[Verdict]:
        """The verdicts that are measured against theory."""
        return [v for v in self.verdicts if v.probe.theory is not None and v.distance == v.distance]

    @property
    def distance(self) -> tuple[str, str]:
        """The largest distance from theory and the largest allowed one; empty where theory gives no number."""
        if not self.measured:
            return "", ""
        distance = max(verdict.distance for verdict in self.measured)
        return f"{distance:.1e}", f"{max(verdict.probe.allowed for verdict in self.measured):.0e}"

    @property
    def cells(self) -> tuple[str, ...]:
        """The row of the CSV file."""
        family, seconds = self.family, sum(verdict.seconds for verdict in self.verdicts)
        about = (family.name, family.range, self.outcome, f"{self.residual:.0e}", family.limit)
        return (*about, *self.distance, f"{seconds:.1f}")

    def markdown(self, headings: Sequence[str]) -> str:
        """Return the row of a table with some of `COLUMNS`."""
        distance, allowed = self.distance
        far = f"{distance} ({allowed})" if distance else "-"
        values = (self.family.name, self.family.range or "-", self.outcome, self.family.limit, far)
        cells = (value for heading, value in zip(COLUMNS, values, strict=True) if heading in headings)
        return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def driven(probe: Probe, precision: str = "double") -> Verdict:
    """Return how a probe ends."""
    with TemporaryDirectory() as folder:
        return judge(in_single(probe) if precision == "single" else probe, Path(folder))


def outcomes_in_double() -> dict[str, str]:
    """Return how each family ended in double precision, as the data of the page have it."""
    file = data_file(PAGE, "extremes_double")
    if not file.exists():
        return {}
    with file.open(encoding="utf-8", newline="") as stream:
        return {row["case"]: row["outcome"] for row in csv.DictReader(stream)}


def print_table(names: list[str], precision: str) -> list[Row]:
    """Print a table of the families, a row at a time."""
    chosen = [family for family in FAMILIES if not names or any(name in family.name for name in names)]
    known = outcomes_in_double() if precision == "single" else {}
    headings = COLUMNS if precision == "double" else COLUMNS[::2]  # range and limit are those of the other table
    print(f"| {' | '.join(headings)} |")
    print(f"|{' --- |' * len(headings)}")
    rows = []
    for family in chosen:
        rows.append(Row(family, [driven(probe, precision) for probe in family.probes]))
        if rows[-1].outcome != known.get(family.name):
            print(rows[-1].markdown(headings), flush=True)
    print()
    return rows


def print_failures(rows: Sequence[Row]) -> None:
    """Print how many cases there were, and what is wrong with which of them."""
    verdicts = [(row.family, verdict) for row in rows for verdict in row.verdicts]
    wrong = [(family, verdict) for family, verdict in verdicts if verdict.problem]
    print(f"{len(verdicts)} cases, {len(wrong)} failures{':' if wrong else ''}\n")
    for family, verdict in wrong:
        problem = re.sub(r"\S*/case\.yaml", "case.yaml", verdict.problem)
        print(f"- {family.name}, {verdict.probe.label}: {problem}")


def print_random(count: int) -> None:
    """Draw so many new random cases of each kind, and tell how they ended."""
    command = [sys.executable, "-m", "pytest", "-q", "-n", "0", str(TESTS / "extremes" / "test_random_cases.py")]
    environment = os.environ | {"FRETSOLVE_RANDOM_CASES": str(count)}
    done = subprocess.run(command, env=environment, cwd=TESTS.parent, capture_output=True, text=True, check=False)
    print(*done.stdout.splitlines()[1 if done.returncode == 0 else 0 :], sep="\n")


def draw(rows: list[Row], file: Path) -> None:
    """Draw distances from theory by family, and how far friction and coupling can go."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    measured = [row for row in rows if row.measured]
    figure = plt.figure(figsize=(15.0, max(9.0, 0.3 * len(measured))), layout="constrained")
    grid = figure.add_gridspec(len(KINDS), 2)
    draw_distances(figure.add_subplot(grid[:, 0]), measured)
    maps = [figure.add_subplot(grid[row, 1]) for row in range(len(KINDS))]
    for axes, (kind, stages) in zip(maps, KINDS.items(), strict=True):
        draw_map(axes, kind, stages)
    maps[-1].set_xlabel("coefficient of friction")
    figure.savefig(file, dpi=130)


def draw_distances(axes: Axes, rows: list[Row]) -> None:
    """Draw a dot per case, and a bar up to what is allowed."""
    least = 1e-16
    for place, row in enumerate(reversed(rows)):
        allowed = [max(verdict.probe.allowed, least) for verdict in row.measured]
        axes.plot([least, max(allowed)], [place, place], color="0.88", linewidth=7.0, solid_capstyle="butt")
        for verdict in row.measured:
            color = "tab:red" if verdict.problem else "tab:blue"
            axes.plot(min(max(verdict.distance, least), 1e3), place, ".", color=color, alpha=0.6)
    axes.set_xscale("log")
    axes.set_xlim(least, 1e1)
    axes.set_yticks(range(len(rows)), [row.family.name for row in reversed(rows)], fontsize=7)
    axes.set_xlabel("distance from the limit of theory; grey: allowed")


def draw_map(axes: Axes, kind: str, stages: tuple[dict[str, float], ...]) -> None:
    """Draw where in the plane of friction and Dundurs' constant a load path is solved, or why it is not."""
    for nu in RATIOS:
        beta = (1.0 - 2.0 * nu) / (2.0 * (1.0 - nu))
        for mu in FRICTIONS:
            path = [dict(stage) for stage in stages]
            if "Qx" in path[-1]:
                path[-1]["Qx"] *= mu * path[0]["P"]
            parts = {"bodies": ["rigid", elastic(nu)], "friction": mu, "load_path": path}
            verdict = driven(Probe(kind, parts | {"grid": {"points": 32, "size": 1.0}}))
            sign = "." if not verdict.problem else "s" if "GridEdge" in verdict.problem else "x"
            color = {".": "tab:green", "s": "tab:orange", "x": "tab:red"}[sign]
            axes.plot(mu, beta, sign, color=color, markersize=7)
    axes.set_xscale("log")
    axes.set_ylabel("Dundurs' constant")
    axes.set_title(f"{kind}: certified (dot), at the grid's edge (square), not converged (cross)", fontsize=9)


def main() -> None:
    """Read the arguments and print or draw what they name."""
    parser = parser_of(__doc__)
    parser.add_argument("names", nargs="*", help="parts of names of families; all of them by default")
    parser.add_argument("--picture", type=Path, help="file to draw to")
    parser.add_argument("--precision", choices=PARTS, default="double", help="of the solver")
    parser.add_argument("--random", type=int, metavar="N", help="draw N random cases of each kind instead")
    options = parser.parse_args()
    rows: list[Row] = []
    with TemporaryDirectory() as cache:
        os.environ.setdefault("FRETSOLVE_CACHE", cache)
        if options.random:
            report({"random cases": partial(print_random, options.random)}, options.into)
        else:
            rows = print_table(options.names, options.precision)
            report({PARTS[options.precision]: partial(print_failures, rows)}, options.into)
            if options.into:
                file = data_file(options.into, f"extremes_{options.precision}")
                write_csv(file, HEADINGS, (row.cells for row in rows))
        if options.picture:
            draw(rows, options.picture)


if __name__ == "__main__":
    main()
