"""What a run tells: words for people, JSON for programs, or nothing. Errors are told elsewhere, and always."""

from __future__ import annotations

import math
import shlex
import sys
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fretsolve import __version__
from fretsolve import kernels as pointwise
from fretsolve.commands.case_summary import accuracy_lines, grid_line, model_lines, stage_lines, warn
from fretsolve.commands.progress import Bar, Details, JsonLines, Lines, Silence, event
from fretsolve.errors import dotted
from fretsolve.export.text_report import print_report
from fretsolve.result import open_result
from fretsolve.setup.accuracy import verdict
from fretsolve.setup.cost_estimate import disk_problem
from fretsolve.setup.hertz import hertz_contact
from fretsolve.setup.resolution import doubt_of_result
from fretsolve.setup.warnings import doubts

if TYPE_CHECKING:
    from fretsolve.commands.run import Order
    from fretsolve.result import HistoryWriter, Result
    from fretsolve.setup.problem_setup import ProblemSetup

MOST_STAGES_SHOWN = 30
"""A longer load path is not printed as a table at the end: `show` prints it when asked to."""


class Quiet:
    """Tells nothing of a run but what makes its result doubtful, before it, on the way and at its end."""

    def __init__(self, setup: ProblemSetup, order: Order):
        self.setup, self.order = setup, order

    @property
    def counts(self) -> tuple[int, int]:
        """Increments and stages of the whole path."""
        return self.setup.load_path.increments, len(self.setup.load_path.last_steps)

    def begin(self, writer: HistoryWriter) -> None:
        """Tell what is about to be solved, and what a person should hear of it."""
        for text in self.doubts():
            self.warn(text)

    def doubts(self) -> Iterator[str]:
        """What a person should hear before the run."""
        yield from doubts(self.setup)
        too_large = None if self.order.resume else disk_problem(self.setup, self.order.output)
        if too_large is not None:
            yield f"{dotted(too_large.key)}: {too_large.message}"

    def progress(self, done: int) -> Silence:
        """What tells of each increment; `done` of them are there already."""
        return Silence(*self.counts, done)

    def warn(self, text: str) -> None:
        """Tell of something met on the way."""
        warn(self.setup, text)

    def already(self, increments: int) -> None:
        """Tell that there is nothing to do."""

    def stopped(self, increments: int) -> None:
        """Tell that a signal has ended the run, and how it goes on."""

    def end(self) -> None:
        """Tell what came out and where it lies."""
        with open_result(self.order.output) as result:
            self.tell_of_resolution(result)
            self.tell_of_accuracy(result)

    def tell_of_resolution(self, result: Result) -> None:
        """Tell of a contact of few cells."""
        doubt = doubt_of_result(self.setup, hertz_contact(self.setup), result)
        if doubt is not None:
            self.warn(doubt)

    def tell_of_accuracy(self, result: Result) -> None:
        """Tell whether an accuracy that was asked for is not met."""
        reached = verdict(result.effective_case.get("solver", {}), result.history)
        if reached is not None and not reached.met:
            self.warn(str(reached))


class Words(Quiet):
    """Lines and a table, with a bar on a terminal."""

    def begin(self, writer: HistoryWriter) -> None:
        """Tell the model and the reasons for it, the grid, and what a person should hear."""
        setup, order = self.setup, self.order
        if pointwise.WHY_NOT:
            print(f"numba cannot be used, so the run is slower: {pointwise.WHY_NOT}", file=sys.stderr)
        print(setup.case.title or order.case.name)
        print(f"result: {order.output}")
        for line in model_lines(setup.model):
            print(line)
        print(f"grid: {grid_line(setup)}")
        for line in accuracy_lines(setup):
            print(line)
        done = f", {len(writer.summaries)} of them done" if writer.summaries else ""
        count = setup.load_path.increments
        print(f"{count} increment{'s' if count > 1 else ''}{done}", flush=True)
        super().begin(writer)
        for note in writer.notes:
            print(f"warning: {note}", file=sys.stderr)

    def progress(self, done: int) -> Silence:
        return (Bar if sys.stdout.isatty() else Lines)(*self.counts, done)

    def already(self, increments: int) -> None:
        print(f"{self.order.output}: already complete, {increments} increments")

    def stopped(self, increments: int) -> None:
        done = f"stopped with {increments} of {self.setup.load_path.increments} increments saved"
        print(f"{done}; to go on: {resuming(self.order)}", file=sys.stderr)

    def end(self) -> None:
        with open_result(self.order.output) as result:
            if result.increments and result.history["stage"][-1] <= MOST_STAGES_SHOWN:
                print_report(result, heading=False)
            self.tell_of_resolution(result)
            self.tell_of_accuracy(result)
            compiling = pointwise.compile_seconds()
            if compiling:
                print(f"{compiling:.3g} s besides to compile the kernels, which are kept for later runs")
            print(f"{result.status}: {self.order.output}, {result.increments} increments", flush=True)


