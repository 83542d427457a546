"""Go on from what an earlier run has left: OUT, its parts, or both, of which some may be damaged.

A damaged file is set aside, never removed, and the run goes on from the increments before it.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from fretsolve.case.dimensions import counted
from fretsolve.errors import CaseError, FileError
from fretsolve.result.header import RunHeader, require_same_run
from fretsolve.result.history import History
from fretsolve.result.part_reader import PartReader
from fretsolve.result.parts import (
    HEADER_NAME,
    ROUND_NAME,
    Part,
    all_parts,
    all_states,
    contiguous_parts,
    free_name,
    parts_folder,
    read_restart,
    read_state,
    write_state,
)
from fretsolve.result.reader import open_result, read_attributes, read_header
from fretsolve.result.state import State
from fretsolve.system import atomic_files
from fretsolve.system.files import require_free, require_regular

TO_GO_ON = "--overwrite replaces it, --resume goes on unless it is complete"
"""Advice for an existing result."""


class SavedRun:
    """The increments of a run that are saved, in OUT or in its parts.

    round: file of the complete round of an accuracy. parts: the files that hold the increments, in order. summaries: of
    all of them. last_state: where to go on from, None to start at the beginning. complete: OUT is there and nothing is
    to be done. notes: warnings about damaged files.
    """

    def __init__(self, out: Path, header: RunHeader, advice: str):
        """Begin with nothing taken up; advice: how to go on, for the messages of errors."""
        self.out, self.folder, self.header = out, parts_folder(out), header
        self.round = self.folder / ROUND_NAME
        self._advice = advice
        self.parts: list[Part] = []
        self.summaries = History()
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
        atomic_files.remove(*[part.path for part in all_parts(self.folder)], *all_states(self.folder))
        self.parts = []

    def take_up(self, shared: Mapping[int, Path], *, resume: bool, overwrite: bool, retry: bool) -> None:
        """Go on from what is there, or remove it for `overwrite`. The run has to be locked.

        shared: files of the increments 0 to a step, by that step; where nothing is there, the run begins with the
        longest of them. retry: whether to go on from a failed result. Raises as `HistoryWriter.open`.
        """
        # Another run may have ended in the meantime, so check everything again under the lock.
        require_free(self.out, overwrite=resume or overwrite, advice=TO_GO_ON)
        atomic_files.remove_temporaries(self.folder)
        if overwrite:
            # The header goes last: saved increments without it could not be told from another run's increments.
            atomic_files.remove(*[part.path for part in reversed(all_parts(self.folder))])
            self.remove_parts()
            atomic_files.remove(self.round)
            atomic_files.remove(self.out)
        elif self.out.exists():
            self._take_up_result(retry)
            return
        elif self.round.exists() and not resume:
            raise self._stopped_run()
        if not all_parts(self.folder):
            self.remove_parts()
            self._take_up_beginning(shared)
        elif not (self.folder / HEADER_NAME).exists() or not contiguous_parts(self.folder):
            missing = "the first of them" if (self.folder / HEADER_NAME).exists() else HEADER_NAME
            message = f"holds saved increments, but {missing} is missing, so they cannot be used"
            raise FileError(f"{message}: put it back, or start anew with --overwrite", self.folder)
        elif resume:
            require_same_run(self.folder, read_header(self.folder).attributes("stopped"), self.header)
            self._set_rest_aside(self._read_parts())
        else:
            raise self._stopped_run()

    def _stopped_run(self) -> CaseError:
        message = "a stopped run is there: --resume goes on with it, --overwrite starts anew"
        return CaseError(message, (), self.folder)

    def _take_up_beginning(self, shared: Mapping[int, Path]) -> None:
        """Take the longest shared beginning that is there as the first part."""
        for step in sorted(shared, reverse=True):
            try:
                require_regular(shared[step])
                content = shared[step].read_bytes()
                part = self._take_up_file(shared[step])
            except OSError:  # most likely it is not there yet
                continue
            except FileError:  # damaged, so it is written anew
                with suppress(OSError):
                    atomic_files.remove(shared[step])
                continue
            with atomic_files.new_file(part.path, self.folder) as file:
                file.write(content)
            self.parts = [part]
            return

    def take_final(self, retry: bool) -> bool:
        """Take OUT as it is if nothing is left to do, and return whether. Raises FileError if it is of another run."""
        with open_result(self.out) as result:
            require_same_run(self.out, result.attributes, self.header)
            status = result.status
        if status == "complete" or not retry:
            with PartReader(self.out) as reader:
                self.summaries = reader.summaries()
            self.complete = True
        return self.complete

    def _take_up_result(self, retry: bool) -> None:
        """Take OUT, or the parts beside it where OUT is damaged, or has failed and has fewer increments than they have.

        Parts are removed only after the result that holds them has been read whole. Raises FileError.
        """
        if saved := all_parts(self.folder):
            usable = self._require_own_parts()
            if (problem := self._problem_of_result(saved[-1].last + 1)) is not None:
                if not usable:
                    message = f"{problem.message}; the saved increments in {self.folder.name} cannot be used instead"
                    raise FileError(f"{message}: {HEADER_NAME} or the first of them is missing", self.out) from problem
                self._set_rest_aside(self._read_parts())
                aside = free_name(self.out)
                atomic_files.rename(self.out, aside)
                self.notes.append(f"{problem}; going on from {self.folder.name}. The file was moved to {aside.name}")
                return
        if self.take_final(retry):
            self.remove_parts()
            atomic_files.remove(self.round)
        else:
            self._take_up_failed()

    def _problem_of_result(self, saved: int) -> FileError | None:
        """Return why OUT cannot stand for the parts beside it, which have `saved` increments; None if it can."""
        try:
            with open_result(self.out) as result, PartReader(self.out) as reader:
                reader.verify()
                if result.status != "complete" and result.increments < saved:
                    there = f"has failed after {counted(result.increments, 'increment')}"
                    return FileError(f"{there}, {self.folder.name} has {saved}", self.out)
                if result.status != "complete" and result.increments:
                    read_restart(reader, self.header.shape)
        except FileError as damage:
            return damage
        return None

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
        """Turn a failed result back into a part, to go on from its last increment."""
        self.remove_parts()
        with open_result(self.out) as result:
            increments = result.increments
        if not increments:
            atomic_files.remove(self.out)
            return
        part = self._take_up_file(self.out)
        atomic_files.rename(self.out, part.path)
        self.parts = [part]

    def _take_up_file(self, path: Path) -> Part:
        """Go on after a file of the increments from the first one on, and return the part that it is to become.

        The header and the state of the part are written. Raises FileError, and changes nothing, if it is damaged.
        """
        with PartReader(path) as reader:
            summaries = reader.summaries()
            part = Part.named(self.folder, 0, len(summaries) - 1)
            reader.require_part(self.header, 0, part.last)
            reader.verify()
            state = read_restart(reader, self.header.shape)
        self.write_header()
        write_state(part, self.header, state)
        self.last_state, self.summaries = state, summaries
        return part

    def _read_parts(self) -> FileError | None:
        """Take up the increments from whose end the run can go on, and return what is damaged after them, if anything.

        These are the increments up to the newest state for which all parts are undamaged.
        """
        found, tables = list[Part](), list[NDArray[Any]]()
        problem: FileError | None = None
        parts = contiguous_parts(self.folder)
        if len(parts) < len(all_parts(self.folder)):
            problem = FileError(f"increment {parts[-1].last + 1} is missing", self.folder)
        for part in parts:
            try:
                with PartReader(part.path) as reader:
                    reader.require_part(self.header, part.first, part.last)
                    reader.verify()
                    tables.append(reader.rows)
            except FileError as error:
                problem = error
                break
            found.append(part)
        while found and self.last_state is None:
            try:
                self.last_state = read_state(found[-1], self.header.shape)
            except FileNotFoundError:
                problem = problem or FileError("is missing", found[-1].state)
                found.pop()
            except FileError as error:
                problem = problem or error
                found.pop()
        self.parts = found
        self.summaries = History.of_rows(tables[: len(found)])
        return problem

    def _set_rest_aside(self, problem: FileError | None) -> None:
        """Set the parts aside that follow the parts taken up. problem: why the run cannot go on from them."""
        if problem is None:
            return
        if not self.parts:
            message = f"{problem.message}, and there is no saved state before it: --overwrite starts anew"
            raise FileError(message, problem.file) from problem
        later = [part.path for part in all_parts(self.folder) if part.last > self.parts[-1].last]
        aside = free_name(self.folder)
        atomic_files.move(aside, *reversed(later))  # the last one first, so that those that are left follow each other
        there = f"{problem}; going on from increment {len(self.summaries)}"
        self.notes.append(f"{there}. What follows was moved to {aside.name}")
