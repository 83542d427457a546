"""Whatever stands in a case file, it loads or is refused in lines that name it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from test_models import FULL

from fretsolve.case.loading import load_case
from fretsolve.case.models import Case
from fretsolve.errors import CaseError

relaxed = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None, max_examples=150)

WORDS = "bodies surface grid load_path P Qx cycle times stages sphere radius auto rigid true yes"
SIGNS = "1e-6 -1 .inf ~ : { } [ ] ' \" | > # ? % @ << --- ... \x00 \x85 µ \U0001f600"
FRAGMENTS = [*WORDS.split(" "), *SIGNS.split(" "), "400 N", "10 mm", ": ", "\n", "\n  ", "\n- ", "- ", ", ", "\t"]
FRAGMENTS += ["&a ", "*a", "!!int ", "!x "]

scalars = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=8),
    st.sampled_from(["1 N", "2 mm", "3 deg", "4 N mm", "1 %", "auto", "rigid", "x", "mm"]),
)
keys = st.one_of(st.text(max_size=5), st.sampled_from([f for f in FRAGMENTS if f.isidentifier()]))
values = st.recursive(
    scalars, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(keys, inner, max_size=3), max_leaves=8
)


def loads_or_is_refused(path: Path, content: bytes, overrides: list[str] | None = None) -> None:
    path.write_bytes(content)
    try:
        assert isinstance(load_case(path, overrides or []), Case)
    except CaseError as error:
        lines = str(error).splitlines()
        problems = getattr(error, "problems", (error,))
        assert len(lines) == len(problems)
        assert all(line.startswith((f"{path}:", "override ")) for line in lines)
        assert all(len(line) < 700 for line in lines)


def paths(node: Any, prefix: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    yield prefix
    children = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for part, child in children:
        yield from paths(child, (*prefix, part))


def replaced(node: Any, path: tuple[Any, ...], value: Any) -> Any:
    if not path:
        return value
    if isinstance(node, dict):
        return {k: replaced(v, path[1:], value) if k == path[0] else v for k, v in node.items()}
    return [replaced(v, path[1:], value) if i == path[0] else v for i, v in enumerate(node)]


CONTENT = yaml.safe_load(FULL)
PATHS = list(paths(CONTENT))


@relaxed
@given(text=st.lists(st.sampled_from(FRAGMENTS), max_size=30).map("".join))
def test_random_yaml(tmp_path: Path, text: str) -> None:
    loads_or_is_refused(tmp_path / "case.yaml", text.encode())


@relaxed
@given(start=st.integers(0, len(FULL)), length=st.integers(0, 20), fragment=st.sampled_from(FRAGMENTS))
def test_case_with_a_piece_replaced(tmp_path: Path, start: int, length: int, fragment: str) -> None:
    text = FULL[:start] + fragment + FULL[start + length :]
    loads_or_is_refused(tmp_path / "case.yaml", text.encode())


@relaxed
@given(path=st.sampled_from(PATHS), value=values)
def test_case_with_a_value_replaced(tmp_path: Path, path: tuple[Any, ...], value: Any) -> None:
    content = replaced(CONTENT, path, value)
    loads_or_is_refused(tmp_path / "case.yaml", yaml.safe_dump(content, allow_unicode=True).encode())


@relaxed
@given(
    path=st.sampled_from(PATHS),
    value=st.one_of(st.text(max_size=10), st.lists(st.sampled_from(FRAGMENTS), max_size=8).map("".join)),
)
def test_random_override(tmp_path: Path, path: tuple[Any, ...], value: str) -> None:
    override = f"{'.'.join(map(str, path))}={value}"
    loads_or_is_refused(tmp_path / "case.yaml", FULL.encode(), [override])


@pytest.mark.parametrize("text", ["a" * 100_000, "- " * 100_000, "a: " * 10_000, "{" * 10_000, "1" * 100_000 + "!"])
def test_long_text(tmp_path: Path, text: str) -> None:
    loads_or_is_refused(tmp_path / "case.yaml", text.encode())
    loads_or_is_refused(tmp_path / "case.yaml", FULL.replace("400 N", repr(text)).encode())
