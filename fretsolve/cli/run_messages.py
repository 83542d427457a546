"""Print the messages of `fretsolve run`: text, JSON, or warnings alone. The command line prints the errors."""

from __future__ import annotations

import math
import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from fretsolve import __version__
from fretsolve.case.dimensions import cell_counts, counted, percent
from fretsolve.case.history import OF_RIG, SPOTS
from fretsolve.cli.case_summary import (
    accuracy_lines,
    grid_line,
    model_lines,
    path_length,
    represented_cycles,
    stage_lines,
)
from fretsolve.elastic.kernels import compile_seconds
from fretsolve.errors import printable
from fretsolve.post.export.remarks import spot_warnings, warning_of_wear
from fretsolve.problem.setup.cost_estimate import expected_increments
from fretsolve.problem.setup.map_warnings import hole_warnings
from fretsolve.problem.setup.warnings import case_warnings, warning_of_result
from fretsolve.problem.setup.wear_warnings import warning_of_slip, warning_of_the_grid
from fretsolve.problem.setup.yield_warnings import foreseen_yield
from fretsolve.result import HistoryWriter, Result, open_result
from fretsolve.result.state import Summary, SummaryErrors
from fretsolve.result.verdict import Verdict
from fretsolve.simulation.accuracy.rounds import Round
from fretsolve.system.progress import json_line, key_value_line, print_error_line, print_warnings, progress_bar

COMPILING = "compiling kernels, which takes up to 30 s the first time"


class QuietMessages:
    """Print warnings, what a run waits for, and how to go on after a signal, and nothing else.

    out: the result; resume: the run goes on with that result; goes_on: it has solved the round before.
    """

    def __init__(self, current: Round, out: Path, threads: int, *, resume: bool, goes_on: bool = False):
        self.setup, self.out, self.threads, self.resume = current.setup, out, threads, resume
        self.current, self.goes_on, setup = current, goes_on, current.setup
        self.source = setup.case.source
        self.increments, self.stages = setup.load_path.increments, len(setup.load_path.last_steps)
        self.cycles = represented_cycles(setup)

    @property
    def resuming(self) -> str:
        """The command that resumes the run."""
        out = [] if self.out == self.source.path.with_suffix(".h5") else ["-o", str(self.out)]
        sets = [word for override in self.source.overrides for word in ("--set", override.text)]
        return shlex.join(["fretsolve", "run", str(self.source.path), *out, *sets, "--resume"])

    def start(self, writer: HistoryWriter) -> None:
        """Print what is about to be solved, and all warnings unless the run goes on from the round before."""
        if self.goes_on:
            return
        for text in (*case_warnings(self.setup, None if self.resume else self.out), *writer.notes):
            self.warn(text)

    @contextmanager
    def progress(self, done: int) -> Iterator[None]:
        """Show progress within the block; done: increments that are saved already."""
        yield

    def increment(self, summary: Summary, errors: SummaryErrors | None = None) -> None:
        """Print an increment that is saved, and its error bars if there are any."""

    def compiling(self) -> None:
        """Print that the kernels are being compiled, for which the run waits."""
        print_error_line(COMPILING)

    def warn(self, text: str) -> None:
        """Print a warning."""
        print_warnings(self.source.path, text)

    def already_complete(self, increments: int) -> None:
        """Print that nothing is left to solve."""

    def stopped(self, increments: int) -> None:
        """Print that a signal has stopped the run, and how to resume it."""
        expected = expected_increments(self.setup)
        of = "" if expected == self.increments else "about "
        done = f"stopped with {increments} of {of}{counted(max(expected, increments), 'increment')} saved"
        print(f"{done}; to go on: {self.resuming}", file=sys.stderr)

    def end(self, reached: Verdict | None = None) -> None:
        """Print the outcome and where it is saved; reached: the verdict on the accuracy, if one was asked for."""
        with open_result(self.out) as result:
            self._report(result, reached)

    def _history(self, summary: Summary, errors: SummaryErrors | None) -> dict[str, Any]:
        """Return all that the history keeps of an increment: spots where they are counted, the actuator with a rig."""
        values = {name: value for name, value in vars(summary).items() if name not in SPOTS or value >= 0}
        values |= vars(errors) if errors is not None else {}
        rig = self.setup.model.rig is not None
        return {name: value for name, value in values.items() if rig or not name.startswith(OF_RIG)}

    def _holes(self, result: Result) -> Iterator[str]:
        """Yield warnings of holes in the largest contact of which the result has the pressure."""
        if "pressure" in result.fields and any(surface.kind == "heights" for surface in self.setup.case.surface):
            widest = max(result.steps, key=lambda step: result.history["contact_cells"][step])
            yield from hole_warnings(self.setup, result.field("pressure", widest) > 0.0)

    def _yielding(self, result: Result) -> Iterator[str]:
        """Yield a line for each body that yields, except for bodies whose stresses are computed and tell it then."""
        case = self.setup.case
        if all(body == "rigid" or body.yield_stress is None for body in case.bodies):
            return
        from fretsolve.post.stress.yielding import yield_lines  # other cases do not need it

        stress = case.output.stress if result.status == "complete" else None
        later = () if stress is None else stress.bodies or ((1,) if case.bodies[1] == "rigid" else (2,))
        lines = yield_lines(result, foreseen_yield(self.setup))
        yield from (text for body, text in lines.items() if body not in later)

    def _report(self, result: Result, reached: Verdict | None) -> None:
        too_few = warning_of_result(self.setup, result.history["contact_cells"])
        for text in (too_few, *self._holes(result), reached if reached and not reached.met else None):
            if text is not None:
                self.warn(str(text))
        if jumps := {stage.wears.jumps for stage in self.setup.case.stages() if stage.wears is not None}:
            known = {one for one in jumps if one is not None}
            errors = warning_of_wear(result, known), warning_of_the_grid(result, known)
            for text in (*errors, warning_of_slip(self.setup, result.history)):
                if text is not None:
                    self.warn(text)
        if "spots" in result.history:
            for text in spot_warnings(result.history):
                self.warn(text)
        for text in self._yielding(result):
            self.warn(text)
        for text, periodic in result.cycles.outcomes if result.cycles is not None else ():
            if not periodic:
                self.warn(text)


