"""``fretsolve run`` as a process: signals, kills, full disks and readers that go away cost no certified increment."""

from __future__ import annotations

import fcntl
import os
import random
import re
import resource
import signal
import subprocess
import time
from pathlib import Path

import pytest
from command_line import (
    PATIENCE,
    assert_same_result,
    environment,
    file_size_limit,
    finish,
    python,
    saved_steps,
    start,
    wait_for,
)
from small_cases import CASE, LONG, write_case
from sweeping import assert_as_serial, write_sweep

from fretsolve import open_result
from fretsolve.system.signals import NOTICE, SAME_SIGNAL

INCREMENTS = 42
KILLS = int(os.environ.get("FRETSOLVE_KILLS", "6"))


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    case = write_case(tmp_path_factory.mktemp("reference"), LONG)
    code, _, messages = finish("run", case, "-q")
    assert (code, messages) == (0, "")
    return case.with_suffix(".h5")


@pytest.fixture()
def case(tmp_path: Path) -> Path:
    return write_case(tmp_path, LONG)


def start_and_wait(case: Path, step: int = 0, *options: str) -> subprocess.Popen[str]:
    """A run that has just saved the increment `step`, and waits for readers before its last one: its pipe is small."""
    process = start("run", case, "-v", *options)
    assert process.stdout is not None
    fcntl.fcntl(process.stdout, fcntl.F_SETPIPE_SZ, 4096)
    for line in process.stdout:
        if line.startswith(f"step={step} "):
            return process
    raise AssertionError(f"ended with {process.wait()}")


def readable(out: Path) -> int:
    """Return how many increments can be read."""
    if not out.exists() and not list(out.with_name(out.name + ".parts").glob("*.h5")):
        return 0
    with open_result(out) as result:
        return result.increments


@pytest.mark.parametrize(
    "number", [signal.SIGTERM, *(pytest.param(one, marks=pytest.mark.slow) for one in (signal.SIGINT, signal.SIGUSR1))]
)
def test_signal_stops_the_run_and_a_resume_ends_alike(number: signal.Signals, case: Path, uninterrupted: Path) -> None:
    out = case.with_suffix(".h5")
    with start_and_wait(case, 3) as process:
        process.send_signal(number)
        output, messages = process.communicate()
    assert process.returncode == 75
    done = [3, *saved_steps(output)][-1] + 1
    assert 4 <= done < INCREMENTS
    assert messages.splitlines() == [
        f"fretsolve: {number.name}: {NOTICE}",
        f"stopped with {done} of {INCREMENTS} increments saved; to go on: fretsolve run {case} --resume",
    ]
    assert not out.exists()
    with open_result(out) as result:
        assert (result.status, result.increments) == ("stopped", done)
    code, output, messages = finish("run", case, "--resume")
    assert (code, messages) == (0, "")
    assert f"{INCREMENTS} increments, {done} of them done" in output
    assert saved_steps(output) == list(range(done, INCREMENTS))
    assert_same_result(out, uninterrupted)


@pytest.mark.slow
def test_random_kills_lose_nothing(case: Path, uninterrupted: Path) -> None:
    """A run that is near its end is resumed to it, and another one begun."""
    choice, out, done = random.Random(20090131), case.with_suffix(".h5"), 0
    for _ in range(KILLS):
        step = choice.randrange(done, INCREMENTS - 1)
        with start_and_wait(case, step, "--resume") as process:
            time.sleep(choice.uniform(0.0, 0.02))
            process.kill()
            output, messages = process.communicate()
        assert "Traceback" not in messages
        done = readable(out)
        assert done >= [step, *saved_steps(output)][-1] + 1
        if done > INCREMENTS // 2:
            assert finish("run", case, "--resume", "-q")[0] == 0
            assert_same_result(out, uninterrupted)
            assert sorted(path.name for path in case.parent.iterdir()) == ["case.h5", "case.yaml"]
            out.unlink()
            done = 0


@pytest.mark.slow
def test_second_signal_stops_at_once(case: Path, uninterrupted: Path) -> None:
    """Though the run waits for a reader of its lines."""
    with start_and_wait(case) as process:
        process.send_signal(signal.SIGINT)
        assert process.stderr is not None
        assert process.stderr.readline() == f"fretsolve: SIGINT: {NOTICE}\n"
        time.sleep(2.0 * SAME_SIGNAL)
        process.send_signal(signal.SIGTERM)
        assert process.wait(PATIENCE) == 75
    assert finish("run", case, "--resume", "-q") == (0, "", "")
    assert_same_result(case.with_suffix(".h5"), uninterrupted)


