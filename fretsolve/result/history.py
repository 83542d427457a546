"""The summaries of a run, which may have very many increments: the last ones as they are, the others as records."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import MISSING, fields
from operator import itemgetter
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from fretsolve.result.state import Summary

BLOCK = 256
"""Summaries that become records at once, when as many newer ones follow them. A record takes 0.5 kB, a summary 3 kB."""

_ROW = np.dtype([(one.name, np.int64 if one.type == "int" else np.float64) for one in fields(Summary)])
_values = itemgetter(*(one.name for one in fields(Summary)))


class History(Sequence[Summary]):
    """The summaries of all increments so far, from the first one on."""

    def __init__(self, summaries: Iterable[Summary] = ()):
        self._blocks: list[NDArray[Any]] = []
        self._recent: list[Summary] = []
        for summary in summaries:
            self.append(summary)

    @classmethod
    def of_rows(cls, tables: Iterable[NDArray[Any]]) -> History:
        """Return the history in tables of records, which may lack columns that have a default value."""
        found = cls()
        rows = np.concatenate([np.empty(0, _ROW), *map(_completed, tables)])
        whole = len(rows) // BLOCK * BLOCK
        found._blocks = [rows[start : start + BLOCK] for start in range(0, whole, BLOCK)]
        found._recent = [Summary(*row) for row in rows[whole:].tolist()]
        return found

    def append(self, summary: Summary) -> None:
        """Add the summary of the next increment."""
        self._recent.append(summary)
        if len(self._recent) == 2 * BLOCK:
            self._blocks.append(np.array([_values(vars(one)) for one in self._recent[:BLOCK]], _ROW))
            del self._recent[:BLOCK]

    def __len__(self) -> int:
        return BLOCK * len(self._blocks) + len(self._recent)

    @overload
    def __getitem__(self, index: int) -> Summary: ...
    @overload
    def __getitem__(self, index: slice) -> list[Summary]: ...
    def __getitem__(self, index: int | slice) -> Summary | list[Summary]:
        places = range(len(self))[index]  # raises IndexError
        return self._at(places) if isinstance(places, int) else list(map(self._at, places))

    def _at(self, place: int) -> Summary:
        block, inside = divmod(place, BLOCK)
        if block < len(self._blocks):
            return Summary(*self._blocks[block][inside].item())
        return self._recent[place - BLOCK * len(self._blocks)]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sequence) and list(self) == list(other)

    __hash__ = None  # type: ignore[assignment]


def _completed(rows: NDArray[Any]) -> NDArray[Any]:
    """Return records with all columns of a summary."""
    found, names = np.empty(rows.shape, _ROW), rows.dtype.names or ()
    for one in fields(Summary):
        if one.name not in names and one.default is MISSING:
            raise ValueError(f"the history lacks {one.name}")
        found[one.name] = rows[one.name] if one.name in names else one.default
    return found
