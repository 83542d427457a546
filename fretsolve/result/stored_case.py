"""The case that a result was made from."""

from __future__ import annotations

from functools import lru_cache

from pydantic import ValidationError

from fretsolve.case.models import Case
from fretsolve.result.header import present_case
from fretsolve.result.reader import Result


def stored_case(result: Result) -> Case | None:
    """Return the effective case of a result, or None if this version does not understand it."""
    return _case(str(result.attributes["effective_case"]))


@lru_cache(maxsize=4)
def _case(text: str) -> Case | None:
    try:
        return Case.model_validate(present_case(text))
    except ValidationError:
        return None
