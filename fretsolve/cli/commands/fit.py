"""``fretsolve fit``: find friction, stiffness of the rig and other parameters of a case from a measured loop."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from fretsolve.cli.commands.plot import require_matplotlib
from fretsolve.errors import CaseError
from fretsolve.post.export.text_report import report_console
from fretsolve.sweep.fit.case_file import MARK, rewritten
from fretsolve.sweep.fit.least_squares import Fit, fit_loop
from fretsolve.sweep.fit.model_loop import LoopModel
from fretsolve.sweep.fit.plan import FitPlan, FitRequest, make_fit_plan
from fretsolve.sweep.fit.report import FIRST_COLUMNS, doubts, exceeded, notes, tables, words, write_fit_csv
from fretsolve.system import atomic_files
from fretsolve.system.files import PICTURE_MARK, require_folder, require_other, require_own, writing
from fretsolve.system.progress import key_value_line, print_error_line, print_warnings

EXIT_UNDETERMINED = 1


def fit_case(out: Path | None, jobs: int, *, quiet: bool, **asked: Any) -> int:
    """Fit a case to a loop, write what was found and report. Return 0, or 1 if a bound exceeds its parameter.

    out: name of the files without an ending, None for the loop's name with .fit; asked: the fields of a `FitRequest`.
    """
    request = FitRequest(**asked)
    if request.loop.is_dir():
        raise CaseError("is a folder; the measured loop is a CSV file", (), request.loop)
    base = out or request.loop.with_suffix(".fit")
    require_folder(base)
    table, picture, case = (base.with_name(base.name + ending) for ending in (".csv", ".png", ".yaml"))
    for path, mark, what in (
        (table, FIRST_COLUMNS, "the table of a fit"),
        (picture, PICTURE_MARK, "a picture"),
        (case, MARK, "the case file of a fit"),
    ):
        require_other(path, request.loop, "the measured loop")
        require_other(path, request.case, "the case")
        require_own(path, mark.encode(), what)
    plan = make_fit_plan(request)
    if not quiet:
        _announce(plan)
    fit = fit_loop(plan, jobs, (lambda *_: None) if quiet else partial(_show, plan))
    write_fit_csv(table, fit)
    _write_case(case, fit)
    drawn = _draw(picture, fit)
    if not quiet:
        console = report_console()
        for one in tables(fit):
            console.print(one)
        for line in notes(fit):
            print(line)
        print(f"written: {', '.join(map(str, [table, case, *([picture] if drawn else [])]))}", flush=True)
    if plan.reached is not None and not plan.reached.met:
        print_warnings(request.case, str(plan.reached))
    print_warnings(request.loop, *doubts(fit))
    return EXIT_UNDETERMINED if exceeded(fit) else 0


def _announce(plan: FitPlan) -> None:
    loop = plan.loop
    names = ", ".join(f"{one.name} from {one.written(one.start, 5)}" for one in plan.parameters)
    print(f"fitting {names}")
    print(f"{plan.request.loop}: the last whole cycle has {len(loop.force)} points", flush=True)


def _show(plan: FitPlan, solved: int, model: LoopModel, values: Sequence[float], rms: float) -> None:
    found = {one.name: one.written(value, 5) for one, value in zip(plan.parameters, values, strict=True)}
    points = "case" if model.points is None else model.points
    key_value_line(solved=solved, points=points, **found, residual=f"{rms / plan.loop.range:.3%}")


def _write_case(path: Path, fit: Fit) -> None:
    """Write the case with the values that were found."""
    parameters = fit.plan.parameters
    values = {one.key: one.written(value, 6) for one, value in zip(parameters, fit.values, strict=True)}
    found = ", ".join(words(fit, place) for place in range(len(parameters)))
    with writing(path):
        atomic_files.write_text(path, rewritten(fit.plan.text, values, f"{found}, from {fit.plan.request.loop.name}"))


def _draw(path: Path, fit: Fit) -> bool:
    """Write the picture, or print what it needs and return False."""
    try:
        require_matplotlib()
    except CaseError as error:
        print_error_line(f"{path}: not drawn: {error}")
        return False
    from fretsolve.post.plots.canvas import rendered
    from fretsolve.sweep.fit.plot import fit_picture

    parameters = fit.plan.parameters
    title = fit.plan.case.title or fit.plan.request.case.name
    detail = ", ".join(words(fit, place) for place in range(len(parameters)))
    content = rendered(fit_picture(fit, title, detail), "png")
    with writing(path), atomic_files.new_file(path) as file:
        file.write(content)
    return True
