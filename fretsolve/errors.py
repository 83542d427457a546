"""Errors that a user can cause or must hear of, each with the exit code of the command that meets it.

The text of an error is one line: what is wrong, the value, what would be right. Where in the case file it
arose is added by whoever knows the file (`fretsolve.case.source`), as ``FILE:LINE: key.path: text``.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from pathlib import Path

EXIT_BUG = 70
"""Exit code of an error that no class below describes."""

KeyPath = tuple[str | int, ...]
"""Place of a value in the case file, as in ``("load_path", 0, "P")``."""


class FretsolveError(Exception):
    """Base of all errors reported in one line without a traceback."""

    exit_code = EXIT_BUG

    def __init__(self, message: str = "", key: KeyPath = (), file: Path | str | None = None, line: int | None = None):
        super().__init__(message)
        self.message, self.key, self.file, self.line = message, key, file, line

    def __str__(self) -> str:
        return located(self.message, self.key, self.file, self.line)


class CaseError(FretsolveError):
    """The case file or the command line is wrong (exit code 2)."""

    exit_code = 2


class CaseErrors(CaseError):  # noqa: N818 - a plural
    """Several problems of one case file, one line each."""

    def __init__(self, problems: Collection[CaseError]):
        first, *_ = self.problems = tuple(problems)
        super().__init__(first.message, first.key, first.file, first.line)

    def __reduce__(self) -> tuple[type[CaseErrors], tuple[tuple[CaseError, ...]]]:
        return type(self), (self.problems,)

    def __str__(self) -> str:
        return "\n".join(str(problem) for problem in self.problems)


def together(problems: Sequence[CaseError]) -> CaseError:
    """Return one error for one or several problems."""
    return problems[0] if len(problems) == 1 else CaseErrors(problems)


class PictureError(FretsolveError):
    """The result, or what was asked for, does not give the picture; the text says why (exit code 2)."""

    exit_code = 2


class NoSolutionError(FretsolveError):
    """The increment has no solution, or none was found (exit code 3).

    component: of the offending load; `key` is where it stands in the case, once the load path has filled it in. `kind`
    names the class in results.
    """

    exit_code = 3
    kind = "no solution"

    def __init__(self, message: str, component: str | None = None):
        super().__init__(message)
        self.component = component


class SlidingError(NoSolutionError):
    """The imposed tangential force or torque exceeds what friction can carry."""

    kind = "sliding"


class NotConvergedError(NoSolutionError):
    """The certificate was not met within the iteration limit."""

    kind = "not converged"


class WeakeningError(NoSolutionError):
    """Friction falls so fast with slip that slip runs away."""

    kind = "weakening friction"


class ContactLostError(NoSolutionError):
    """No pressure field can balance the imposed load (lift-off, tilting over)."""

    kind = "contact lost"


class GridEdgeError(NoSolutionError):
    """The contact reaches the edge of the potential contact area."""

    kind = "grid edge"


class FileError(FretsolveError):
    """A file cannot be read or written (exit code 4)."""

    exit_code = 4

    def __init__(self, message: str, file: Path | str | None = None):
        super().__init__(message, (), file)


class BusyError(FileError):
    """Another run is writing the file."""


_CONTROLS = re.compile(r"[\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")
"""Characters that move the cursor, end lines, or change the order of text, and halves of characters."""


LONGEST = 160
"""Characters of a library's message that are printed."""


def printable(text: str, kept: str = "") -> str:
    """Return a text from a user or a file for the console, its control characters but `kept` as in ``\\u001b``."""
    return _CONTROLS.sub(lambda match: match[0] if match[0] in kept else f"\\u{ord(match[0]):04x}", text)


def shortened(text: str) -> str:
    """Return the message of a library on one line, without its middle if it is long."""
    line = " ".join(text.split())
    return line if len(line) <= LONGEST else f"{line[: LONGEST - 60]} ... {line[-55:]}"


def dotted(key: KeyPath) -> str:
    """Return ``("load_path", 0, "P")`` as ``load_path.0.P``, the form that ``--set`` takes, on one line."""
    return ".".join(str(part) if str(part).isprintable() else repr(part) for part in key)


def located(message: str, key: KeyPath, file: Path | str | None, line: int | None) -> str:
    """Return one line, ``FILE:LINE: key.path: message``, of the parts that are known."""
    place = [f"{file}:{line}" if line is not None else str(file)] if file is not None else []
    return printable(": ".join([*place, *([shortened(dotted(key))] if key else []), message]))
