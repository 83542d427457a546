"""Write a result so that no completed increment is lost, whenever the run ends and however.

Each increment is one file in ``OUT.parts/``, committed by a rename. OUT is written once, from the parts, when
the run is complete or has failed. If OUT exists, it is the result and its parts are leftovers.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from typing import Literal

import h5py

from fretsolve.case.dimensions import counted
from fretsolve.errors import CaseError, FileError
from fretsolve.result.header import RunHeader, require_same_run
from fretsolve.result.lock import RunLock
from fretsolve.result.parts import (
    HEADER_NAME,
    all_parts,
    contiguous_parts,
    part_name,
    parts_folder,
    set_aside,
    set_result_aside,
    write_increments,
    write_part,
    write_result,
)
from fretsolve.result.piece import Part, Piece
from fretsolve.result.reader import open_result, read_attributes, read_header
from fretsolve.result.state import State, Summary
from fretsolve.system import atomic_files
from fretsolve.system.files import reason_of, reported, require_free
from fretsolve.system.foreign_files import read_bytes, require_regular

MERGE_EVERY = 32
"""Increments per merged part, which bounds the number of files and the restart data that is kept without use."""

RESUME, SAME_COMMAND = "--resume goes on", "the same command goes on"
"""Advice for a run of one case, and for one of several cases."""

NOTHING_SHARED: Mapping[int, Path] = {}

LARGEST_SHARED = 2**31
"""Bytes of the file of a shared beginning."""

TO_GO_ON = "--overwrite replaces it, --resume goes on unless it is complete"
"""Advice for an existing result."""


def _require_name(out: Path) -> None:
    """Raise FileError if the result could not be written to `out` at the end of the run."""
    if out.is_symlink() and not out.exists():
        raise FileError("is a link to a file that does not exist; remove it, or give another name", out)
    with suppress(OSError):  # a folder that is not there is reported when it is needed
        spare = os.pathconf(out.absolute().parent, "PC_NAME_MAX") - len(os.fsencode(out.name))
        if spare < atomic_files.LONGEST_ENDING:
            message = "the name is too long: a run adds an ending to it, so it must be shorter by"
            raise FileError(f"{message} {atomic_files.LONGEST_ENDING - spare} bytes", out)


class HistoryWriter(AbstractContextManager["HistoryWriter"]):
    """A result being written; a context manager, which stops the run if it is left without `finish`.

    complete: OUT exists already and there is nothing to do. last_state: where to go on from, None to start at the
    beginning. summaries: of all increments so far. notes: warnings about the resume. shared: files of the increments 0
    to a step, by that step, which other runs begin with as well.
    """

    def __init__(
        self,
        out: Path,
        header: RunHeader,
        pause: float = 0.0,
        advice: str = RESUME,
        shared: Mapping[int, Path] = NOTHING_SHARED,
    ):
        self.out = out
        self.header = header
        self._advice, self._shared = advice, shared
        self._pause = pause
        self._saved_at = time.monotonic()
        self._unsaved: list[State] = []
        self.complete = False
        self.last_state: State | None = None
        self.summaries: list[Summary] = []
        self.notes: list[str] = []
        self._folder = parts_folder(out)
        self._lock: RunLock | None = None
        self._parts: list[Part] = []

    @classmethod
    def open(
        cls,
        out: Path,
        header: RunHeader,
        *,
        resume: bool = False,
        overwrite: bool = False,
        retry: bool = True,
        pause: float = 0.0,
        advice: str = RESUME,
        shared: Mapping[int, Path] = NOTHING_SHARED,
    ) -> HistoryWriter:
        """Begin the result `out`, or go on with it.

        retry: whether to resume a failed one; otherwise it stays as it is. pause: seconds for which increments may stay
        unsaved. advice: how to go on, for the message if nothing more can be saved. shared: a new result begins with
        the longest of these files that is there, and writes those that are not. Raises CaseError if `out` or its parts
        exist and neither option is given, FileError if they belong to another run or are damaged, if another run writes
        them, or if the folder cannot be written.
        """
        if resume and overwrite:
            raise ValueError("resume and overwrite exclude each other")
        with reported("cannot begin the result", out):
            require_free(out, overwrite=resume or overwrite, advice=TO_GO_ON)
            _require_name(out)
            if out.exists():
                require_regular(out)
                if overwrite and out.stat().st_size and not h5py.is_hdf5(out):
                    message = "is not an HDF5 file, so --overwrite leaves it alone: remove it, or give another name"
                    raise FileError(message, out)
            header.require_modest()
            writer = cls(out, header, pause, advice, shared)
            # Without a lock, since a complete result may lie in a folder that cannot be written.
            if resume and out.exists() and not writer._folder.exists() and writer._take_final(retry):
                return writer
            writer._lock = RunLock.acquire(writer._folder)
            try:
                writer._begin(resume, overwrite, retry)
            except BaseException:
                writer.stop()
                raise
            return writer

    def __exit__(self, *_: object) -> None:
        self.stop()

    def append(self, state: State) -> None:
        """Commit an increment: once this returns, no kill and no power cut takes it back, unless there is a pause.

        Raises FileError if it cannot be written (all earlier increments stay), ValueError if `state` does not follow
        the last one or does not have error bars as the header says.
        """
        if (state.errors is not None) != self.header.errors:
            raise ValueError("either every increment has error bars or none, as the header says")
        if state.summary.step != len(self.summaries):
            raise ValueError(f"increment {state.summary.step} does not follow {len(self.summaries) - 1}")
        self.last_state = state
        self.summaries.append(state.summary)
        self._unsaved.append(state)
        self._write_shared(state)
        if time.monotonic() - self._saved_at >= self._pause:
            self.save()

    def is_saved(self, step: int) -> bool:
        """Return whether increment `step` is committed."""
        return step < len(self.summaries) - len(self._unsaved)

    def save(self) -> None:
        """Commit the increments that a pause has left unsaved. Raises FileError."""
        with self._reported("cannot save the increment", self._folder):
            if not (self._folder / HEADER_NAME).exists():
                self._write_header()
            while self._unsaved:
                state = self._unsaved[0]
                self._parts.append(write_part(self._folder, self.header, state))
                del self._unsaved[0]
                single = [part.path for part in self._parts if part.first == part.last]
                if len(single) >= MERGE_EVERY:
                    merged = write_part(self._folder, self.header, state, single)
                    with Piece(merged.path) as piece:
                        piece.verify()
                    self._parts = [*(part for part in self._parts if part.path not in single), merged]
                    atomic_files.remove(*single)
        self._saved_at = time.monotonic()

    def finish(self, status: Literal["complete", "failed"], message: str = "", kind: str = "") -> None:
        """Write OUT from the parts and remove them. message, kind: why the run failed.

        Raises FileError, also if another file has taken OUT's name under way; the increments stay in the parts then.
        """
        failure = (message, kind) if status == "failed" else None
        with self._reported("cannot write the result", self.out):
            parts = [part.path for part in self._parts]
            try:
                write_result(self.out, self._folder, self.header, parts, self._unsaved, self.last_state, failure)
            except OSError:
                self.save()  # what a pause has left unsaved
                raise
            self._unsaved.clear()
            self._clear()
        self.stop()

    @contextmanager
    def _reported(self, problem: str, file: Path) -> Iterator[None]:
        """Turn an OSError in the block into a FileError that says how many of the increments so far are kept."""
        try:
            yield
        except OSError as error:
            reason = reason_of(error)
            if isinstance(error, FileExistsError):
                reason = "another file has taken this name under way and is not touched; move it away"
            raise FileError(f"{problem}: {reason}; {self._kept()}", file) from error

    def _kept(self) -> str:
        """Return how many of the increments so far are saved, and how to go on."""
        if not all(part.path.exists() for part in self._parts):
            return "saved increments were removed under way"
        saved = len(self.summaries) - len(self._unsaved)
        if not saved:
            return "no increment is saved"
        return f"{saved} of {len(self.summaries)} increments are kept, {self._advice}"

    def stop(self) -> None:
        """Leave the committed increments for a later resume, and let other runs write."""
        if self._lock is not None:
            with suppress(OSError):
                if not all_parts(self._folder):
                    atomic_files.remove(self._folder / HEADER_NAME)  # nothing to go on from
            self._lock.release()
            self._lock = None

    def _begin(self, resume: bool, overwrite: bool, retry: bool) -> None:
        # Another run may have ended in the meantime, so check everything again under the lock.
        require_free(self.out, overwrite=resume or overwrite, advice=TO_GO_ON)
        atomic_files.remove(*atomic_files.temporaries(self._folder))  # left by a kill
        if overwrite:
            # The header goes last: saved increments without it could not be told from those of another run.
            atomic_files.remove(*[part.path for part in reversed(all_parts(self._folder))])
            self._clear()
            atomic_files.remove(self.out)
        elif self.out.exists():
            self._take_up_result(retry)
            return
        if not all_parts(self._folder):
            self._clear()
            self._begin_with_shared()
        elif not (self._folder / HEADER_NAME).exists() or not contiguous_parts(self._folder):
            missing = "the first of them" if (self._folder / HEADER_NAME).exists() else HEADER_NAME
            message = f"holds saved increments, but {missing} is missing, so they cannot be used"
            raise FileError(f"{message}: put it back, or start anew with --overwrite", self._folder)
        elif resume:
            self._take_up_stopped()
        else:
            message = "a stopped run is there: --resume goes on with it, --overwrite starts anew"
            raise CaseError(message, (), self._folder)
        if not self._pause:
            self._write_header()

    def _begin_with_shared(self) -> None:
        """Take the longest shared beginning that is there as the first part."""
        for step in sorted(self._shared, reverse=True):
            part = Part(self._folder / part_name(0, step), 0, step)
            try:
                content = read_bytes(self._shared[step], LARGEST_SHARED)
            except (OSError, FileError):  # most likely it is not there yet
                continue
            self._write_header()
            with atomic_files.new_file(part.path, self._folder) as file:
                file.write(content)
            try:
                self._take_up(part.path)
            except FileError:  # damaged, so it is written anew
                atomic_files.remove(part.path)
                with suppress(OSError):
                    atomic_files.remove(self._shared[step])
                continue
            self._parts = [part]
            return

    def _write_shared(self, state: State) -> None:
        """Write a shared beginning that ends with `state`, unless it is there or cannot be written."""
        path = self._shared.get(state.summary.step)
        if path is not None and not path.exists():
            with suppress(OSError):
                atomic_files.add_folder(path.parent)
                write_increments(path, self.header, [part.path for part in self._parts], self._unsaved, state)

    def _take_final(self, retry: bool) -> bool:
        """Take OUT as it is if nothing is left to do, and return whether. Raises FileError if it is of another run."""
        with open_result(self.out) as result:
            require_same_run(self.out, result.attributes, self.header)
            status = result.status
        if status == "complete" or not retry:
            with Piece(self.out) as piece:
                self.summaries = piece.summaries()
            self.complete = True
        return self.complete

    def _take_up_result(self, retry: bool) -> None:
        """Take OUT, or the parts beside it where OUT is damaged, or has failed and has fewer increments than they.

        Nothing is removed before what else holds it has been read whole. Raises FileError.
        """
        if saved := all_parts(self._folder):
            usable = self._require_own_parts()
            try:
                with open_result(self.out) as result, Piece(self.out) as piece:
                    increments, complete = result.increments, result.status == "complete"
                    piece.verify()
            except FileError as damage:
                if not usable:
                    message = f"{damage.message}; the saved increments in {self._folder.name} cannot be used instead"
                    raise FileError(f"{message}: {HEADER_NAME} or the first of them is missing", self.out) from damage
                self._settle_parts(self._read_parts())
                aside = set_result_aside(self.out)
                self.notes.append(f"{damage}; going on from {self._folder.name}. The file was moved to {aside.name}")
                return
            if not complete and max(part.last for part in saved) >= increments:
                if not usable:
                    message = f"holds more increments than {self.out.name}, but {HEADER_NAME} or the first is missing"
                    raise FileError(f"{message}: put it back, or start anew with --overwrite", self._folder)
                damaged = self._read_parts()
                if len(self.summaries) > increments:
                    self._settle_parts(damaged)
                    there = f"{self.out} has failed after {counted(increments, 'increment')}"
                    self.notes.append(f"{there}, {self._folder.name} has {len(self.summaries)}; going on from those")
                    atomic_files.remove(self.out)
                    return
                self.last_state, self.summaries, self._parts = None, [], []
        if self._take_final(retry):
            self._clear()
        else:
            self._take_up_failed()

    def _require_own_parts(self) -> bool:
        """Return whether the parts beside OUT are of use. Raises FileError if they or OUT are of another run."""
        try:
            attributes = read_attributes(self.out)
        except FileError as error:
            advice = f"the saved increments in {self._folder.name} stay: move this file away, and {self._advice}"
            raise FileError(f"{error.message}; {advice}", self.out) from error
        require_same_run(self.out, attributes, self.header)
        try:
            header = read_header(self._folder)
        except (FileNotFoundError, FileError):
            return False
        require_same_run(self._folder, header.attributes("stopped"), self.header)
        return bool(contiguous_parts(self._folder))

    def _write_header(self) -> None:
        atomic_files.write_text(self._folder / HEADER_NAME, self.header.to_json())

    def _take_up_failed(self) -> None:
        """Turn a failed result back into parts, to go on from its last increment. OUT goes last, so nothing is lost."""
        self._take_up(self.out)
        self._clear()
        self._write_header()
        if self.last_state is not None:
            self._parts = [write_part(self._folder, self.header, self.last_state, [self.out])]
        atomic_files.remove(self.out)

    def _take_up_stopped(self) -> None:
        """Go on from the parts of a stopped run. Raises FileError."""
        require_same_run(self._folder, read_header(self._folder).attributes("stopped"), self.header)
        self._settle_parts(self._read_parts())

    def _read_parts(self) -> dict[Part, FileError]:
        """Take up the increments up to which all parts are undamaged, and return those that are damaged.

        In place of a damaged merged part, those that it was merged from are taken if they are still there.
        """
        damaged: dict[Part, FileError] = {}
        for part in all_parts(self._folder):
            if part.first != len(self.summaries):
                continue
            try:
                self._take_up(part.path)
            except FileError as error:
                damaged[part] = error
            else:
                self._parts.append(part)
        return damaged

    def _settle_parts(self, damaged: Mapping[Part, FileError]) -> None:
        """Set the parts aside that follow those taken up, and remove those that merged ones hold. Raises FileError."""
        parts, next_step = all_parts(self._folder), len(self.summaries)
        if not self._parts:
            first = next(iter(damaged.values()))
            message = f"{first.message}, and there is no saved increment before it: --overwrite starts anew"
            raise FileError(message, first.file) from first
        for part, problem in damaged.items():
            if part.last < next_step:
                self.notes.append(f"{problem}; its increments are taken from the parts that it was merged from")
        if later := [part for part in parts if part.last >= next_step]:
            found = [str(damaged[part]) for part in later if part in damaged]
            damage = found[0] if found else f"increment {next_step} is missing in {self._folder}"
            aside = set_aside(self._folder, [part.path for part in later])
            self.notes.append(f"{damage}; going on from increment {next_step}. What follows was moved to {aside.name}")
        kept = {part.path for part in self._parts}
        atomic_files.remove(*[part.path for part in all_parts(self._folder) if part.path not in kept])  # merged

    def _take_up(self, path: Path) -> None:
        """Go on after the last increment of a file. Raises FileError, and changes nothing, if it is damaged."""
        with Piece(path) as piece:
            piece.verify()
            piece.require_run(self.header)
            piece.require_steps(self.header.stores_fields)
            piece.require_fields(self.header.shape)
            summaries = piece.summaries()
            self.last_state = piece.state() if summaries else None
            self.summaries += summaries

    def _clear(self) -> None:
        """Remove all parts, the header first: without it the rest counts as nothing."""
        atomic_files.remove(self._folder / HEADER_NAME)
        atomic_files.remove(*[part.path for part in all_parts(self._folder)])
        self._parts = []
