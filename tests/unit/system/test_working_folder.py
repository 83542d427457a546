"""A folder for what only the making of a file needs: it goes with the block, at signals, and a day after a kill."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import pytest
from command_line import ended, start_python, wait_for

from fretsolve.system.atomic_files import working_folder

CODE = """
import sys, time
from pathlib import Path
from fretsolve.system.atomic_files import working_folder
with working_folder(Path(sys.argv[1])) as folder:
    (folder / "stress.h5").touch()
    while True:  # a signal just before a long sleep would wait for its end
        time.sleep(0.05)
"""


@pytest.mark.parametrize(("number", "left"), [(signal.SIGTERM, 0), (signal.SIGHUP, 0), (signal.SIGKILL, 1)])
def test_folder_at_signals(tmp_path: Path, number: signal.Signals, left: int) -> None:
    process = start_python("-c", CODE, tmp_path / "out.fatigue.h5")
    wait_for(lambda: list(tmp_path.glob("*/stress.h5")), process)
    process.send_signal(number)
    assert ended(process)[0] == -number
    assert len(list(tmp_path.iterdir())) == left


def test_what_kills_have_left_goes_after_a_day(tmp_path: Path) -> None:
    target = tmp_path / "out.fatigue.h5"
    names = ("out.fatigue.abcd_012.tmp", "out.fatigue.new_0123.tmp", "other.abcd_012.tmp", "out.fatigue.tmp")
    folders = [tmp_path / name for name in names]
    for folder in folders:
        folder.mkdir()
        (folder / "stress.h5").touch()
    before = time.time() - 90_000.0
    for folder in (folders[0], *folders[2:]):
        for path in (folder / "stress.h5", folder):
            os.utime(path, (before, before))
    with pytest.raises(RuntimeError), working_folder(target) as own:
        assert own.parent == tmp_path
        raise RuntimeError
    assert sorted(tmp_path.iterdir()) == sorted(folders[1:])


def test_a_handler_of_somebody_else_stays(tmp_path: Path) -> None:
    previous = signal.signal(signal.SIGTERM, lambda *_: None)
    try:
        own = signal.getsignal(signal.SIGTERM)
        with working_folder(tmp_path / "out.h5"):
            assert signal.getsignal(signal.SIGTERM) is own
    finally:
        signal.signal(signal.SIGTERM, previous)