@pytest.mark.slow
def test_second_run_on_the_same_output_is_refused(case: Path) -> None:
    with start_and_wait(case) as process:
        process.send_signal(signal.SIGSTOP)
        with open_result(case.with_suffix(".h5")) as result:
            assert result.status == "running"
        for flags in ((), ("--resume",), ("--overwrite",)):
            code, output, messages = finish("run", case, *flags)
            assert (code, output) == (4, "")
            assert f"another run is writing this output (process {process.pid} on " in messages
            assert messages.count("\n") == 1
        process.kill()
        process.communicate()
    code, _, messages = finish("run", case)
    assert code == 2
    assert messages.endswith("a stopped run is there: --resume goes on with it, --overwrite starts anew\n")


@pytest.mark.slow
def test_full_disk(case: Path, uninterrupted: Path) -> None:
    """The disk is full once some increments are saved, and the run waits to tell them."""
    out = case.with_suffix(".h5")
    with start_and_wait(case, 3) as process:
        resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (10_000, 10_000))
        output, messages = process.communicate()
    assert process.returncode == 4
    assert messages.count("\n") == 1
    match = re.search(r"File too large; (\d+) of (\d+) increments are kept, --resume goes on\n$", messages)
    assert match
    assert 3 < [3, *saved_steps(output)][-1] + 1 <= readable(out) < INCREMENTS
    assert readable(out) == int(match[1]) < int(match[2]) <= INCREMENTS
    assert finish("run", case, "--resume", "-q") == (0, "", "")
    assert_same_result(out, uninterrupted)


@pytest.mark.parametrize("resume", [(), ("--resume",)])
def test_a_disk_that_has_no_room_for_one_increment(case: Path, resume: tuple[str, ...]) -> None:
    limit = file_size_limit(10_000)
    code, _, messages = finish("run", case, "--set", "grid.points=32", *resume, preexec_fn=limit)
    assert (code, messages.count("\n")) == (4, 1)
    assert messages.endswith("cannot save the increment: File too large; no increment is saved\n")
    assert sorted(case.parent.iterdir()) == [case]


def test_a_new_case_on_a_full_disk_leaves_nothing(tmp_path: Path) -> None:
    code, _, messages = finish("new", "rough", "-o", tmp_path / "x.yaml", preexec_fn=file_size_limit(60_000))
    assert (code, messages.count("\n")) == (4, 1)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("together", [False, True], ids=["output", "output and messages"])
def test_reader_that_goes_away(tmp_path: Path, together: bool) -> None:
    """As under ``| head -1``; with both streams in the pipe, the notice of a signal meets its end as well."""
    case = write_case(tmp_path, LONG.replace("times: 2", "times: 1000"))
    messages = subprocess.STDOUT if together else subprocess.PIPE
    with start("run", case, stderr=messages) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "long\n"
        process.stdout.close()
        wait_for(lambda: readable(case.with_suffix(".h5")) >= 3, process)
        process.send_signal(signal.SIGINT)
        assert process.wait(PATIENCE) == 75
    with open_result(case.with_suffix(".h5")) as result:
        assert (result.status, result.increments >= 3) == ("stopped", True)


@pytest.mark.parametrize("words", [("show",), ("validate",), ("check",), ("schema",)])
def test_reader_that_has_gone_is_no_error(words: tuple[str, ...], tmp_path: Path) -> None:
    case = write_case(tmp_path)
    if words == ("show",):
        assert finish("run", case, "-q")[0] == 0
        words = ("show", str(case.with_suffix(".h5")))
    elif words != ("schema",):
        words = (*words, str(case))
    reading, writing = os.pipe()
    os.close(reading)
    with start(*words, stdout=writing) as process:
        os.close(writing)
        _, messages = process.communicate()
    assert process.returncode == 0
    assert "Traceback" not in messages
    assert "BrokenPipe" not in messages


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_output_on_a_full_disk_keeps_the_increments(tmp_path: Path) -> None:
    with Path("/dev/full").open("w") as full:
        code, _, messages = finish("show", Path(__file__), stdout=full)
        assert (code, messages.count("\n")) == (4, 1)
        code, _, messages = finish("schema", stdout=full)
    assert (code, messages) == (4, "standard output: cannot be written: No space left on device\n")


def test_a_working_folder_that_is_gone(tmp_path: Path) -> None:
    gone = tmp_path / "gone"

    def enter() -> None:
        gone.mkdir()
        os.chdir(gone)
        gone.rmdir()

    code, _, messages = finish("run", write_case(tmp_path), "-o", "out.h5", preexec_fn=enter)
    assert (code, messages) == (4, "a file or the working folder: cannot be used: No such file or directory\n")


def test_an_interrupt_while_the_command_is_loaded(tmp_path: Path) -> None:
    (tmp_path / "click.py").write_text("import os, signal\nos.kill(os.getpid(), signal.SIGINT)\n")
    own = environment()
    own["PYTHONPATH"] = os.pathsep.join([str(tmp_path), own["PYTHONPATH"]])
    assert finish("--help", env=own) == (-signal.SIGINT, "", "")


