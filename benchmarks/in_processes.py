"""Do a thing for many items in several processes, which inherit the items: closed forms in them cannot be sent."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from multiprocessing import get_context
from typing import Any, ClassVar, TypeVar

Item = TypeVar("Item")
Outcome = TypeVar("Outcome")


class _Work:
    """What a process does: `function` for the item of a number."""

    function: ClassVar[Callable[[Any], Any]]
    items: ClassVar[Sequence[Any]]

    @classmethod
    def inherit(cls, function: Callable[[Any], Any], items: Sequence[Any]) -> None:
        cls.function, cls.items = function, items

    @classmethod
    def done(cls, number: int) -> Any:
        return cls.function(cls.items[number])


def outcomes(function: Callable[[Item], Outcome], items: Sequence[Item], processes: int) -> Iterator[Outcome]:
    """Yield `function` of each item, in their order."""
    with get_context("fork").Pool(processes, _Work.inherit, (function, items)) as pool:
        yield from pool.imap(_Work.done, range(len(items)))
