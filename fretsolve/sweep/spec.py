"""The sweep file: pydantic models of its keys."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Discriminator, Field, StrictBool, StrictFloat, StrictInt, Tag, model_validator

from fretsolve.case.base import CaseModel, Count, refused_at
from fretsolve.case.quantities import shown

MOST_CASES = 1_000_000

Number = StrictInt | StrictFloat | str
"""A number, or text of a number with its unit."""


class Interval(CaseModel):
    """The interval from which a key of a Latin hypercube is drawn."""

    start: Number = Field(alias="from", description="first value, such as 100 N")
    to: Number = Field(description="last value, in the same unit")
    spacing: Literal["linear", "log"] = Field(default="linear", description="of the values: linear or log")


class Range(Interval):
    """Values between two ends, both included."""

    count: Annotated[int, Field(strict=True, ge=2, le=MOST_CASES)] = Field(description="how many values, such as 5")


class LatinHypercube(CaseModel):
    """Points that fill a box of several keys evenly, drawn at random from a seed."""

    samples: Annotated[int, Field(strict=True, ge=1, le=MOST_CASES)] = Field(description="how many points, such as 100")
    seed: Annotated[int, Field(strict=True, ge=0)] = Field(default=0, description="of the random numbers")
    over: dict[str, Interval] = Field(min_length=1, description="keys, each with from, to and spacing")


class CsvAxis(CaseModel):
    """Points from a CSV file: a column per key, a row per point, an empty cell for the case's own value."""

    csv: str = Field(description="name of the CSV file, relative to the sweep file")


class LatinHypercubeAxis(CaseModel):
    """Points of a Latin hypercube."""

    latin_hypercube: LatinHypercube


def _values_tag(value: object) -> str:
    return "(range)" if isinstance(value, dict | Range) else "(list)"


Values = Annotated[
    Annotated[Range, Tag("(range)")] | Annotated[tuple[Any, ...], Field(min_length=1), Tag("(list)")],
    Discriminator(_values_tag),
]


def _axis_tag(value: object) -> str:
    if isinstance(value, dict) and "csv" in value:
        return "(csv)"
    return "(latin hypercube)" if isinstance(value, dict) and "latin_hypercube" in value else "(keys)"


Axis = Annotated[
    Annotated[CsvAxis, Tag("(csv)")]
    | Annotated[LatinHypercubeAxis, Tag("(latin hypercube)")]
    | Annotated[dict[str, Values], Field(min_length=1), Tag("(keys)")],
    Discriminator(_axis_tag),
]
"""Keys that go together, value by value; a file or a random sample of such points."""


class SlurmSpec(CaseModel):
    """Resources of a task of a Slurm job array, and how many tasks there are."""

    cases_per_task: Count = Field(default=1, description="cases that a task runs one after another")
    at_once: Count | None = Field(default=None, description="tasks that may run at the same time")
    time: str | StrictInt | None = Field(default=None, description="limit of a task, such as '02:00:00' or minutes")
    memory: str | None = Field(default=None, description="of a task, such as 2G")
    warning: Count = Field(default=60, description="seconds before the limit at which a task stops and requeues")
    options: tuple[str, ...] = Field(default=(), description="more options of sbatch, such as --partition=main")
    setup: tuple[str, ...] = Field(default=(), description="lines of the script before fretsolve, such as module load")

    @model_validator(mode="after")
    def _options_are_words(self) -> Self:
        wrong = [(i, text) for i, text in enumerate(self.options) if not text.startswith("-") or "\n" in text]
        refused_at(
            (("options", i), f"{shown(text)} is not an option of sbatch; one such as --partition=main is needed")
            for i, text in wrong
        )
        return self


class SweepSpec(CaseModel):
    """Sweep file of fretsolve: a case, and the points of its keys at which it runs."""

    title: str | None = Field(default=None, description="for people")
    case: str = Field(description="name of the case file, relative to the sweep file")
    set: dict[str, Any] = Field(default={}, description="keys that are the same at all points, with their values")
    axes: tuple[Axis, ...] = Field(
        min_length=1, description="a list; keys of one entry go together, entries are crossed with one another"
    )
    quantities: tuple[str, ...] = Field(
        default=(),
        description="what is collected: NAME or NAME@STAGE, such as delta_x@2; by default responses to the load path",
    )
    threads: Count = Field(default=1, description="threads of each case")
    error_bars: StrictBool = Field(default=False, description="whether each case estimates its errors")
    slurm: SlurmSpec = Field(default=SlurmSpec(), description="resources under Slurm")
