"""Means and scatter of a sweep over seeds, such as those of rough surfaces, beside its table."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from fretsolve.sweep.manifest import Manifest
from fretsolve.sweep.table import Column, Table, column, setting_column, write_table_csv
from fretsolve.system.arrays import DoubleArray

FIRST_COLUMN = "seeds"


def seed_keys(manifest: Manifest) -> tuple[str, ...]:
    """Return the varied keys that are seeds."""
    return tuple(key for key in manifest.keys if key.rpartition(".")[2] == "seed")


def seeds_path(table: Path) -> Path:
    """Return the file of the means beside that of the table."""
    return table.with_suffix(".seeds.csv")


def write_seeds_csv(path: Path, table: Table, *, exclusive: bool = False) -> None:
    """Write a row for each combination of the other keys: means and standard deviations over the complete cases.

    exclusive: replace no file. Raises FileError.
    """
    write_table_csv(path, seed_columns(table), exclusive=exclusive)


def seed_columns(table: Table) -> Iterator[Column]:
    """Return the columns of the means: the number of complete cases, the other keys, and two for each quantity.

    The standard deviation is the estimate from a sample, with n - 1 for n cases; there is none for one case, or where a
    value is without a bound, as of a life that does not end.
    """
    others = [key for key in table.manifest.keys if key not in seed_keys(table.manifest)]
    groups: dict[tuple[str | None, ...], list[int]] = {}
    for place, state in enumerate(table.states):
        groups.setdefault(tuple(state.row.settings.get(key) for key in others), []).append(place)
    complete = [[i for i in places if table.states[i].status == "complete"] for places in groups.values()]
    first = [table.states[places[0]].row for places in groups.values()]
    yield column(FIRST_COLUMN, [len(places) for places in complete])
    yield from (setting_column(key, first) for key in others)
    for one in table.found:
        values = [one.values[places] for places in complete]
        means = [float(np.mean(group)) if group.size else np.nan for group in values]
        scatter = [float(np.std(group, ddof=1)) if _has_scatter(group) else np.nan for group in values]
        yield Column(f"{one.name} mean", one.units, np.array(means))
        yield Column(f"{one.name} standard deviation", one.units, np.array(scatter))


def _has_scatter(values: DoubleArray) -> bool:
    return values.size > 1 and not np.isinf(values).any()
