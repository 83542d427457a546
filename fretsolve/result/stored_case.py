"""The case that a result was made from."""

from __future__ import annotations

import json
from functools import lru_cache
from typing import TYPE_CHECKING

from pydantic import ValidationError

from fretsolve.case import Case

if TYPE_CHECKING:
    from fretsolve.result import Result


def stored_case(result: Result) -> Case | None:
    """The effective case; None where it is not one of this version."""
    return _case(str(result.attributes["effective_case"]))


@lru_cache(maxsize=4)
def _case(text: str) -> Case | None:
    try:
        return Case.model_validate(json.loads(text))
    except ValidationError:
        return None
