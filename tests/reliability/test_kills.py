"""SIGKILL at random moments: what was reported is readable, and a resume ends in the same file."""

from __future__ import annotations

import os
import random
import signal
import time
from pathlib import Path

import pytest
from runs import finish, readable, reported, run_line, start

from fretsolve.result import open_result

KILLS = int(os.environ.get("FRETSOLVE_KILLS", "25"))
RUN = {"increments": 40, "points": 12, "every": 3}
SEED = 20090131


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("reference") / "out.h5"
    assert finish(run_line(out, **RUN))[0] == 0
    return out


def test_random_kills_lose_nothing(uninterrupted: Path, tmp_path: Path) -> None:
    """Every other run holds in its last increment, so that the kill meets it under way."""
    with open_result(uninterrupted) as result:
        expected = result.history["P"]
    choice, last = random.Random(SEED), RUN["increments"] - 1
    out = tmp_path / "out.h5"
    kills = stopped_between = 0
    while kills < KILLS:
        already = readable(out, expected)
        holds = kills % 2
        process = start(run_line(out, "--resume", **RUN, **({"hold_at": last} if holds else {})))
        assert process.stdout is not None
        lines = [process.stdout.readline() for _ in range(choice.randint(holds, last - already))]
        time.sleep(choice.uniform(0.0, 0.02))
        process.send_signal(signal.SIGKILL)
        output, messages = process.communicate()
        assert "Traceback" not in messages
        saved = readable(out, expected)
        assert saved >= max(already, reported("".join(lines) + output))
        stopped_between += already < saved < RUN["increments"]
        kills += process.returncode == -signal.SIGKILL
        if process.returncode == 0 or kills == KILLS or saved >= last:
            assert finish(run_line(out, "--resume", **RUN))[0] == 0
            assert out.read_bytes() == uninterrupted.read_bytes()
            assert not out.with_name("out.h5.parts").exists()
            out.unlink()
    assert stopped_between >= KILLS // 2