class TextMessages(QuietMessages):
    """Print lines and a table, and a bar on a terminal.

    verbose: print the stages, the settings and the whole history of each increment as well, without a bar.
    """

    def __init__(
        self, current: Round, out: Path, threads: int, *, resume: bool, goes_on: bool = False, verbose: bool = False
    ):
        super().__init__(current, out, threads, resume=resume, goes_on=goes_on)
        self.verbose = verbose
        self.has_bar = sys.stdout.isatty() and not verbose

    def start(self, writer: HistoryWriter) -> None:
        """Print the model with its reasons, the grid and the warnings."""
        setup = self.setup
        if self.goes_on:
            last, number = self.current.before[-1], len(self.current.before)
            known = f"knows {last.quantity} to {percent(last.worst)}" if last.quantity else "has no error bars"
            finer = f"round {number + 1}: {cell_counts(setup.grid.shape)} points, {path_length(setup)}"
            print(f"round {number} {known}; {finer}", flush=True)
            return
        print(printable(setup.case.title or self.source.path.name))
        print(printable(f"result: {self.out}"))
        for line in (*model_lines(setup.model), f"grid: {grid_line(setup)}", *accuracy_lines(self.current)):
            print(line)
        done = f", {writer.increments} of them done" if writer.increments else ""
        print(f"{path_length(setup)}{done}", flush=True)
        super().start(writer)
        if self.verbose:
            for line in stage_lines(setup):
                print(line)
            compiled, solver = "compiled by numba" if setup.compiled else "NumPy", setup.case.solver
            print(f"fretsolve {__version__}, kernels: {compiled}, threads: {self.threads}", end=", ")
            print(f"tolerance: {solver.tolerance:g}, at most {solver.max_iterations} iterations", flush=True)

    @contextmanager
    def progress(self, done: int) -> Iterator[None]:
        if not self.has_bar:
            yield
            return
        texts = (f"stage {{task.fields[stage]}}/{self.stages}", "{task.fields[detail]}")
        total = float(self.increments)
        if cycles := self.cycles:
            texts, total, done = ("cycles", "{task.fields[detail]}"), cycles, 0
        with progress_bar(*texts, counted=True) as self._bar:
            self._bar.add_task("", total=total, completed=done, stage=1, detail="")
            yield

    def increment(self, summary: Summary, errors: SummaryErrors | None = None) -> None:
        """Show a solved increment in the bar, or print it as a line."""
        if self.has_bar:
            iterations = summary.iterations_normal + summary.iterations_tangential
            detail = f"{iterations} iterations, residual {summary.worst_residual:.1e}"
            completed = summary.cycles if self.cycles else summary.step + 1
            self._bar.update(self._bar.task_ids[0], completed=completed, stage=summary.stage, detail=detail)
            return
        values: dict[str, Any] = {
            "step": summary.step,
            "increments": self.increments,
            "stage": summary.stage,
            "stages": self.stages,
            "iterations_normal": summary.iterations_normal,
            "iterations_tangential": summary.iterations_tangential,
            "residual": f"{summary.worst_residual:.1e}",
            "work_total": f"{summary.work_total:.6g}",
            "wall_time": f"{summary.wall_time:.3g}",
        }
        if total := self.cycles:
            del values["increments"], values["stages"]  # they are the most that there may be
            values |= {
                "cycles": f"{summary.cycles:.6g}",
                "of": f"{total:.6g}",
                "wear_volume": f"{summary.wear_volume:.6g}",
            }
        if self.verbose:
            values |= {name: f"{v:.6g}" for name, v in self._history(summary, errors).items() if name not in values}
        key_value_line(**values)

    def compiling(self) -> None:
        say = self._bar.console.print if self.has_bar else partial(print, flush=True)
        say(COMPILING)

    def already_complete(self, increments: int) -> None:
        print(f"{self.out}: already complete, {counted(increments, 'increment')}")

    def _report(self, result: Result, reached: Verdict | None) -> None:
        if result.increments and result.history["stage"][-1] <= 30:  # of more `fretsolve show` prints one
            from fretsolve.post.export.text_report import print_report

            print_report(result, heading=False, reached=reached)
        elif reached is not None:
            print(reached)
        super()._report(result, reached)
        if compiling := compile_seconds():
            print(f"compiling the kernels took {compiling:.3g} s more; they are kept for later runs")
        print(f"{result.status}: {self.out}, {counted(result.increments, 'increment')}", flush=True)


