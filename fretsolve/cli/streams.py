"""Keep a run going when the reader of its output has gone, as in ``fretsolve run case.yaml | head``."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from io import TextIOWrapper
from pathlib import Path
from typing import Any, TextIO, cast

from fretsolve.errors import printable
from fretsolve.system.files import writing


class TolerantStream:
    """Write to `stream`, control characters escaped, and drop what is written once its reader has gone.

    name: for messages; kept: control characters that are written as they are, None for all. Raises FileError for other
    reasons, such as a full disk.
    """

    def __init__(self, stream: TextIO, name: str, kept: str | None = "\n\t"):
        self._stream = stream
        self._name = name
        self._kept = kept

    @property
    def unescaped(self) -> TolerantStream:
        """The same for a library that moves the cursor, and escapes the texts that it is given."""
        return TolerantStream(self._stream, self._name, None)

    def write(self, text: str) -> int:
        with self._tolerance():
            self._stream.write(text if self._kept is None else printable(text, self._kept))
        return len(text)

    def flush(self) -> None:
        with self._tolerance():
            self._stream.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    @contextmanager
    def _tolerance(self) -> Iterator[None]:
        with writing(self._name):
            try:
                yield
            except OSError as error:
                # the null device takes the buffer and all later output, so that the interpreter can flush at its exit
                with suppress(OSError), Path(os.devnull).open("w") as nowhere:
                    os.dup2(nowhere.fileno(), self._stream.fileno())
                if not isinstance(error, BrokenPipeError):
                    raise


@contextmanager
def tolerant_streams() -> Iterator[None]:
    """Make standard output and standard error tolerant within the block."""
    _fill_closed_descriptors()
    with Path(os.devnull).open("w") as nowhere:
        output = cast(TextIO, TolerantStream(sys.stdout or nowhere, "standard output"))
        messages = cast(TextIO, TolerantStream(sys.stderr or nowhere, "standard error"))
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, TextIOWrapper):
                stream.reconfigure(errors="backslashreplace")  # what the locale cannot write
        with redirect_stdout(output), redirect_stderr(messages):
            yield


def _fill_closed_descriptors() -> None:
    """Open closed standard streams on the null device; else the next file would take their number and their output."""
    for descriptor in range(3):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