class Everything(Words):
    """Words, and with them the stages, how it is computed, and all of the history of each increment."""

    def begin(self, writer: HistoryWriter) -> None:
        """The same, with the stages and how they are computed."""
        super().begin(writer)
        for line in stage_lines(self.setup):
            print(line)
        case = self.setup.case
        kernels = "compiled by numba" if pointwise.COMPILED else "NumPy"
        print(
            f"fretsolve {__version__}, kernels: {kernels}, threads: {self.order.threads},"
            f" tolerance: {case.solver.tolerance:g}, at most {case.solver.max_iterations} iterations",
            flush=True,
        )

    def progress(self, done: int) -> Silence:
        return Details(*self.counts, done)


class Events(Quiet):
    """One JSON object per line, each with the key `event`: start, warning, increment, end."""

    def begin(self, writer: HistoryWriter) -> None:
        """Print the event `start`, and a `warning` for each thing that a person should hear."""
        setup, grid = self.setup, self.setup.grid
        increments, stages = self.counts
        event(
            "start",
            fretsolve_version=__version__,
            case=str(self.order.case),
            title=setup.case.title,
            result=str(self.order.output),
            increments=increments,
            stages=stages,
            done=len(writer.summaries),
            points=list(grid.shape),
            size=list(grid.size),
            coupling=setup.model.coupling,
            **({} if setup.case.solver.accuracy is None else {"accuracy_picks": list(setup.picked)}),
            model=[asdict(decision) for decision in setup.model.decisions],
        )
        for text in (*([pointwise.WHY_NOT] if pointwise.WHY_NOT else []), *self.doubts(), *writer.notes):
            self.warn(text)

    def progress(self, done: int) -> Silence:
        return JsonLines(*self.counts, done)

    def warn(self, text: str) -> None:
        event("warning", message=text)

    def already(self, increments: int) -> None:
        event("end", status="complete", result=str(self.order.output), increments=increments)

    def stopped(self, increments: int) -> None:
        event(
            "end",
            status="stopped",
            result=str(self.order.output),
            increments=increments,
            resume=resuming(self.order),
        )

    def end(self) -> None:
        with open_result(self.order.output) as result:
            self.tell_of_resolution(result)
            event("end", **_outcome(result, self.order.output))


def _outcome(result: Result, out: Path) -> Mapping[str, Any]:
    known: dict[str, Any] = {"status": result.status, "result": str(out), "increments": result.increments}
    reached = verdict(result.effective_case.get("solver", {}), result.history)
    if reached is not None:
        worst = None if math.isnan(reached.worst) else reached.worst
        known["accuracy"] = {**asdict(reached), "worst": worst, "met": reached.met}
    failure = {"message": str(result.attributes["failure"])} if "failure" in result.attributes else {}
    return {**known, **failure, "compile_time": pointwise.compile_seconds()}


def teller(setup: ProblemSetup, order: Order) -> Quiet:
    """What suits what the command line asks for."""
    kind = Events if order.log_json else Quiet if order.quiet else Everything if order.verbose else Words
    return kind(setup, order)


def resuming(order: Order) -> str:
    """The command that goes on with a run."""
    out = ["-o", str(order.out)] if order.out else []
    sets = [word for override in order.overrides for word in ("--set", override)]
    return shlex.join(["fretsolve", "run", str(order.case), *out, *sets, "--resume"])
