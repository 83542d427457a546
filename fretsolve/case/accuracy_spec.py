"""The accuracy of a case: a share, or the name of a level."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pydantic_core import CoreSchema, core_schema

from .quantities import NUMBER, Quantity, refused, shown

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue

LEVELS = {"draft": 0.05, "standard": 0.01, "reference": 0.002}
"""What the names stand for."""

SHARE = Quantity(NUMBER, least=1e-4, most=0.2)


@dataclass(frozen=True)
class Accuracy:
    """Annotation of an optional float: in the file, a share such as ``1 %``, or the name of a level."""

    def read(self, value: object) -> object:
        """The share."""
        if isinstance(value, str) and value in LEVELS:
            return LEVELS[value]
        if isinstance(value, str) and not any(map(str.isdigit, value)):
            names = ", ".join(LEVELS)
            raise refused(f"{shown(value)} is not allowed; {names} or a number such as 1 % is needed")
        return value if value is None else SHARE.read(value)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self.read, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        share = SHARE.__get_pydantic_json_schema__(schema, handler)
        return {"anyOf": [{"enum": list(LEVELS)}, *share["anyOf"]]}
