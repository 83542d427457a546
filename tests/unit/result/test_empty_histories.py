"""Results that begin with an empty history hold what those without hold."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import pytest
from fake_states import fake_header, fake_states

from fretsolve.result.empty_histories import EmptyHistories
from fretsolve.result.layout import HISTORY, STEP
from fretsolve.result.parts import write_result
from fretsolve.result.reader import open_result
from fretsolve.result.layout import SHORT_COLUMN


def content_of(out: Path, count: int, pressed: float, empty: EmptyHistories | None) -> dict[str, Any]:
    """Write a result of `count` increments with the normal load `pressed` in all of them; return all that it holds."""
    states = [replace(state, summary=replace(state.summary, P=pressed)) for state in fake_states(count)]
    write_result(out, out.parent, fake_header(), [], states, states[-1] if states else None, None, empty)
    content: dict[str, Any] = {}

    def add(name: str, node: Any) -> None:
        texts = {key: repr(node.attrs[key]) for key in node.attrs if key != "REFERENCE_LIST"}
        content[name] = texts
        if isinstance(node, h5py.Dataset):
            scales = [[scale.name for scale in axis.values()] for axis in node.dims]
            layout = node.id.get_create_plist().get_layout(), node.chunks, node.compression
            content[name] = texts, scales, layout, node.dtype, node[()].tobytes()

    with open_result(out) as result:  # compares the checksums, too
        assert result.history["P"].tolist() == [pressed] * count
    with h5py.File(out) as file:
        add("/", file)
        file.visititems(add)
    return content


@pytest.mark.parametrize("count", [0, 1, 9, SHORT_COLUMN // 8, SHORT_COLUMN // 8 + 1])
def test_results_hold_the_same_with_an_empty_history_and_without(tmp_path: Path, count: int) -> None:
    empty = EmptyHistories()
    for number, pressed in enumerate((0.5, 1.5, -2.5)):
        begun = content_of(tmp_path / f"begun {number}.h5", count, pressed, empty)
        assert begun == content_of(tmp_path / f"created {number}.h5", count, pressed, None)
        assert "history/P" in begun


def test_an_empty_history_is_made_when_the_same_columns_and_increments_come_again() -> None:
    empty = EmptyHistories()
    columns = [STEP, *HISTORY]
    assert empty.file(columns, 5) == b""
    first = empty.file(columns, 5)
    assert first
    assert empty.file(columns, 5) is first
    assert empty.file(columns, 6) == empty.file(columns[:-1], 6) == empty.file(columns, 5) == b""
    assert empty.file(columns, 5) == first


def test_long_columns_are_not_begun_without_values() -> None:
    empty = EmptyHistories()
    assert [empty.file([STEP, *HISTORY], SHORT_COLUMN // 8 + 1) for _ in range(2)] == [b"", b""]
