"""Keep a run going when the reader of its output has gone, as in ``fretsolve run case.yaml | head``."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from pathlib import Path
from typing import Any, TextIO, cast

from fretsolve.system.files import writing


class TolerantStream:
    """Write to `stream`, and drop what is written once its reader has gone.

    name: for messages. Raises FileError for other reasons, such as a full disk.
    """

    def __init__(self, stream: TextIO, name: str):
        self._stream = stream
        self._name = name

    def write(self, text: str) -> int:
        with self._tolerance():
            self._stream.write(text)
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
        with redirect_stdout(output), redirect_stderr(messages):
            yield


def _fill_closed_descriptors() -> None:
    """Open closed standard streams on the null device; else the next file would take their number and their output."""
    for descriptor in range(3):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
