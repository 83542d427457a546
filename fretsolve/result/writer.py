"""Write a result so that no completed increment is lost, whenever the run ends and however.

Increments are files in ``OUT.parts/``, each committed by a rename. OUT is written once, from them, when the run is
complete or has failed. If OUT exists, it is the result and its parts are leftovers.
"""

from __future__ import annotations

import os
import time
from collections.abc import Collection, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from typing import Any, Literal

import h5py

from fretsolve.errors import FileError
from fretsolve.result.header import RunHeader
from fretsolve.result.history import History
from fretsolve.result.lock import RunLock
from fretsolve.result.parts import HEADER_NAME, all_parts, all_states, write_part, write_result
from fretsolve.result.reader import read_attributes
from fretsolve.result.resume import TO_GO_ON, SavedRun
from fretsolve.result.state import Fields, State, broadcast_zeros
from fretsolve.system import atomic_files
from fretsolve.system.files import reason_of, reported, require_free, require_regular

STATES_KEPT = 16
"""So many of the newest states are kept, and one of so many before: where a run can go on if a part is damaged."""

RESUME, SAME_COMMAND = "--resume goes on", "the same command goes on"
"""Advice for a run of one case, and for one of several cases."""

NOTHING_SHARED: Mapping[int, Path] = {}


def _require_name(out: Path) -> None:
    """Raise FileError if the result could not be written to `out` at the end of the run."""
    if out.is_symlink() and not out.exists():
        raise FileError("is a link to a file that does not exist; remove it, or give another name", out)
    with suppress(OSError):  # a folder that is not there is reported when it is needed
        spare = os.pathconf(out.absolute().parent, "PC_NAME_MAX") - len(os.fsencode(out.name))
        if spare < atomic_files.LONGEST_ENDING:
            message = "the name is too long: a run adds an ending to it, so it must be shorter by"
            raise FileError(f"{message} {atomic_files.LONGEST_ENDING - spare} bytes", out)


def _fields_alone(fields: Fields, names: Collection[str]) -> Fields:
    """Return `fields` with `broadcast_zeros` in place of all but `names`."""
    arrays: dict[str, Any] = {
        name: array if array is None or name in names else broadcast_zeros(array.shape)
        for name, array in vars(fields).items()
    }
    return Fields(**arrays)


def _release(lock: RunLock) -> None:
    """Let other runs write, and remove the header of a run without saved increments."""
    with suppress(OSError):
        if not all_parts(lock.folder):
            atomic_files.remove(lock.folder / HEADER_NAME, *all_states(lock.folder))  # nothing to go on from
    lock.release()


