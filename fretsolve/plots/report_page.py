"""Put all pictures of a result on one HTML page."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping
from html import escape

from fretsolve.export.text_report import print_report
from fretsolve.plots.canvas import title_of
from fretsolve.plots.kinds import KINDS
from fretsolve.result import Result

PAGE_STYLE = (
    "body{font-family:sans-serif;max-width:70rem;margin:2rem auto;padding:0 1rem;color:#222}"
    "img{max-width:100%;height:auto}figure{margin:2rem 0}figcaption{color:#555}"
    "pre{overflow-x:auto;background:#f6f6f6;padding:1rem;font-size:.8rem;line-height:1.25}"
)

OWN_MARK = '<meta name="generator" content="fretsolve">'
"""In the head of every page, by which a page is known before it is replaced."""


def html_page(result: Result, pictures: Mapping[str, bytes], left_out: Mapping[str, str]) -> str:
    """Return a page that needs no other file: table, pictures, what is left out and why, and the case.

    pictures: files of the kinds in their first formats; left_out: reasons. Both by the names of the kinds.
    """
    table = io.StringIO()
    print_report(result, file=table)
    title = escape(title_of(result))
    reasons = [f"<li>{escape(name)}: {escape(reason)}</li>" for name, reason in left_out.items()]
    parts = [
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n{OWN_MARK}\n<title>{title}</title>',
        f"<style>{PAGE_STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>",
        f"<pre>{escape(table.getvalue())}</pre>",
        *(_figure(name, content) for name, content in pictures.items()),
        *(["<h2>Left out</h2>\n<ul>", *reasons, "</ul>"] if reasons else []),
        f"<h2>Case</h2>\n<pre>{escape(result.case_yaml)}</pre>\n</body>\n</html>\n",
    ]
    return "\n".join(parts)


def _figure(name: str, content: bytes) -> str:
    caption, data = escape(KINDS[name].caption), base64.b64encode(content).decode()
    image = f'<img src="data:image/{KINDS[name].formats[0]};base64,{data}" alt="{name}: {caption}">'
    return f'<figure id="{name}">\n<h2>{name}</h2>\n{image}\n<figcaption>{caption}</figcaption>\n</figure>'