class JsonMessages(QuietMessages):
    """Print a JSON object per line; its key `event` is start, warning, increment, round or end."""

    def start(self, writer: HistoryWriter) -> None:
        """Print the event `start`, and a `warning` for each warning of the case; or `round` for a later round."""
        setup, grid = self.setup, self.setup.grid
        if self.goes_on:
            last = self.current.before[-1]
            known = {"quantity": last.quantity, "worst": last.worst if last.quantity else None}
            number = len(self.current.before) + 1
            json_line("round", round=number, before=known, increments=self.increments, points=list(grid.shape))
            return
        json_line(
            "start",
            fretsolve_version=__version__,
            case=str(self.source.path),
            title=setup.case.title,
            result=str(self.out),
            increments=self.increments,
            stages=self.stages,
            done=writer.increments,
            points=list(grid.shape),
            size=list(grid.size),
            coupling=setup.model.coupling,
            **({} if setup.case.solver.accuracy is None else {"accuracy_picks": list(setup.picked)}),
            model=[asdict(decision) for decision in setup.model.decisions],
        )
        super().start(writer)

    def increment(self, summary: Summary, errors: SummaryErrors | None = None) -> None:
        json_line("increment", increments=self.increments, stages=self.stages, **self._history(summary, errors))

    def warn(self, text: str) -> None:
        json_line("warning", message=text)

    def already_complete(self, increments: int) -> None:
        self._end("complete", increments)

    def stopped(self, increments: int) -> None:
        self._end("stopped", increments, resume=self.resuming)

    def _end(self, status: str, increments: int, **more: Any) -> None:
        json_line("end", status=status, result=str(self.out), increments=increments, **more)

    def _report(self, result: Result, reached: Verdict | None) -> None:
        super()._report(result, None)
        outcome: dict[str, Any] = {}
        if reached is not None:
            worst = None if math.isnan(reached.worst) else reached.worst
            outcome["accuracy"] = {**asdict(reached), "worst": worst, "met": reached.met}
        if "failure" in result.attributes:
            outcome["message"] = str(result.attributes["failure"])
        self._end(result.status, result.increments, **outcome, compile_time=compile_seconds())
