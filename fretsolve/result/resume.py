"""Go on from what an earlier run has left: OUT, its parts, or both, of which some may be damaged.

A damaged file is set aside, never removed, and the run goes on from the increments before it.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from fretsolve.case.dimensions import counted
from fretsolve.errors import CaseError, FileError
from fretsolve.result.header import RunHeader, require_same_run
from fretsolve.result.parts import (
    HEADER_NAME,
    all_parts,
    contiguous_parts,
    merge_parts,
    part_name,
    parts_folder,
    set_aside,
    set_result_aside,
)
from fretsolve.result.piece import Part, Piece
from fretsolve.result.reader import open_result, read_attributes, read_header
from fretsolve.result.state import State, Summary
from fretsolve.system import atomic_files
from fretsolve.system.files import require_free
from fretsolve.system.foreign_files import read_bytes

LARGEST_BEGINNING = 2**31
"""Bytes of the file of a shared beginning."""

TO_GO_ON = "--overwrite replaces it, --resume goes on unless it is complete"
"""Advice for an existing result."""


class SavedRun:
    """The increments of a run that are saved, in OUT or in its parts.

    parts: the files that hold them, in order. summaries: of all of them. last_state: where to go on from, None to start
    at the beginning. complete: OUT is there and nothing is to be done. notes: warnings about damaged files.
    """

    def __init__(self, out: Path, header: RunHeader, advice: str):
        """Begin with nothing taken up; advice: how to go on, for the messages of errors."""
        self.out, self.folder, self.header = out, parts_folder(out), header
        self._advice = advice
        self.parts: list[Part] = []
        self.summaries: list[Summary] = []
        self.last_state: State | None = None
        self.complete = False
        self.notes: list[str] = []

    def write_header(self) -> None:
        """Write the header of the parts, with which their folder begins to hold a run. Raises OSError."""
        atomic_files.write_text(self.folder / HEADER_NAME, self.header.to_json())
        atomic_files.sync_folder(self.folder.parent)

    def remove_parts(self) -> None:
        """Remove all parts, the header first: without it the rest counts as nothing. Raises OSError."""
        atomic_files.remove(self.folder / HEADER_NAME)
        atomic_files.remove(*[part.path for part in all_parts(self.folder)])
        self.parts = []

    def take_up(self, shared: Mapping[int, Path], *, resume: bool, overwrite: bool, retry: bool) -> None:
        """Go on from what is there, or remove it for `overwrite`. The run has to be locked.

        shared: files of the increments 0 to a step, by that step; where nothing is there, the run begins with the
        longest of them. retry: whether to go on from a failed result. Raises as `HistoryWriter.open`.
        """
        # Another run may have ended in the meantime, so check everything again under the lock.
        require_free(self.out, overwrite=resume or overwrite, advice=TO_GO_ON)
        atomic_files.remove(*atomic_files.temporaries(self.folder))  # left by a kill
        if overwrite:
            # The header goes last: saved increments without it could not be told from those of another run.
            atomic_files.remove(*[part.path for part in reversed(all_parts(self.folder))])
            self.remove_parts()
            atomic_files.remove(self.out)
        elif self.out.exists():
            self._take_up_result(retry)
            return
        if not all_parts(self.folder):
            self.remove_parts()
            self._take_up_beginning(shared)
        elif not (self.folder / HEADER_NAME).exists() or not contiguous_parts(self.folder):
            missing = "the first of them" if (self.folder / HEADER_NAME).exists() else HEADER_NAME
            message = f"holds saved increments, but {missing} is missing, so they cannot be used"
            raise FileError(f"{message}: put it back, or start anew with --overwrite", self.folder)
        elif resume:
            self._take_up_stopped()
        else:
            message = "a stopped run is there: --resume goes on with it, --overwrite starts anew"
            raise CaseError(message, (), self.folder)

    def _take_up_beginning(self, shared: Mapping[int, Path]) -> None:
        """Take the longest shared beginning that is there as the first part."""
        for step in sorted(shared, reverse=True):
            part = Part(self.folder / part_name(0, step), 0, step)
            try:
                content = read_bytes(shared[step], LARGEST_BEGINNING)
            except (OSError, FileError):  # most likely it is not there yet
                continue
            self.write_header()
            with atomic_files.new_file(part.path, self.folder) as file:
                file.write(content)
            try:
                self._take_up_file(part.path)
            except FileError:  # damaged, so it is written anew
                atomic_files.remove(part.path)
                with suppress(OSError):
                    atomic_files.remove(shared[step])
                continue
            self.parts = [part]
            return

    def take_final(self, retry: bool) -> bool:
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
        if saved := all_parts(self.folder):
            usable = self._require_own_parts()
            try:
                with open_result(self.out) as result, Piece(self.out) as piece:
                    increments, complete = result.increments, result.status == "complete"
                    piece.verify()
            except FileError as damage:
                if not usable:
                    message = f"{damage.message}; the saved increments in {self.folder.name} cannot be used instead"
                    raise FileError(f"{message}: {HEADER_NAME} or the first of them is missing", self.out) from damage
                self._settle_parts(self._read_parts())
                aside = set_result_aside(self.out)
                self.notes.append(f"{damage}; going on from {self.folder.name}. The file was moved to {aside.name}")
                return
            if not complete and max(part.last for part in saved) >= increments:
                if not usable:
                    message = f"holds more increments than {self.out.name}, but {HEADER_NAME} or the first is missing"
                    raise FileError(f"{message}: put it back, or start anew with --overwrite", self.folder)
                damaged = self._read_parts()
                if len(self.summaries) > increments:
                    self._settle_parts(damaged)
                    there = f"{self.out} has failed after {counted(increments, 'increment')}"
                    self.notes.append(f"{there}, {self.folder.name} has {len(self.summaries)}; going on from those")
                    atomic_files.remove(self.out)
                    return
                self.last_state, self.summaries, self.parts = None, [], []
        if self.take_final(retry):
            self.remove_parts()
        else:
            self._take_up_failed()

    def _require_own_parts(self) -> bool:
        """Return whether the parts beside OUT are of use. Raises FileError if they or OUT are of another run."""
        try:
            attributes = read_attributes(self.out)
        except FileError as error:
            advice = f"the saved increments in {self.folder.name} stay: move this file away, and {self._advice}"
            raise FileError(f"{error.message}; {advice}", self.out) from error
        require_same_run(self.out, attributes, self.header)
        try:
            header = read_header(self.folder)
        except (FileNotFoundError, FileError):
            return False
        require_same_run(self.folder, header.attributes("stopped"), self.header)
        return bool(contiguous_parts(self.folder))

    def _take_up_failed(self) -> None:
        """Turn a failed result back into parts, to go on from its last increment. OUT goes last, so nothing is lost."""
        self._take_up_file(self.out)
        self.remove_parts()
        self.write_header()
        if self.last_state is not None:
            self.parts = [merge_parts(self.folder, self.header, [self.out], self.last_state)]
        atomic_files.remove(self.out)

    def _take_up_stopped(self) -> None:
        """Go on from the parts of a stopped run. Raises FileError."""
        require_same_run(self.folder, read_header(self.folder).attributes("stopped"), self.header)
        self._settle_parts(self._read_parts())

    def _read_parts(self) -> dict[Part, FileError]:
        """Take up the increments up to which all parts are undamaged, and return those that are damaged.

        In place of a damaged merged part, those that it was merged from are taken if they are still there.
        """
        damaged: dict[Part, FileError] = {}
        for part in all_parts(self.folder):
            if part.first != len(self.summaries):
                continue
            try:
                self._take_up_file(part.path)
            except FileError as error:
                damaged[part] = error
            else:
                self.parts.append(part)
        return damaged

    def _settle_parts(self, damaged: Mapping[Part, FileError]) -> None:
        """Set the parts aside that follow those taken up, and remove those that merged ones hold. Raises FileError."""
        parts, next_step = all_parts(self.folder), len(self.summaries)
        if not self.parts:
            first = next(iter(damaged.values()))
            message = f"{first.message}, and there is no saved increment before it: --overwrite starts anew"
            raise FileError(message, first.file) from first
        for part, problem in damaged.items():
            if part.last < next_step:
                self.notes.append(f"{problem}; its increments are taken from the parts that it was merged from")
        if later := [part for part in parts if part.last >= next_step]:
            found = [str(damaged[part]) for part in later if part in damaged]
            damage = found[0] if found else f"increment {next_step} is missing in {self.folder}"
            aside = set_aside(self.folder, [part.path for part in later])
            self.notes.append(f"{damage}; going on from increment {next_step}. What follows was moved to {aside.name}")
        kept = {part.path for part in self.parts}
        atomic_files.remove(*[part.path for part in all_parts(self.folder) if part.path not in kept])  # merged

    def _take_up_file(self, path: Path) -> None:
        """Go on after the last increment of a file. Raises FileError, and changes nothing, if it is damaged."""
        with Piece(path) as piece:
            piece.verify()
            piece.require_run(self.header)
            piece.require_steps(self.header.stores_fields)
            piece.require_fields(self.header.shape)
            summaries = piece.summaries()
            self.last_state = piece.state() if summaries else None
            self.summaries += summaries
