"""A case driven to an extreme, and how it has to end: certified and near its limit in theory, or refused.

Probes go the way of a user's case: written to a file, read, solved. Whatever else comes out (NaN, a warning, an
increment beyond the tolerance, too long a run, another error) is named as the verdict's problem.
"""

from __future__ import annotations

import itertools
import math
import re
import signal
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from solving import LOAD, SIMILAR, SPHERE

from fretsolve import load_case
from fretsolve.errors import FretsolveError
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result.state import State, Summary
from fretsolve.simulation.problem_setup import set_up
from fretsolve.simulation.simulation import run

Parts = dict[str, Any]
FloatArray = NDArray[np.float64]
ENOUGH_WORDS = 400
"""A message longer than this many characters is not one line to a person."""


@dataclass(frozen=True)
class Run:
    """A case that was solved to its end. folder: where its files lie; parts: as written to the case file."""

    parts: Parts
    folder: Path
    setup: ProblemSetup
    states: list[State]

    @property
    def last(self) -> State:
        """The state at the end."""
        return self.states[-1]

    @property
    def end(self) -> Summary:
        """Its summary."""
        return self.last.summary

    @property
    def cell(self) -> float:
        """The longer side of a cell (mm)."""
        return max(self.setup.grid.dx, self.setup.grid.dy)


@dataclass(frozen=True)
class Probe:
    """One case of a family, and its right ending.

    parts: of a case file, or what gives them, with the sphere on a flat as default; heights: of a map (mm), which is
    added to the surface with `spacing`. It ends certified, no further from theory than `allowed`, or, if `refused` is
    given, in an error of that class whose message matches `says`; in either with `may_solve`. resolved: what theory
    tells is above the least tolerance of single precision.
    """

    label: str
    parts: Parts | Callable[[], Parts]
    theory: Callable[[Run], float] | None = None
    allowed: float = 0.0
    refused: type[FretsolveError] | None = None
    says: str = ""
    may_solve: bool = False
    heights: Callable[[], FloatArray] | None = None
    spacing: float = 0.01
    resolved: bool = True
    quick: bool = True
    seconds: float = 20.0


SINGLE_TOLERANCE = 1e-5
"""The least that single precision certifies."""

SINGLE_NAMED = "precision: single|in single precision|slightly less"
"""Words of an error if double precision would have solved the case; the last ones appear near gross slip."""


def in_single(probe: Probe) -> Probe:
    """The same in single precision: where double solves it, to the least tolerance, or refused with precision named."""
    given = _parts(probe)
    points = int(np.max(whole(given)["grid"]["points"]))
    asked = given.get("solver", {})
    tolerance = max(asked.get("tolerance", SINGLE_TOLERANCE), SINGLE_TOLERANCE)
    solvable = probe.refused is None
    return replace(
        probe,
        parts=given | {"solver": asked | {"precision": "single", "tolerance": tolerance}},
        # a gap off from one cell to the next is a pressure off by that times the cells across, in any precision
        allowed=probe.allowed + (points * tolerance if probe.resolved else math.inf),
        refused=FretsolveError if solvable else probe.refused,
        says=SINGLE_NAMED if solvable else f"{probe.says}|{SINGLE_NAMED}",
        may_solve=solvable or probe.may_solve or tolerance > asked.get("tolerance", tolerance),
        seconds=2.0 * probe.seconds,
    )


@dataclass(frozen=True)
class Family:
    """Probes over a range of one thing. limit: what theory says of them, in a few words."""

    name: str
    range: str
    limit: str
    probes: tuple[Probe, ...]


def known_scalars(summary: Summary) -> dict[str, float]:
    """Return all scalars but the middles of zones that do not exist, which are NaN."""
    values = dict(vars(summary))
    for zone, axis in itertools.product(("contact", "stick"), "xy"):
        if values[f"{zone}_half_width_{axis}"] == 0.0 and math.isnan(values[f"{zone}_center_{axis}"]):
            del values[f"{zone}_center_{axis}"]
    return values


@dataclass
class Findings:
    """Findings on a run's increments: their number, their worst residual, and faults that no increment may have."""

    increments: int = 0
    residual: float = 0.0
    wrong: list[str] = field(default_factory=list)

    def examine(self, state: State, tolerance: float) -> None:
        """Add an increment."""
        summary, found = state.summary, state.fields
        worst = summary.worst_residual
        self.increments += 1
        self.residual = max(self.residual, worst)
        stored = (getattr(found, item.name) for item in fields(found) if item.name != "gap")
        arrays = [array for array in stored if array is not None]
        wrong = {
            "a scalar is not finite": not np.isfinite(list(known_scalars(summary).values())).all(),
            "a field is not finite": not all(np.isfinite(array).all() for array in arrays),
            f"a residual is {worst:.2g}, beyond the tolerance": not worst <= tolerance,
            "the gap is NaN": bool(np.isnan(found.gap).any()),
            "a pressure is negative": bool((found.pressure < 0.0).any()),
            "the work is negative": summary.work < 0.0,
        }
        self.wrong += [f"increment {summary.step}: {what}" for what, is_so in wrong.items() if is_so]


