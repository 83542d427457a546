"""Put figures into pages, keep what takes long in files, and share work among processes.

What a script prints under a name goes between the marks ``<!-- figures: NAME -->`` and ``<!-- end of figures -->`` of a
page. Where the page links to ``data/PAGE_NAME.csv`` instead, the tables that are printed go to that file.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import io
import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any, ClassVar, TypeVar

Item = TypeVar("Item")
Outcome = TypeVar("Outcome")


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
    """Replace the figures between their marks in `file`, and the data that it links to, by what `parts` print."""
    content = file.read_text()
    for name, part in parts.items():
        data = data_file(file, f"{file.stem}_{name.replace(' ', '_')}")
        if f"data/{data.name})" in content:
            write_tables(data, printed(part))
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
    """Return the CSV file of that name in the folder `data` that is beside `page`, or beside a folder around it."""
    above = (folder / "data" for folder in page.resolve().parents)
    folder = next((data for data in above if data.is_dir()), page.parent / "data")
    return folder / f"{name}.csv"


def write_tables(file: Path, text: str) -> None:
    """Write the first Markdown table of `text` to `file`, the others to files of its name with _2, _3 and so on."""
    tables = re.findall(r"(?:^\|.*\n?)+", text, re.MULTILINE)
    for number, table in enumerate(tables, 1):
        lines = [re.split(r"(?<!\\)\|", line.strip().strip("|")) for line in table.splitlines()]
        headings, _, *rows = [[cell.strip().replace(r"\|", "|") for cell in line] for line in lines]
        write_csv(file.with_stem(f"{file.stem}_{number}") if number > 1 else file, headings, rows)


def write_csv(file: Path, headings: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a table to `file`; its folder is made."""
    file.parent.mkdir(exist_ok=True)
    with file.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(headings)
        writer.writerows(rows)


def kept(folder: Path | None, name: str, make: Callable[[], Any]) -> Any:
    """Return what `make` returns, as JSON has it, from the file of that name in `folder` if it is there.

    Without a folder nothing is kept. Delete the folder where the solver or the cases have changed.
    """
    if folder is None:
        return make()
    file = folder / f"{re.sub('[^A-Za-z0-9.]+', '_', name)}.json"
    if not file.exists():
        folder.mkdir(parents=True, exist_ok=True)
        unfinished = file.with_suffix(".part")
        unfinished.write_text(json.dumps(make()))
        unfinished.rename(file)
    return json.loads(file.read_text())


class _Work:
    """What a process does: `function` for the item of a number. Items are inherited: closed forms cannot be sent."""

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
