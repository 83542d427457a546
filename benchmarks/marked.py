"""Figures printed by scripts, put between the marks ``<!-- figures: NAME -->`` and ``<!-- end of figures -->``."""

from __future__ import annotations

import contextlib
import io
import re
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path


@cache
def printed(part: Callable[[], None]) -> str:
    """What a part prints; measured once for all files."""
    text = io.StringIO()
    with contextlib.redirect_stdout(text):
        part()
    return text.getvalue()


def put_parts_into(file: Path, parts: Mapping[str, Callable[[], None]]) -> None:
    """Replace the figures between their marks in `file` by what `parts` print."""
    content = file.read_text()
    for name, part in parts.items():
        pattern = re.compile(rf"(<!-- figures: {name} -->\n).*?(<!-- end of figures -->)", re.DOTALL)
        if pattern.search(content):
            figures = printed(part).strip()
            content = pattern.sub(lambda marks, text=figures: f"{marks[1]}\n{text}\n\n{marks[2]}", content)
    file.write_text(content)
