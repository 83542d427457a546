"""Completion of commands in the shell."""

from __future__ import annotations

import pytest
from command_line import finish

COMPLETED = {
    "va": ["validate"],
    "run --re": ["--resume"],
    "new mo": ["mode1", "mode2", "mode3"],
    "export x.h5 --to v": ["vtk"],
}


@pytest.mark.parametrize("typed", COMPLETED)
def test_shell_completes_commands_options_and_values(typed: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("_FRETSOLVE_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", f"fretsolve {typed}")
    monkeypatch.setenv("COMP_CWORD", str(len(typed.split())))
    code, output, _ = finish()
    assert code == 0
    assert output.split() == [f"plain,{word}" for word in COMPLETED[typed]]


def test_shell_gets_a_script_for_completion(monkeypatch: pytest.MonkeyPatch) -> None:
    for shell in ("bash", "zsh", "fish"):
        monkeypatch.setenv("_FRETSOLVE_COMPLETE", f"{shell}_source")
        code, script, _ = finish()
        assert code == 0
        assert "_FRETSOLVE_COMPLETE" in script
