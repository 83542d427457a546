"""Put what a script prints between the marks ``<!-- figures: NAME -->`` and ``<!-- end of figures -->`` of a page.

Tables that are too long for a page go to CSV files in ``data`` beside it.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import io
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path


def parser_of(description: str | None) -> argparse.ArgumentParser:
    """Return a parser of the words after a script's name, with the option `--into`; description: the script's text."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--into", type=Path, metavar="PAGE", help="a Markdown page with marks, which gets the figures")
    return parser


@cache
def printed(part: Callable[[], None]) -> str:
    """Return what a part prints; it is measured once for all files."""
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


def report(parts: Mapping[str, Callable[[], None]], page: Path | None) -> None:
    """Put what `parts` print into a page, or without one print it under their names."""
    if page is not None:
        put_parts_into(page, parts)
        return
    for name, part in parts.items():
        print(f"\n### {name}\n")
        part()


def data_file(page: Path, name: str) -> Path:
    """Return the CSV file of that name beside `page`."""
    return page.parent / "data" / f"{name}.csv"


def write_csv(file: Path, headings: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a table to `file`; its folder is made."""
    file.parent.mkdir(exist_ok=True)
    with file.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(headings)
        writer.writerows(rows)
