"""Show progress by a bar on a terminal, lines of ``key=value`` or lines of JSON, and print warnings and errors."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO, cast

from fretsolve.errors import printable

if TYPE_CHECKING:  # rich takes 0.1 s to load, and output that is not a terminal has no bar
    from rich.progress import Progress


def progress_bar(*texts: str, counted: bool = False) -> Progress:
    """Return a bar of rich that vanishes at its end; start and stop it by a `with` block.

    texts: rich's templates, the first before the bar and the rest behind it; counted: show ``n/total`` as well.
    """
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    before, *behind = map(TextColumn, texts)
    count = [MofNCompleteColumn()] if counted else []
    columns = (before, BarColumn(), *count, *behind, TimeRemainingColumn())
    console = Console(file=unescaped_output())
    return Progress(*columns, console=console, transient=True, refresh_per_second=4.0)


@contextmanager
def counting_bar(text: str, total: int, *, shown: bool) -> Iterator[Callable[[], object]]:
    """Show a bar of `total` things within the block, which gets the function that advances it by one."""
    if not shown:
        yield lambda: None
        return
    with progress_bar(text, counted=True) as bar:
        task = bar.add_task("", total=total)
        yield lambda: bar.advance(task)


def unescaped_output() -> TextIO:
    """Return standard output for rich, which writes control characters; the command line escapes them otherwise."""
    return cast(TextIO, getattr(sys.stdout, "unescaped", sys.stdout))


def key_value_line(**values: Any) -> None:
    """Print ``key=value`` pairs on one line, at once; a value with blanks stands in quotes."""
    print(" ".join(f"{name}={_word(value)}" for name, value in values.items()), flush=True)


def _word(value: object) -> str:
    text = str(value)
    return json.dumps(text, ensure_ascii=False) if any(map(str.isspace, text)) or not text else text


def json_line(event: str, **values: Any) -> None:
    """Print a JSON object on one line, at once. NaN and infinity become null, since JSON does not have them."""
    finite = {k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in values.items()}
    print(json.dumps({"event": event, **finite}, ensure_ascii=False, allow_nan=False), flush=True)


def print_error_line(line: str) -> None:
    """Print a line to standard error, at once."""
    print(printable(line), file=sys.stderr, flush=True)


def print_warnings(file: Path, *texts: str) -> None:
    """Print warnings about a file to standard error, one line each."""
    for text in texts:
        print_error_line(f"{file}: warning: {text}")
