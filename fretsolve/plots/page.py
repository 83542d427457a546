"""A report on a result as one HTML file that needs no other."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING

from fretsolve.export.text_report import print_report
from fretsolve.plots.canvas import title

if TYPE_CHECKING:
    from fretsolve.plots.kinds import Kind
    from fretsolve.result import Result

STYLE = (
    "body{font-family:sans-serif;max-width:70rem;margin:2rem auto;padding:0 1rem;color:#222}"
    "img{max-width:100%;height:auto}figure{margin:2rem 0}figcaption{color:#555}"
    "pre{overflow-x:auto;background:#f6f6f6;padding:1rem;font-size:.8rem;line-height:1.25}"
)


@dataclass(frozen=True)
class Entry:
    """A kind of pictures in the report: its picture in `file_format`, or the reason why there is none."""

    kind: Kind
    file_format: str = ""
    content: bytes = b""
    reason: str = ""


def html_page(result: Result, entries: Sequence[Entry]) -> str:
    """Table, pictures, what is left out and why, and the case. All text of the case is escaped."""
    table = io.StringIO()
    print_report(result, file=table)
    left_out = [entry for entry in entries if entry.reason]
    parts = [
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<title>{escape(title(result))}</title>',
        f"<style>{STYLE}</style>\n</head>\n<body>\n<h1>{escape(title(result))}</h1>",
        f"<pre>{escape(table.getvalue())}</pre>",
        *(_figure(entry) for entry in entries if not entry.reason),
    ]
    if left_out:
        items = "\n".join(f"<li>{escape(entry.kind.name)}: {escape(entry.reason)}</li>" for entry in left_out)
        parts.append(f"<h2>Left out</h2>\n<ul>\n{items}\n</ul>")
    parts.append(f"<h2>Case</h2>\n<pre>{escape(result.case_yaml)}</pre>\n</body>\n</html>\n")
    return "\n".join(parts)


def _figure(entry: Entry) -> str:
    name, caption = escape(entry.kind.name), escape(entry.kind.caption)
    data = base64.b64encode(entry.content).decode()
    image = f'<img src="data:image/{entry.file_format};base64,{data}" alt="{name}: {caption}">'
    return f'<figure id="{name}">\n<h2>{name}</h2>\n{image}\n<figcaption>{caption}</figcaption>\n</figure>'
