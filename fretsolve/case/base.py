"""The base of all models of the case file, and annotations for its shorthands."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field, GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationError
from pydantic_core import CoreSchema, core_schema

from fretsolve.case.dimensions import LENGTH
from fretsolve.case.quantities import InUnits, refused, shown
from fretsolve.errors import KeyPath

Entries = TypeVar("Entries", bound=tuple[Any, ...])


class CaseModel(BaseModel):
    """A mapping of the case file. It cannot be changed, and other keys than its own are refused."""

    # Only `Case` builds a validator, when it is first used; its parts build validators if they are used alone.
    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)


@dataclass(frozen=True)
class Repeated:
    """Annotation of a tuple: in the file, a single value stands for `count` equal values."""

    count: int

    def expand(self, value: object) -> object:
        """Return the value as a list; None, which `auto` stands for, stays None."""
        return value if value is None or isinstance(value, list | tuple) else (value,) * self.count

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self.expand, handler(source))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        inner = handler(schema)
        array = next(node for node in inner.get("anyOf", [inner]) if node.get("type") == "array")
        one = array["prefixItems"][0] if "prefixItems" in array else array["items"]
        return {"anyOf": [one, array]}


@dataclass(frozen=True)
class Named:
    """Annotation of a value that a word may stand for. refusal: the message for other words, without the value."""

    words: Mapping[str, float | None] = field(hash=False)
    refusal: str

    def read(self, value: object) -> object:
        """Return what a word stands for, and any other value as it is."""
        if isinstance(value, str) and value in self.words:
            return self.words[value]
        if isinstance(value, str) and not any(map(str.isdigit, value)):
            raise refused(f"{shown(value)} {self.refusal} is needed")
        return value

    def write(self, value: object) -> object:
        """Return the word for None, and any other value as it is."""
        return value if value is not None else next(word for word, meant in self.words.items() if meant is None)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        writer = core_schema.plain_serializer_function_ser_schema(self.write)
        return core_schema.no_info_before_validator_function(self.read, handler(source), serialization=writer)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        inner = handler(schema)
        words = {"enum": list(self.words)} if len(self.words) > 1 else {"const": next(iter(self.words))}
        return {"anyOf": [words, *inner.get("anyOf", [inner])]}


def auto(example: str) -> Named:
    """Return the annotation of an optional value: in the file, None is written ``auto``. example: another value."""
    return Named({"auto": None}, f"is not allowed; auto or a value such as {example}")


def require_either(model: CaseModel, one: str, other: str) -> None:
    """Refuse a mapping that gives neither or both of two keys."""
    given = getattr(model, one) is not None
    if given == (getattr(model, other) is not None):
        raise refused(f"either {one} or {other} is needed; {'both are' if given else 'neither is'} given")


def refused_at(problems: Iterable[tuple[KeyPath, str]]) -> None:
    """Raise a validation error that lists `problems` (key within the validated value, message), if there are any."""
    lines = [{"type": refused(message), "loc": key, "input": None} for key, message in problems]
    if lines:
        raise ValidationError.from_exception_data("case", lines)  # type: ignore[arg-type]


def each_once(values: Entries) -> Entries:
    """Return a tuple as it is. Refuses values that stand in it twice."""
    repeated = [(index, value) for index, value in enumerate(values) if value in values[:index]]
    refused_at(((index,), f"{value!r} is named twice; once is enough") for index, value in repeated)
    return values


Count = Annotated[int, Field(strict=True, ge=1, le=10**9)]
GridPoints = Annotated[int, Field(strict=True, ge=1, le=2**20)]
"""A row of more cells is a slip of the pen, whose arrays alone would fill a machine before its memory is compared."""
Length = Annotated[float, InUnits(LENGTH)]
PositiveLength = Annotated[float, InUnits(LENGTH, above=0)]
Radius = Annotated[float, InUnits(LENGTH, nonzero=True)]
Position = tuple[Length, Length]


class Placed(CaseModel):
    """A surface at its place."""

    center: Position = Field(default=(0.0, 0.0), description="[x, y] of the surface's origin", examples=[["0.1 mm", 0]])
