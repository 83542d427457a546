"""Error bars of the largest stresses at the edge of contact, on varied contacts with finer runs of them as truth.

    python benchmarks/edge_errors.py [--only line|area] [--into docs/verification.md]

Each contact is solved on several grids and on one of many times as many cells, whose extrapolated value is the truth.
`calibrated` are the contacts from which `SOLVED_FACTOR` and `ERROR_FACTOR` were chosen; the others, which had no part
in that, are a test. Looked at are the largest tension, von Mises and Tresca stress on the surface, of all increments.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from marked import parser_of, report

from fretsolve.case.loading import load_case
from fretsolve.result import open_result
from fretsolve.result.writer import HistoryWriter
from fretsolve.setup.problem_setup import set_up
from fretsolve.simulation.run_to_file import run_header, solve_missing
from fretsolve.stress.names import INVARIANTS
from fretsolve.stress.peaks import Peak
from fretsolve.stress.request import stress_request
from fretsolve.stress.stress_file import write_stress
from fretsolve.stress.tractions import TractionHistory

STEEL = "{young_modulus: 200 GPa, poisson_ratio: 0.3}"
ALLOY = "{young_modulus: 72 GPa, poisson_ratio: 0.33}"
LINE_GRIDS, LINE_TRUTH = (48, 64, 72, 96, 128, 192, 256), 8192
AREA_GRIDS, AREA_TRUTH = (32, 40, 48, 64, 80), 288


@dataclass(frozen=True)
class Contact:
    """A contact, all of whose increments are looked at. body: the one that is looked at; line: it is a line contact."""

    name: str
    surface: str
    friction: float
    load_path: str
    bodies: tuple[str, str] = (STEEL, STEEL)
    body: int = 2
    line: bool = False
    calibrated: bool = False

    def text(self, points: int) -> str:
        """Return the case."""
        return (
            f"bodies: [{', '.join(self.bodies)}]\nsurface: {self.surface}\ngrid: {{points: {points}}}\n"
            f"friction: {self.friction}\nload_path: {self.load_path}\n" + ("plane: strain\n" if self.line else "")
        )


CYLINDER, SPHERE = "{cylinder: {radius: 10 mm}}", "{sphere: {radius: 10 mm}}"
ELLIPSOID = "{ellipsoid: {radius_x: 10 mm, radius_y: 25 mm, angle: 30 deg}}"
LINE_PUNCH = "{punch: {half_width: 0.5 mm, edge_radius: 100 mm}}"
ROUND_PUNCH = "{punch: {radius: 0.3 mm, edge_radius: 0.2 mm}}"
CONTACTS = (
    Contact("cylinder, pulled", CYLINDER, 0.3, "[{P: 100}, {Qx: 18, bulk_2: {xx: 142}, increments: 4}]", line=True),
    Contact(
        "cylinder, compressed",
        CYLINDER,
        0.3,
        "[{P: 100}, {Qx: -18, bulk_2: {xx: -142}, increments: 4}]",
        line=True,
        calibrated=True,
    ),
    Contact("cylinder, mu = 1", CYLINDER, 1.0, "[{P: 100}, {Qx: 60, increments: 2}]", line=True, calibrated=True),
    Contact("cylinder, nearly sliding", CYLINDER, 0.1, "[{P: 100}, {Qx: 9.99, increments: 2}]", line=True),
    Contact(
        "cylinder, reversed",
        CYLINDER,
        0.5,
        "[{P: 100}, {Qx: 40, increments: 2}, {Qx: -30, increments: 4}]",
        line=True,
        calibrated=True,
    ),
    Contact("line punch", LINE_PUNCH, 0.3, "[{P: 200}, {Qx: 36, increments: 2}]", line=True),
    Contact(
        "line punch, pulled",
        LINE_PUNCH,
        0.6,
        "[{P: 200}, {Qx: 60, bulk_2: {xx: 60}, increments: 2}]",
        line=True,
        body=1,
        calibrated=True,
    ),
    Contact(
        "cylinder on another material", CYLINDER, 0.4, "[{P: 60}, {Qx: 15, increments: 2}]", (STEEL, ALLOY), line=True
    ),
    Contact("sphere, mu = 0.1, sliding", SPHERE, 0.1, "[{P: 400}, {delta_x: 0.01}]", calibrated=True),
    Contact("sphere, mu = 1, sliding", SPHERE, 1.0, "[{P: 400}, {delta_x: 0.1}]"),
    Contact("sphere, partial slip", SPHERE, 0.4, "[{P: 400}, {Qx: 100, increments: 2}]", calibrated=True),
    Contact(
        "sphere, pulled across", SPHERE, 0.5, "[{P: 400}, {Qx: 60, Qy: 80, bulk_2: {xx: 300, yy: -100}, increments: 2}]"
    ),
    Contact("ellipsoid", ELLIPSOID, 0.6, "[{P: 400}, {Qx: 100, Qy: 150, increments: 2}]"),
    Contact(
        "ellipsoid, body 1, compressed",
        ELLIPSOID,
        0.3,
        "[{P: 400}, {Qx: 80, bulk_1: {xx: -150}, increments: 2}]",
        body=1,
        calibrated=True,
    ),
    Contact("round punch", ROUND_PUNCH, 0.3, "[{P: 100}, {Qx: 20, increments: 2}]"),
    Contact(
        "sphere on another material",
        SPHERE,
        0.5,
        "[{P: 200}, {Qx: 60, increments: 2}]",
        (STEEL, ALLOY),
        calibrated=True,
    ),
)


@dataclass(frozen=True)
class Finding:
    """A largest stress of an increment, and its truth."""

    contact: Contact
    points: int
    name: str
    step: int
    found: Peak
    truth: Peak

    def __str__(self) -> str:
        edge = "extrapolated" if self.found.at_edge else "on cells"
        values = (f"{one.value:.4g} ± {one.error:.2g}" for one in (self.found, self.truth))
        words = self.contact.name, str(self.points), self.name, str(self.step), *values, edge, f"{self.share:.2f}"
        return ", ".join(words)

    @property
    def share(self) -> float:
        """Deviation over error bar."""
        return abs(self.found.value - self.truth.value) / self.found.error


class NoStop:
    """Never asks a run to stop."""

    requested = False


def peaks(contact: Contact, points: int, folder: Path) -> dict[tuple[str, int], Peak]:
    """Return the largest stresses on the surface, by invariant and increment."""
    case = folder / "case.yaml"
    case.write_text(contact.text(points))
    setup = set_up(load_case(case))
    out = folder / "case.h5"
    out.unlink(missing_ok=True)
    with HistoryWriter.open(out, run_header(setup, 1, ())) as writer:
        solve_missing(setup, writer, NoStop())
    with open_result(out) as result:
        tractions = TractionHistory(result)
        request = stress_request(tractions, result.steps, (contact.body,), (0.0,))
        found = write_stress(tractions, request, folder / "stress.h5")
    return {(name, step): one for name in INVARIANTS for step, one in enumerate(found[contact.body, name])}


def findings(contacts: tuple[Contact, ...]) -> Iterator[Finding]:
    """Yield the values of all contacts, grids and increments."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for contact in contacts:
            grids, truth_points = (LINE_GRIDS, LINE_TRUTH) if contact.line else (AREA_GRIDS, AREA_TRUTH)
            truth = peaks(contact, truth_points, folder)
            for points in grids:
                for one, peak in peaks(contact, points, folder).items():
                    yield Finding(contact, points, *one, peak, truth[one])


