"""What the commands share that compute a file from a result: their options, and the order of the file.

Functions here raise CaseError and FileError.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from fretsolve.case.dimensions import LENGTH
from fretsolve.case.quantities import QuantityError, to_internal
from fretsolve.errors import CaseError, FileError
from fretsolve.post.stress.cycles import CycleChoice, read_blocks
from fretsolve.post.stress.influence import Body
from fretsolve.post.stress.request import AS_OPTIONS, WindowChoice
from fretsolve.result.reader import read_attributes
from fretsolve.system.files import require_ending, require_free, require_other

WINDOW_KINDS: dict[str, WindowChoice] = {"auto": "auto", "all": "all"}


@dataclass(frozen=True)
class FileOrder:
    """A file to compute from a result.

    threads: that compute; quiet: print only warnings; exclusive: replace no file; advice: what would help where memory
    or disk is too small; folder: where the file lies until it is whole, by default beside `target`.
    """

    target: Path
    threads: int
    quiet: bool
    exclusive: bool
    advice: str = AS_OPTIONS
    folder: Path | None = None


@dataclass(frozen=True)
class FileOptions:
    """Options of a command that computes a file from the result `out`. target: None for the usual name."""

    out: Path
    bodies: Sequence[str]
    window: str
    target: Path | None
    overwrite: bool
    threads: int
    quiet: bool

    @property
    def body_numbers(self) -> tuple[Body, ...]:
        """The chosen bodies."""
        return tuple(1 if body == "1" else 2 for body in self.bodies)

    @property
    def window_choice(self) -> WindowChoice:
        """The cells: auto, all, or a margin (mm). Raises CaseError."""
        if self.window in WINDOW_KINDS:
            return WINDOW_KINDS[self.window]
        needed = "a margin around the contact is needed"
        return length_of("--window", self.window, needed, "; auto, all, or a margin such as 0.5mm is needed")

    def order(self, usual: Path, contents: str, source: str, advice: str = AS_OPTIONS) -> FileOrder:
        """Return the order of a file, by default `usual`. Raises CaseError, FileError if the file cannot be written.

        contents, source: what the file holds and what `out` is, in words.
        """
        target = self.target or usual
        require_ending(target, f"a file of {contents}", ".h5", ".hdf5")
        require_other(target, self.out, source)
        require_no_result(target)
        require_free(target, overwrite=self.overwrite)
        return FileOrder(target, self.threads, self.quiet, not self.overwrite, advice)


def require_no_result(target: Path) -> None:
    """Raise CaseError if the result of a run, which takes long to make again, stands where a file is to be written.

    Raises FileError if the disk does not tell whether it does.
    """
    try:
        read_attributes(target)
    except FileError as error:
        if getattr(error.__cause__, "errno", None) is not None:
            raise
    except (FileNotFoundError, NotADirectoryError):
        pass
    else:
        raise CaseError("is the result of a run, which is not replaced; give another name with -o", (), target)


def cycle_choice(text: str) -> CycleChoice:
    """Return the cycles that --cycle chooses. Raises CaseError."""
    if text in ("last", "all"):
        return "last" if text == "last" else "all"
    if not (text.isdecimal() and int(text) > 0):
        raise CaseError(f"{text!r} is no cycle; last, all, or a number from 1 on is needed", (), "--cycle")
    return int(text)


def chosen_cycles(cycle: str | None, blocks: Path | None) -> CycleChoice:
    """Return the cycles that --cycle or --blocks chooses, by default the last one. Raises CaseError, FileError."""
    if blocks is None:
        return cycle_choice(cycle or "last")
    if cycle is not None:
        raise CaseError("--blocks names the cycles; leave --cycle out", (), "--cycle")
    return read_blocks(blocks)


def positive_length_of(option: str, text: str | None) -> float | None:
    """Return the value of an option that is a length above 0 (mm), None without one. Raises CaseError."""
    if text is None:
        return None
    if not (length := length_of(option, text, needed := "a length > 0 mm is needed")) > 0.0:
        raise CaseError(f"{text!r} is out of range; {needed}", (), option)
    return length


def length_of(option: str, text: str, needed: str, instead: str = "") -> float:
    """Return the value of an option in mm. Raises CaseError.

    needed: what a negative value should be; instead: what a value that is no length should be.
    """
    try:
        length = to_internal(text, LENGTH)
    except QuantityError as error:
        raise CaseError(f"{error}{instead}", (), option) from None
    if length < 0.0:
        raise CaseError(f"{text!r} is negative; {needed}", (), option)
    return length