def test_little_is_loaded_before_an_interrupt_is_handled() -> None:
    code = "import sys; before = set(sys.modules); import fretsolve.__main__; print(*sorted(set(sys.modules) - before))"
    assert set(python(code).split()) <= {"__future__", "_signal", "fretsolve", "fretsolve.__main__"}


def test_an_interrupt_that_a_library_turns_into_an_error(tmp_path: Path) -> None:
    (tmp_path / "h5py.py").write_text(
        "import os, signal\n"
        "try:\n    os.kill(os.getpid(), signal.SIGINT)\n"
        "except KeyboardInterrupt:\n    raise SystemError('failed to import')\n"
    )
    own = environment()
    own["PYTHONPATH"] = os.pathsep.join([str(tmp_path), own["PYTHONPATH"]])
    assert finish("show", Path(__file__), env=own) == (-signal.SIGINT, "", "")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_no_room_for_output_nor_for_messages() -> None:
    with Path("/dev/full").open("w") as full:
        assert finish("schema", stdout=full, stderr=full)[0] == 4


def test_streams_closed_before_the_start(tmp_path: Path) -> None:
    case = write_case(tmp_path)
    with start("run", case, preexec_fn=lambda: os.closerange(0, 3), stdout=None, stderr=None) as process:
        assert process.wait(PATIENCE) == 0
    with open_result(case.with_suffix(".h5")) as result:
        assert result.status == "complete"


def test_interrupted_check_ends_by_the_signal(tmp_path: Path) -> None:
    slow = CASE.replace("points: 16", "points: 64").replace("increments: 4", "increments: 4000")
    with start("check", write_case(tmp_path), write_case(tmp_path, slow, "slow.yaml")) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == f"{tmp_path}/case.yaml\n"
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        _, messages = process.communicate()
    assert process.returncode == -signal.SIGINT
    assert "Traceback" not in messages


def test_numerics_are_set_up_before_they_are_loaded() -> None:
    code = (
        "import os, sys; os.environ.pop('OPENBLAS_NUM_THREADS', None)\n"
        "from fretsolve.cli import main; print('numpy' in sys.modules); main.set_up_numerics()\n"
        "print(os.environ['OPENBLAS_NUM_THREADS'])"
    )
    assert python(code).split() == ["False", "1"]


@pytest.mark.parametrize("kilobytes", [250_000, 500_000])
@pytest.mark.parametrize("words", [("run", "-q"), ("check",), ("validate",)])
def test_too_low_a_limit_of_memory_ends_in_a_line(tmp_path: Path, kilobytes: int, words: tuple[str, ...]) -> None:
    limit = 1024 * kilobytes
    code, _, messages = finish(
        words[0],
        write_case(tmp_path),
        *words[1:],
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)),
    )
    assert code == 2
    assert messages == f"not enough memory: the limit (ulimit -v or -d) is {kilobytes} kB; 614400 kB are needed\n"


def test_a_grid_beyond_the_limit_of_memory(tmp_path: Path) -> None:
    case, limit = write_case(tmp_path, CASE.replace("points: 16", "points: 2048")), 2**30
    code, _, messages = finish("run", case, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)))
    assert (code, messages.count("\n")) == (2, 1)
    assert "2048 x 2048 cells take about" in messages
    assert "of address space, the limit (ulimit -v or -d) is 1.1 GB; a higher one or fewer points" in messages
    assert [path.name for path in tmp_path.iterdir()] == ["case.yaml"]


@pytest.mark.slow
@pytest.mark.parametrize("files", [7, 12])
def test_too_low_a_limit_of_open_files(case: Path, files: int) -> None:
    code, _, messages = finish(
        "run", case, "-q", preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (files, files))
    )
    assert code in (0, 4)
    assert messages.count("\n") == (code == 4)
    assert code == 0 or "Too many open files" in messages


@pytest.mark.slow
def test_two_sweeps_at_once_in_one_folder(tmp_path: Path) -> None:
    """Whichever takes a case first, all have their results in the end, as if one process had worked."""
    path = write_sweep(tmp_path)
    with start("sweep", "run", path, "-j", 1) as one, start("sweep", "run", path, "-j", 1) as other:
        for process in (one, other):
            _, messages = process.communicate(timeout=PATIENCE)
            assert process.returncode in (0, 75), messages
            assert "Traceback" not in messages
    assert finish("sweep", "run", path, "-q")[0] == 0
    assert assert_as_serial(tmp_path / "sweep.sweep", tmp_path / "case.yaml") == 6
    names = {entry.suffix for entry in (tmp_path / "sweep.sweep" / "results").iterdir()}
    assert names == {".h5"}