def rows(found: list[Finding]) -> Iterator[str]:
    """Yield the table: of each contact how many bars hold, and how wide they are."""
    words = "contact", "chosen by it", "bars", "hold, %", "extrapolated", "hold, %", "largest deviation over bar"
    yield f"| {' | '.join(words)} | bar over value, % |"
    yield "| --- | --- | --- | --- | --- | --- | --- | --- |"
    for contact in dict.fromkeys(one.contact for one in found):
        yield _row(
            contact.name, "yes" if contact.calibrated else "no", [one for one in found if one.contact == contact]
        )
    for chosen, word in ((True, "yes"), (False, "no")):
        yield _row("**all**", word, [one for one in found if one.contact.calibrated == chosen])


def _row(name: str, chosen: str, some: list[Finding]) -> str:
    shares = np.array([one.share for one in some])
    width = np.median([100.0 * one.found.error / abs(one.found.value) for one in some])
    at_edge = [one.share for one in some if one.found.at_edge]
    held, edge_held = (f"{100.0 * np.mean(np.array(one) <= 1.0):.0f}" if len(one) else "" for one in (shares, at_edge))
    edge = f"{len(at_edge)} | {edge_held}"
    return f"| {name} | {chosen} | {len(some)} | {held} | {edge} | {shares.max():.2f} | {width:.1f} |"


def main() -> None:
    """Print the table, or write it between its marks."""
    parser = parser_of(__doc__)
    parser.add_argument("--only", choices=("line", "area"), help="line contacts or others alone")
    options = parser.parse_args()
    chosen = tuple(one for one in CONTACTS if options.only is None or one.line == (options.only == "line"))
    found = []
    for one in findings(chosen):
        found.append(one)
        if options.into is None:
            print(one, flush=True)
    report({"stress edge errors": lambda: print(*rows(found), sep="\n")}, options.into)


if __name__ == "__main__":
    main()
