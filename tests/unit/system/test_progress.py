"""Progress on a terminal, which a pseudo-terminal stands for here."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from command_line import start
from small_cases import CASE, write_case


def shown_on_a_terminal(case: Path, *words: str) -> tuple[int, str]:
    """Exit code and all that a run sends to its terminal."""
    terminal, end = os.openpty()
    with start("run", case, *words, stdout=end, stderr=end) as process:
        os.close(end)
        content = b""
        while chunk := _read(terminal):
            content += chunk
    os.close(terminal)
    return process.returncode, content.decode()


def _read(terminal: int) -> bytes:
    try:
        return os.read(terminal, 65536)
    except OSError:  # the other end is closed
        return b""


def test_bar_then_table(tmp_path: Path) -> None:
    case = write_case(tmp_path, CASE.replace("increments: 4", "increments: 30"))
    code, shown = shown_on_a_terminal(case)
    assert code == 0
    assert "stage 2/2" in shown
    assert "31/31" in shown
    assert "residual" in shown
    assert "step=0" not in shown
    assert shown.rstrip().endswith(f"complete: {case.with_suffix('.h5')}, 31 increments")


def test_bar_gives_way_to_an_error(tmp_path: Path) -> None:
    case = write_case(tmp_path, CASE.replace("20 N", "50 N"))
    code, shown = shown_on_a_terminal(case)
    assert code == 3
    assert shown.rstrip().splitlines()[-1].startswith(f"{case}:10: stage.2.Qx: gross slip")


def test_quiet_on_a_terminal(tmp_path: Path) -> None:
    assert shown_on_a_terminal(write_case(tmp_path), "-q", "--set", "grid.points=32") == (0, "")


@pytest.mark.slow
def test_no_color_is_heeded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm-256color")
    colour = "\x1b[3"  # sets a colour of the foreground; moving the cursor has other codes
    code, shown = shown_on_a_terminal(write_case(tmp_path, CASE.replace("increments: 4", "increments: 30")))
    assert (code, colour in shown) == (0, True)
    monkeypatch.setenv("NO_COLOR", "1")
    code, shown = shown_on_a_terminal(tmp_path / "case.yaml", "--overwrite")
    assert (code, colour in shown) == (0, False)
