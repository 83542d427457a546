"""Write a case file again with other values, and with its comments where that is possible."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import yaml

from fretsolve.case.loading import CaseText, replaced
from fretsolve.case.source import parse
from fretsolve.errors import KeyPath

MARK = "# Found by fretsolve fit: "
"""Beginning of a case file with the values of a fit."""


def rewritten(text: CaseText, values: Mapping[KeyPath, str], remark: str) -> str:
    """Return the text of a case with other values. text: of the file, with `--set`; remark: for its first line.

    A value takes the place of the one that stands in the file. Where none does, the file is written anew without its
    comments.
    """
    data, places = text.data, dict[KeyPath, str]()
    for override in text.source.overrides:
        places[override.key] = override.text.partition("=")[2].strip()
    for key, value in values.items():
        data, places[key] = replaced(data, key, parse(value).value), value
    remark = f"{MARK}{remark}\n"
    spliced = _spliced(text.source.text, places)
    if spliced is not None and parse(spliced).value == data:
        return remark + spliced
    return remark + yaml.safe_dump(data, sort_keys=False, allow_unicode=True, default_flow_style=None)


def _spliced(text: str, places: Mapping[KeyPath, str]) -> str | None:
    """Return a text with other scalars at some keys, None where a key has no scalar there."""
    root = yaml.compose(text, yaml.SafeLoader)
    spans = []
    for key, value in places.items():
        node: Any = root
        for part in key:
            if isinstance(node, yaml.MappingNode):
                node = next((inner for name, inner in node.value if name.value == part), None)
            elif isinstance(node, yaml.SequenceNode) and isinstance(part, int):
                node = node.value[part]
            else:
                node = None
        if not isinstance(node, yaml.ScalarNode):
            return None
        spans.append((node.start_mark.index, node.end_mark.index, value))
    for start, end, value in sorted(spans, reverse=True):
        text = text[:start] + value + text[end:]
    return text