@dataclass
class Verdict:
    """End of a probe. problem: what is wrong with it, empty if nothing is; message: of an error."""

    probe: Probe
    problem: str = ""
    message: str = ""
    distance: float = float("nan")
    seconds: float = 0.0
    findings: Findings = field(default_factory=Findings)


class OutOfTimeError(Exception):
    """The time limit is over."""


def judge(probe: Probe, folder: Path) -> Verdict:
    """Drive a probe to its end, with its files in `folder`, and say what is wrong with the way it ends."""
    verdict = Verdict(probe)
    began = time.process_time()
    try:
        with warnings.catch_warnings(), time_limit(probe.seconds):
            warnings.simplefilter("error")
            found = solve_parts(_written(probe, folder), folder, verdict.findings)
            verdict.problem = "; ".join(verdict.findings.wrong) or _missed(probe, found, verdict)
    except FretsolveError as error:
        verdict.message = str(error)
        verdict.problem = "; ".join(verdict.findings.wrong) or _misrefused(probe, error)
    except OutOfTimeError:
        verdict.problem = f"not done after {probe.seconds:g} s and {verdict.findings.increments} increments"
    except Exception as error:
        verdict.problem = f"{type(error).__name__}: {error}"
    verdict.seconds = time.process_time() - began
    return verdict


def solve_parts(parts: Parts, folder: Path, findings: Findings | None = None) -> Run:
    """Solve the case of `parts`, and write down in `findings` what is seen of its increments."""
    file = folder / "case.yaml"
    file.write_text(yaml.safe_dump(whole(parts), sort_keys=False), encoding="utf-8")
    setup = set_up(load_case(file))
    states = []
    for state in run(setup):
        states.append(state)
        if findings is not None:
            findings.examine(state, setup.case.solver.tolerance)
    return Run(parts, folder, setup, states)


def led(*stages: Parts, points: Any = None, size: Any = None, **parts: Any) -> Parts:
    """Return the parts of a case that is led through `stages`, on a grid of `points` and `size`."""
    grid = {name: value for name, value in (("points", points), ("size", size)) if value is not None}
    given: Parts = {"grid": grid} if grid else {}
    return given | ({"load_path": list(stages)} if stages else {}) | parts


def by(increments: int, **loads: float) -> Parts:
    """Return a stage that reaches `loads` in so many increments."""
    return loads | {"increments": increments}


def whole(parts: Parts) -> Parts:
    """`parts` with defaults for what they leave out, in values that YAML can write."""
    filled = {"bodies": SIMILAR, "surface": SPHERE, "grid": {"points": 32}, "friction": 0.1, "load_path": [{"P": LOAD}]}
    plain = _plain(filled | parts)
    assert isinstance(plain, dict)
    return plain


def _plain(value: Any) -> Any:
    """Lists for tuples, Python's numbers for NumPy's, and copies, which YAML writes out in place of references."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value.item() if isinstance(value, np.generic) else value


def _parts(probe: Probe) -> Parts:
    return probe.parts() if callable(probe.parts) else probe.parts


def _written(probe: Probe, folder: Path) -> Parts:
    """The probe's parts, with its height map saved."""
    parts = _parts(probe)
    if probe.heights is None:
        return parts
    np.save(folder / "map.npy", probe.heights())
    surface = parts.get("surface", [])
    others = surface if isinstance(surface, list) else [surface]
    return parts | {"surface": [{"heights": {"file": "map.npy", "spacing": probe.spacing, "override": True}}, *others]}


def _missed(probe: Probe, found: Run, verdict: Verdict) -> str:
    """Return what is wrong with a case that was solved."""
    if probe.refused is not None and not probe.may_solve:
        return f"solved, where {probe.refused.__name__} is right"
    if probe.theory is None:
        return ""
    verdict.distance = float(probe.theory(found))
    if verdict.distance <= probe.allowed:
        return ""
    return f"{verdict.distance:.3g} from the limit of theory, {probe.allowed:.3g} is allowed"


def _misrefused(probe: Probe, error: FretsolveError) -> str:
    """Return what is wrong with an error."""
    text = str(error)
    if probe.refused is None or not isinstance(error, probe.refused):
        wanted = "a certified result" if probe.refused is None else probe.refused.__name__
        return f"{wanted} is right, not {type(error).__name__}: {text}"
    if error.exit_code not in (2, 3):
        return f"exit code {error.exit_code}: {text}"
    if "\n" in text or len(text) > ENOUGH_WORDS + len(str(getattr(error, "file", ""))):
        return f"not one line to a person: {text}"
    return "" if _says(probe.says, text) else f"the message does not say {probe.says!r}: {text}"


def _says(pattern: str, text: str) -> bool:
    return re.search(pattern, text) is not None and not re.search(r"\bnan\b", text)


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Raise OutOfTimeError in the block after so many seconds of the processor; in the main thread only."""

    def ring(*_: object) -> None:
        raise OutOfTimeError

    before = signal.signal(signal.SIGPROF, ring)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
