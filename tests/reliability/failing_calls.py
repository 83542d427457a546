"""Commands whose n-th call of the operating system on files below a folder fails; `failing_calls.c` makes it fail."""

from __future__ import annotations

import json
import struct
import subprocess
import sys
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path

from command_line import environment

KINDS = ("open", "read", "write", "truncate", "sync", "rename", "link", "unlink", "mkdir", "close")
"""Of failing calls, as the library counts them."""

_CONTROL = struct.Struct(f"512s3l{len(KINDS)}l")
"""Of the library: folder, kind, number, error, and the calls of each kind so far."""

_SERVER = """
import gc, importlib, json, os, pkgutil, signal, sys
from contextlib import suppress
sys.path.remove("")
import fretsolve
from fretsolve.__main__ import start
for module in pkgutil.walk_packages(fretsolve.__path__, "fretsolve."):
    with suppress(ImportError):  # of what is optional
        importlib.import_module(module.name)
gc.freeze()  # a third of the time of a fork
for line in sys.stdin:
    words, folder, said = json.loads(line)
    child = os.fork()
    if child == 0:
        for descriptor, name in enumerate((os.devnull, said + "/output", said + "/messages")):
            os.dup2(os.open(name, os.O_RDWR | os.O_CREAT | os.O_TRUNC), descriptor)
        os.chdir(folder)
        signal.alarm(120)
        sys.argv = ["fretsolve", *words]
        start()
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""
"""Runs commands, each in a fork of its own, which ends as any interpreter does. To start one anew takes a second."""


@dataclass(frozen=True)
class Ended:
    """How a command has ended; calls: on files below the folder, of each of `KINDS`."""

    code: int
    output: str
    messages: str
    calls: dict[str, int]


class FailingCalls(AbstractContextManager["FailingCalls"]):
    """Runs commands in folders, with a call that fails. library: the compiled one; scratch: a folder of its own."""

    def __init__(self, library: Path, scratch: Path):
        self._control, self._scratch = scratch / "control", scratch
        self._control.touch()
        self._set("")
        given = environment() | {"LD_PRELOAD": str(library), "FAILING_CALLS": str(self._control)}
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        self._server = subprocess.Popen([sys.executable, "-c", _SERVER], env=given, **pipes)

    def __exit__(self, *_: object) -> None:
        self._server.communicate()

    def _set(self, folder: str, kind: int = -1, number: int = -1, error: int = 0) -> None:
        values = _CONTROL.pack(folder.encode(), kind, number, error, *(0 for _ in KINDS))
        with self._control.open("r+b") as file:  # the library has it in its memory
            file.write(values)

    def run(self, folder: Path, *words: object, kind: str = "", number: int = -1, error: int = 0) -> Ended:
        """Run ``fretsolve WORDS...`` in `folder`; call `number` (from 0) of a kind below it fails with an `errno`."""
        self._set(str(folder), KINDS.index(kind) if kind else -1, number, error)
        print(json.dumps([[*map(str, words)], str(folder), str(self._scratch)]), file=self._server.stdin, flush=True)
        code = int(self._server.stdout.readline())
        calls = _CONTROL.unpack(self._control.read_bytes())[4:]
        said = ((self._scratch / name).read_text() for name in ("output", "messages"))
        return Ended(code, *said, dict(zip(KINDS, calls, strict=True)))
