"""A closed terminal stops a run as SIGTERM does; under nohup the run goes on, whatever becomes of its output."""

from __future__ import annotations

import fcntl
import os
import pty
import signal
import subprocess
import termios
from collections.abc import Callable
from pathlib import Path

import pytest
from command_line import PATIENCE, assert_same_result, finish, invoke, start, wait_for
from small_cases import CASE, LONG, write_case
from sweeping import many_cases, rows_of, workers, write_sweep

from fretsolve import open_result

MANY = CASE.replace("increments: 4", "increments: 4000")


class Terminal:
    """A terminal in which a command runs. begin: what the command's process does first."""

    def __init__(self, *words: object, begin: Callable[[], object] = lambda: None):
        self.master, own = pty.openpty()

        def enter() -> None:
            fcntl.ioctl(own, termios.TIOCSCTTY, 0)  # it gets SIGHUP when the terminal is closed
            begin()

        streams = {"stdin": own, "stdout": own, "stderr": own, "start_new_session": True}
        self.process: subprocess.Popen[str] = start(*words, preexec_fn=enter, **streams)
        os.close(own)

    def close(self) -> int:
        """Close it, and return the exit code of the command."""
        os.close(self.master)
        return self.process.wait(PATIENCE)


def ignore() -> None:
    """Ignore SIGHUP, as nohup does."""
    signal.signal(signal.SIGHUP, signal.SIG_IGN)


def test_a_closed_terminal_stops_a_run_after_its_increment(tmp_path: Path) -> None:
    case = write_case(tmp_path, MANY)
    terminal = Terminal("run", case)
    wait_for(lambda: list(tmp_path.glob("case.h5.parts/*.npz")), terminal.process)
    assert terminal.close() == 75
    with open_result(case.with_suffix(".h5")) as result:
        assert result.status == "stopped"
        assert 0 < result.increments < 4001


def test_under_nohup_a_run_goes_on_without_its_terminal(tmp_path: Path) -> None:
    case = write_case(tmp_path)
    assert Terminal("run", case, begin=ignore).close() == 0
    with open_result(case.with_suffix(".h5")) as result:
        assert (result.status, result.increments) == ("complete", 5)


@pytest.mark.slow
def test_under_nohup_a_run_with_a_bar_goes_on(tmp_path: Path) -> None:
    case, other = write_case(tmp_path, LONG), write_case(tmp_path, LONG, "other.yaml")
    terminal = Terminal("run", case, begin=ignore)
    assert os.read(terminal.master, 10)
    wait_for(lambda: list(tmp_path.glob("case.h5.parts/*.npz")), terminal.process)
    assert terminal.close() == 0
    assert finish("run", other, "-q")[0] == 0
    assert_same_result(case.with_suffix(".h5"), other.with_suffix(".h5"))


@pytest.mark.slow
def test_a_closed_terminal_stops_a_sweep_and_its_processes(tmp_path: Path) -> None:
    path, folder = write_sweep(tmp_path, many_cases(8), LONG), tmp_path / "sweep.sweep"
    terminal = Terminal("sweep", "run", path, "-j", 2)
    wait_for(lambda: len(workers(folder)) == 2, terminal.process)
    processes = workers(folder)
    assert terminal.close() == 75
    assert not any(Path(f"/proc/{process}").exists() for process in processes)
    assert not list((folder / "results").glob("*.note")), "no case counts as ended"
    assert len(list((folder / "results").glob("*.h5"))) < len(rows_of(folder))


@pytest.mark.slow
def test_a_closed_terminal_stops_a_study(tmp_path: Path) -> None:
    case = write_case(tmp_path, MANY)
    terminal = Terminal("study", case, "--vary", "grid.points=12,16")
    wait_for(lambda: list(tmp_path.glob("case.study/*.parts/*.npz")), terminal.process)
    assert terminal.close() == 75


def test_what_a_closed_terminal_does_not_take_is_no_error(tmp_path: Path) -> None:
    assert invoke("new", "hertz", "-o", tmp_path / "x.yaml").exit_code == 0
    assert Terminal("validate", tmp_path / "x.yaml", begin=ignore).close() == 0
