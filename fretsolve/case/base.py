"""The base of all models of the case file, and annotations for its shorthands."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic_core import CoreSchema, core_schema

from .quantities import LENGTH, InUnits, refused, shown

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue

    from ..errors import KeyPath


class CaseModel(BaseModel):
    """A mapping of the case file: immutable, and without other keys than its own."""

    # Only `Case` builds a validator at import; those of its parts are built if they are used alone.
    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)


@dataclass(frozen=True)
class Repeated:
    """Annotation of a tuple: in the file, a single value stands for `count` of it."""

    count: int

    def expand(self, value: object) -> object:
        """Return the value as a list; None, which `Auto` gives, stays None."""
        return value if value is None or isinstance(value, list | tuple) else (value,) * self.count

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self.expand, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        inner = handler(schema)
        array = next(node for node in inner.get("anyOf", [inner]) if node.get("type") == "array")
        one = array["prefixItems"][0] if "prefixItems" in array else array["items"]
        return {"anyOf": [one, array]}


@dataclass(frozen=True)
class Auto:
    """Annotation of an optional value: in the file, None is written ``auto``. example: of another value."""

    example: str

    def read(self, value: object) -> object:
        """Return None for ``auto`` and any other value as it is."""
        if isinstance(value, str) and value != "auto" and not any(map(str.isdigit, value)):
            raise refused(f"{shown(value)} is not allowed; auto or a value such as {self.example} is needed")
        return None if value == "auto" else value

    def write(self, value: object) -> object:
        """Return ``auto`` for None and any other value as it is."""
        return "auto" if value is None else value

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_before_validator_function(
            self.read,
            handler(source),
            serialization=core_schema.plain_serializer_function_ser_schema(self.write),
        )

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return {"anyOf": [{"const": "auto"}, handler(schema)]}


def refused_at(problems: Iterable[tuple[KeyPath, str]]) -> None:
    """Raise a validation error that lists `problems` (key within the validated value, message), if there are any."""
    lines = [{"type": refused(message), "loc": key, "input": None} for key, message in problems]
    if lines:
        raise ValidationError.from_exception_data("case", lines)  # type: ignore[arg-type]


Count = Annotated[int, Field(strict=True, ge=1)]
Length = Annotated[float, InUnits(LENGTH)]
PositiveLength = Annotated[float, InUnits(LENGTH, above=0)]
Radius = Annotated[float, InUnits(LENGTH, nonzero=True)]
Position = tuple[Length, Length]