class HistoryWriter(AbstractContextManager["HistoryWriter"]):
    """A result being written; a context manager, which stops the run if it is left without `finish`.

    complete: OUT exists already and there is nothing to do. last_state: where to go on from, None to start at the
    beginning. increments: their number so far; summaries: of all of them, which a run that goes on from them adds to
    before they come here, none once it is finished. notes: warnings about the resume, and a lock that there is not.
    """

    def __init__(
        self,
        saved: SavedRun,
        lock: RunLock | None,
        pause: float = 0.0,
        advice: str = RESUME,
        shared: Mapping[int, Path] = NOTHING_SHARED,
        in_rounds: bool = False,
    ):
        """Go on from `saved`; lock: on the folder of the parts, None if nothing is written; the rest as for `open`."""
        self.out, self.header = saved.out, saved.header
        self.complete, self.notes = saved.complete, saved.notes
        self.last_state, self.summaries = saved.last_state, saved.summaries
        self.increments = len(self.summaries)
        self._saved, self._lock = saved, lock
        self._pause, self._advice, self._shared, self._in_rounds = pause, advice, shared, in_rounds
        self._saved_at = time.monotonic()
        self._unsaved: list[State] = []

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
        in_rounds: bool = False,
    ) -> HistoryWriter:
        """Begin the result `out`, or go on with it.

        retry: whether to resume a failed one; otherwise it stays as it is. pause: seconds for which increments may stay
        unsaved. advice: how to go on, for the message if nothing more can be saved. shared: a new result begins with
        the longest of these files that is there, and writes the missing ones. in_rounds: what is complete is a round of
        an accuracy, and becomes OUT by `give_round`. Raises CaseError if `out` or its parts
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
            saved = SavedRun(out, header, advice)
            # Without a lock, since a complete result may lie in a folder that cannot be written.
            if resume and out.exists() and not saved.folder.exists() and saved.take_final(retry):
                return cls(saved, None, pause, advice, shared, in_rounds)
            lock = RunLock.acquire(saved.folder)
            saved.notes += filter(None, [lock.note])
            try:
                saved.take_up(shared, resume=resume, overwrite=overwrite, retry=retry)
                if not pause and not saved.complete:
                    saved.write_header()
            except BaseException:
                _release(lock)
                raise
            return cls(saved, lock, pause, advice, shared, in_rounds)

    def __exit__(self, *_: object) -> None:
        self.stop()

    def append(self, state: State) -> None:
        """Commit an increment: once this returns, no kill and no power cut takes it back, unless there is a pause.

        Raises FileError if it cannot be written (all earlier increments stay), ValueError if `state` does not follow
        the last one or does not have error bars as the header says.
        """
        if (state.errors is not None) != self.header.errors:
            raise ValueError("either every increment has error bars or none, as the header says")
        if state.summary.step != self.increments:
            raise ValueError(f"increment {state.summary.step} does not follow {self.increments - 1}")
        self.last_state = state
        if len(self.summaries) == self.increments:
            self.summaries.append(state.summary)
        self.increments += 1
        self._unsaved.append(state)
        if len(self._unsaved) > 1:
            # Nothing goes on from the state before. Its arrays, if kept, would take up to 7 % of small grids' time:
            # new ones would not lie in the cache.
            before = self._unsaved[-2]
            names = self.header.fields if self.header.stores_fields(before.summary.step) else ()
            fields = _fields_alone(before.fields, names)
            self._unsaved[-2] = State(before.summary, fields, broadcast_zeros(before.displacement.shape), before.errors)
        self._write_shared(state)
        if time.monotonic() - self._saved_at >= self._pause:
            self.save()

    def is_saved(self, step: int) -> bool:
        """Return whether increment `step` is committed."""
        return step < self.increments - len(self._unsaved)

    def save(self) -> None:
        """Commit the increments that a pause has left unsaved. Raises FileError."""
        with self._reported("cannot save the increment", self._saved.folder):
            if not (self._saved.folder / HEADER_NAME).exists():
                self._saved.write_header()
            if self._unsaved:
                self._saved.parts.append(write_part(self._saved.folder, self.header, self._unsaved))
                self._unsaved.clear()
                old = len(self._saved.parts) - STATES_KEPT
                if old > 0 and old % STATES_KEPT:
                    atomic_files.remove(self._saved.parts[old - 1].state, durable=False)
        self._saved_at = time.monotonic()

    def finish(self, status: Literal["complete", "failed"], message: str = "", kind: str = "") -> None:
        """Write OUT from the parts and remove them; other runs may write after `stop`. message, kind: why it failed.

        In rounds a complete one is kept beside OUT, and takes OUT's place if the round that follows it has failed.
        Raises FileError, also if another file has taken OUT's name under way; the increments stay in the parts then.
        """
        failure = (message, kind) if status == "failed" else None
        self.summaries = History()  # the result has them from the parts: of a long history both would take much memory
        if failure is not None and self._in_rounds and self.round.exists():
            self.give_round()
            return
        with self._reported("cannot write the result", self.out):
            try:
                is_round = self._in_rounds and failure is None
                out = self.round if is_round else self.out
                self._write(out, self._saved.folder, status, failure, exclusive=not is_round)
            except OSError:
                self.save()  # what a pause has left unsaved
                raise
            self._unsaved.clear()
            self._saved.remove_parts()

    @property
    def round(self) -> Path:
        """File of the round of an accuracy that is complete, if there is one."""
        return self._saved.round

    @property
    def holds_round(self) -> bool:
        """True if the round of the header is complete, and a kill has come before it was judged."""
        with suppress(OSError, FileError):
            return str(read_attributes(self.round)["effective_case"]) == self.header.effective_case
        return False

    def begin_round(self, header: RunHeader) -> None:
        """Begin the round that follows the complete one, which is kept. Raises FileError."""
        self.working_folder()
        with self._reported("cannot begin the next round", self.out):
            if self.complete:
                atomic_files.rename(self.out, self.round)
            self._saved = SavedRun(self.out, header, self._advice)
        self.header, self.complete = header, False
        self.last_state, self.summaries, self.increments = None, self._saved.summaries, 0

    def give_round(self) -> None:
        """Let the complete round be the result. Raises FileError."""
        with self._reported("cannot write the result", self.out):
            atomic_files.rename(self.round, self.out)
            self._unsaved.clear()
            self._saved.remove_parts()

    def working_folder(self) -> Path:
        """Return a folder for what is made beside a complete result; a kill leaves it to the next run, which clears it.

        It is locked until `stop`. Raises FileError, also if another run holds it.
        """
        if self._lock is None:
            with reported("its side outputs cannot be written", self.out):
                self._lock = RunLock.acquire(self._saved.folder)
        return self._saved.folder

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
        if not all(part.path.exists() for part in self._saved.parts):
            return "saved increments were removed under way"
        saved = self.increments - len(self._unsaved)
        if not saved:
            return "no increment is saved"
        return f"{saved} of {self.increments} increments are kept, {self._advice}"

    def _write(
        self,
        out: Path,
        folder: Path,
        status: Literal["complete", "failed", "stopped"],
        failure: tuple[str, str] | None = None,
        *,
        exclusive: bool = True,
    ) -> None:
        saved = self._saved.parts, self._unsaved, self.last_state
        write_result(out, folder, self.header, *saved, status, failure, exclusive=exclusive)

    def stop(self) -> None:
        """Leave the committed increments for a later resume, and let other runs write."""
        if self._lock is not None:
            _release(self._lock)
            self._lock = None

    def _write_shared(self, state: State) -> None:
        """Write a shared beginning that ends with `state`, unless it is there or cannot be written."""
        path = self._shared.get(state.summary.step)
        if path is not None and not path.exists():
            with suppress(OSError):
                atomic_files.add_folder(path.parent)
                self._write(path, path.parent, "stopped")
