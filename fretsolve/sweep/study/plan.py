"""The plan of a study: its varied keys, cases, quantities and reference, checked before anything runs."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from fretsolve.case.keys.quantity_names import OUTPUT_NAMES, dataset_name
from fretsolve.case.keys.unrolled_path import Stage, last_repetitions
from fretsolve.case.loading import EVERY_STAGE, CaseText, read_case
from fretsolve.errors import CaseError
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result.cycles.table import CYCLE_NAMES
from fretsolve.result.state import CORRECTED_SUFFIX
from fretsolve.simulation.accuracy.rounds import most_memory
from fretsolve.sweep.manifest import Manifest
from fretsolve.sweep.plan import SIDE_OUTPUTS, BaseCase, PreparedCase
from fretsolve.sweep.quantity import (
    CORRECTED_NAMES,
    NEEDED_KEYS,
    StageQuantity,
    expected_values,
    in_order,
    needed_key,
    read_quantities,
    usual_quantities,
)
from fretsolve.sweep.sweep_file import Point, Value, crossed, problem_of


def changes_the_problem(key: str) -> bool:
    """Return whether the exact solution depends on `key`, so that differences are not errors."""
    first, _, rest = key.partition(".")
    return first in ("bodies", "surface", "friction") or (
        first in ("load_path", "stage") and rest.rpartition(".")[2] not in ("increments", "spacing")
    )


def points_along(key: str, values: Iterable[str]) -> list[Point]:
    """Return the values of a key as an axis of a sweep."""
    return [(Value(key, value, f"--vary {key}={value}", tuple(key.split("."))),) for value in values]


def words(settings: Mapping[str, str], *, line: bool = False) -> str:
    """Return settings for a sentence, such as ``64 x 64, 10 increments per stage, tolerance 1e-4``.

    line: of a line contact, ``64 points``.
    """
    return ", ".join(_words(key, value, line) for key, value in settings.items())


def short(settings: Mapping[str, str]) -> str:
    """Return the values alone, for a label."""
    return ", ".join(settings.values())


def read_variation(text: str) -> tuple[str, tuple[str, ...]]:
    """Read ``KEY=A,B,C``. Commas within brackets or quotes separate nothing. Raises CaseError.

    The key is dotted as `--set` takes it, or begins with one of `EVERY_STAGE`; the values are texts.
    """
    key, equals, rest = (part.strip() for part in text.partition("="))
    if not equals or not all(key.split(".")) or not rest:
        raise _refused("KEY=A,B,C is needed, such as grid.points=32,64,128", text)
    if problem := problem_of(key):
        raise _refused(problem, text)
    values = tuple(_split(rest))
    if not all(values):
        raise _refused("a value is missing between two commas, or at an end", text)
    for value in values:
        if values.count(value) > 1:
            raise _refused(f"the value {value} is given twice; once is enough", text)
    return key, values


def _words(key: str, value: str, line: bool) -> str:
    stage, _, name = key.rpartition(".")
    if key == "grid.points" and line:
        return f"{value} points"
    if key == "grid.points":
        sides = value.strip("[] ").split(",")
        return " x ".join(side.strip() for side in (sides if len(sides) == 2 else 2 * sides))
    if name == "increments" and value.isdecimal():
        place = "per stage" if key.startswith(EVERY_STAGE) else f"in {stage}"
        return f"{value} increment{'' if int(value) == 1 else 's'} {place}"
    return f"{name.replace('_', ' ')} {value}"


def _split(text: str) -> Iterator[str]:
    start, depth, quote = 0, 0, ""
    for index, character in enumerate(text):
        if quote:
            quote = "" if character == quote else quote
        elif character in "'\"":
            quote = character
        elif character == "," and not depth:
            yield text[start:index].strip()
            start = index + 1
        else:
            depth += (character in "[{(") - (character in "]})")
    yield text[start:].strip()


def _refused(message: str, text: str) -> CaseError:
    return CaseError(message, (), f"--vary {text if text.isprintable() else repr(text)}")


ReferenceKind = Literal["finest", "closed-form", "expect"]

NOUNS = {"closed-form": "closed form", "expect": "expected value"}

OF_MINDLIN = ("delta_x", "delta_y", "stick_radius", "stick_area", "work_total")
"""Quantities that Cattaneo and Mindlin give under forces."""


@dataclass(frozen=True)
class StudyRequest:
    """A study as the command line has it, as text. varied: keys with their values; kind: of the reference.

    corrected: compare values corrected for the number of increments.
    """

    case: Path
    overrides: Sequence[str]
    varied: Sequence[str]
    quantities: Sequence[str]
    kind: ReferenceKind
    corrected: bool = False


@dataclass(frozen=True)
class StudyPlan:
    """A study: a sweep in `manifest`, its `cases` in the order of its rows, and what they are compared with.

    variations: the varied keys with their values. First comes the finest run of the first problem, then the others by
    their estimated cost. known: the reference if it is known before any run, None for the finest run. unknown:
    quantities for which the reference has no value; why_unknown: the reason, empty if that is clear; corrected: values
    corrected for the number of increments are compared.
    """

    manifest: Manifest
    cases: tuple[PreparedCase, ...]
    variations: Mapping[str, tuple[str, ...]]
    quantities: tuple[StageQuantity, ...]
    unknown: tuple[StageQuantity, ...]
    why_unknown: str
    kind: ReferenceKind
    known: Mapping[StageQuantity, float] | None
    corrected: bool = False

    def column(self, quantity: StageQuantity) -> str:
        """Return the name of the column of a quantity, such as ``delta_x@2`` or ``delta_x_corrected@2``."""
        corrected = replace(quantity, name=quantity.name + CORRECTED_SUFFIX)
        return str(corrected if self.corrected and corrected.name in CORRECTED_NAMES else quantity)

    @property
    def problem_keys(self) -> tuple[str, ...]:
        """The varied keys that change the problem itself, so that differences are not errors."""
        return tuple(filter(changes_the_problem, self.variations))

    @property
    def reference_words(self) -> str:
        """The reference in words."""
        if self.known is not None:
            return f"the {NOUNS[self.kind]}s"
        first = self.cases[0]
        settings = words(first.settings, line=first.setup.model.line)
        return f"the {'run with' if self.problem_keys else 'finest run,'} {settings}"


def make_study_plan(request: StudyRequest, folder: Path) -> StudyPlan:
    """Read a request, and check every run. Raises CaseError, FileError. folder: of the results."""
    case, quantities, kind = request.case, request.quantities, request.kind
    axes = list(map(read_variation, request.varied))
    changing = [(key, values) for key, values in axes if changes_the_problem(key)]
    if changing and kind != "finest":
        message = (
            f"changes the problem itself, and --truth {kind} holds for one problem only; vary the grid, increments or"
            " settings of the solver, or leave --truth out"
        )
        raise CaseError(message, (), f"--vary {changing[0][0]}")
    needed = {needed_key(one.partition("@")[0].strip()) for one in quantities} - {"", *NEEDED_KEYS}
    base = _base(request, needed)
    cases = list(base.prepare_all(crossed(points_along(*axis) for axis in axes), folder))
    for key in sorted(needed):
        if any(key.removeprefix("output.") not in one.beside for one in cases):
            raise CaseError(f"what --quantity names is known from such runs alone; {key} is needed", (), case)
    costliest = finest([one for one in cases if all(one.settings[key] == values[0] for key, values in changing)])
    setup = costliest.setup
    stages = min((one.setup.load_path.stages for one in cases), key=len)
    judged = sorted(last_repetitions(stages).values())
    named = (one.stage for text in quantities for one in read_quantities(text, judged, len(stages)))
    known = known_values(kind, setup, {*judged, *named})
    compared, unknown = compared_quantities(quantities, stages, setup, kind, known)
    if not compared:
        raise CaseError("nothing to compare; name it with --quantity, such as --quantity delta_z", (), case)
    of_mindlin = kind == "closed-form" and any(one.name in OF_MINDLIN for one in unknown)
    why = setup.closed_forms.why_not_mindlin if of_mindlin else ""
    cases.sort(key=lambda one: (one is not costliest, one.expected.seconds))
    manifest = Manifest(
        folder,
        case,
        setup.case.title or case.name,
        case,
        base.overrides,
        tuple(map(str, compared)),
        base.threads,
        max(most_memory(one.first, one.expected.memory) for one in cases),
        tuple(one.row(index) for index, one in enumerate(cases)),
        results_name="",
    )
    return StudyPlan(manifest, tuple(cases), dict(axes), compared, unknown, why, kind, known, request.corrected)


def _base(request: StudyRequest, needed: Collection[str]) -> BaseCase:
    """Return the base case of a study, without fields and files beside results that no quantity needs.

    A study compares scalars; without fields a result takes some tens of kilobytes. It finds errors itself, but only
    runs with error bars have corrected values.
    """
    text, overrides = read_case(request.case), request.overrides
    text.case(overrides)  # tells mistakes before anything is left out
    for name in SIDE_OUTPUTS:
        if f"output.{name}" not in needed:
            text, overrides = _without(name, text, overrides)
    text, overrides = _expecting_of(needed, text, overrides)
    fields = "output.fields=[pressure, shear]" if needed else "output.fields=[]"
    # the rounds of an accuracy have error bars anyway
    rounds = text.case(overrides).solver.accuracy is not None or any("accuracy" in one for one in request.varied)
    bars = () if rounds else (f"solver.error_bars={str(request.corrected).lower()}",)
    return BaseCase.of(text, overrides, last=(fields, *bars))


def _without(name: str, text: CaseText, overrides: Sequence[str]) -> tuple[CaseText, Sequence[str]]:
    """Return a case and overrides that do not ask for stress, fatigue or a crack, which take fields."""
    output = text.data.get("output") if isinstance(text.data, dict) else None
    if isinstance(output, dict) and name in output:
        kept = {key: value for key, value in output.items() if key != name}
        text = replace(text, data={**text.data, "output": kept})
    return text, [one for one in overrides if not one.strip().startswith(f"output.{name}")]


def _expecting_of(needed: Collection[str], text: CaseText, overrides: Sequence[str]) -> tuple[CaseText, Sequence[str]]:
    """Return a case and overrides that expect only what the runs know; needed: the files beside results that stay."""
    unknown = {"slip_amplitude"}.union(*(of for kind, of in OUTPUT_NAMES.items() if f"output.{kind}" not in needed))
    expect = text.data.get("expect") if isinstance(text.data, dict) else None
    if not isinstance(expect, list):
        return text, overrides
    kept = [one for one in expect if not (isinstance(one, dict) and dataset_name(str(one.get("quantity"))) in unknown)]
    if len(kept) == len(expect):
        return text, overrides
    text = replace(text, data={**text.data, "expect": kept})
    return text, [one for one in overrides if not one.strip().startswith("expect.")]


def finest(cases: Sequence[PreparedCase]) -> PreparedCase:
    """Return the run with the most points, then increments, then terms of the model, then the least tolerance."""

    def rank(case: PreparedCase) -> tuple[float, ...]:
        nx, ny = case.setup.grid.shape
        terms = case.setup.model.terms
        kept = sum((terms.tangential, terms.in_plane_coupling, terms.normal_tangential_coupling))
        return nx * ny, case.setup.load_path.increments, kept, -case.setup.case.solver.tolerance

    return max(reversed(cases), key=rank)


def known_values(
    kind: ReferenceKind, setup: ProblemSetup, stages: Collection[int]
) -> Mapping[StageQuantity, float] | None:
    """Return what is known of the finest run before it is made; None if that run itself is the reference.

    stages: those that may be compared (from 1), of closed forms. Raises CaseError if nothing is known.
    """
    if kind == "finest":
        return None
    if kind == "closed-form":
        on_rig = () if setup.on_rig is None else setup.on_rig.values()
        forms = (*setup.closed_forms.values({stage - 1 for stage in stages}), *on_rig)
        known = {StageQuantity(form.quantity, form.stage + 1): form.value for form in forms}
        if not known:
            raise CaseError(
                "--truth closed-form: no closed form is known for this case; those of Hertz, Cattaneo and Mindlin, and"
                " Lubkin are: a single sphere (Hertz: or ellipsoid) under forces, upright, with uncoupled bodies"
                " (Hertz: and no layer that is compressed, else: no layer)",
                (),
                setup.case.source.path,
            )
        return known
    known = {quantity: value for quantity, value in expected_values(setup).items() if math.isfinite(value)}
    if not known:
        raise setup.case.source.problem(
            "the case expects nothing that --truth expect could compare with; give a list such as"
            " [{quantity: delta_z, value: 9 um, rel: 1 %}]",
            ("expect",),
        )
    return known


def compared_quantities(
    texts: Sequence[str],
    stages: Sequence[Stage],
    setup: ProblemSetup,
    kind: ReferenceKind,
    known: Mapping[StageQuantity, float] | None,
) -> tuple[tuple[StageQuantity, ...], tuple[StageQuantity, ...]]:
    """Return the quantities that are compared, and the quantities for which the reference has no value.

    ``--quantity`` names them, by default they are the usual ones. A name without a stage means the ends of all stages,
    of a repeated cycle the last repetition. Raises CaseError.
    """
    judged = sorted(last_repetitions(stages).values())
    found: list[StageQuantity] = []
    for text in texts:
        named = read_quantities(text, judged, len(stages))
        _require_known(text, named, setup, kind, known)
        found += named
    wanted = in_order(found) or usual_quantities(setup, judged)
    wanted = tuple(one for one in wanted if one.stage <= len(stages) or one.name in CYCLE_NAMES)
    if known is None:
        return wanted, ()
    have = tuple(one for one in wanted if one in known)
    if not texts and (kind == "expect" or not have):
        imposed = setup.load_path.imposed
        stated = [
            one
            for one in known
            if one.name in CYCLE_NAMES or (one.stage <= len(stages) and one.name not in imposed[one.stage - 1])
        ]
        return in_order(stated), () if kind == "expect" else wanted
    return have, tuple(one for one in wanted if one not in known)


def _require_known(
    text: str,
    named: Sequence[StageQuantity],
    setup: ProblemSetup,
    kind: ReferenceKind,
    known: Mapping[StageQuantity, float] | None,
) -> None:
    """Raise CaseError unless the runs have what `text` names, and the reference has at least one value of `text`."""
    name = named[0].name
    message = ""
    if (key := needed_key(name)) in NEEDED_KEYS and getattr(setup.case, key) is None:
        message = f"it is known with {key} alone; {key} in the case is needed"
    elif name in CORRECTED_NAMES:
        as_run = name.removesuffix(CORRECTED_SUFFIX)
        message = f"corrected values are compared with --corrected; give it, and --quantity {as_run}"
    elif known is not None and not any(one in known for one in named):
        same_name = [str(one) for one in in_order(known) if one.name == name]
        there = ", ".join(same_name or dict.fromkeys(one.name for one in in_order(known)))
        why = setup.closed_forms.why_not_mindlin if kind == "closed-form" and name in OF_MINDLIN else ""
        message = f"--truth {kind}: it has no {NOUNS[kind]}; these have: {there}{'; ' if why else ''}{why}"
    if message:
        raise CaseError(message, (), f"--quantity {text}")
