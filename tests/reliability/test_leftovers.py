"""What a killed run leaves of its side outputs lies in OUT.parts, which stays locked; the next run clears it."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest
from command_line import finish, invoke, refused, result_of, start, wait_for
from small_cases import TWO_CYCLES, write_case

SIDES = """\
output:
  stress: {every: 1, depths: [0, 20 um, 40 um]}
  fatigue: {criteria: [crossland], depths: [0, 20 um], material: {tension_limit: 300 MPa, torsion_limit: 190 MPa}}
"""
FILES = {"case.yaml", "case.h5", "case.stress.h5", "case.fatigue.h5"}


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


@pytest.mark.slow
def test_a_resume_clears_what_a_kill_has_left(tmp_path: Path) -> None:
    case = write_case(tmp_path, TWO_CYCLES + SIDES)
    out = result_of(case)
    assert names(tmp_path) == FILES
    whole = {name: (tmp_path / name).read_bytes() for name in ("case.stress.h5", "case.fatigue.h5")}
    parts = tmp_path / "case.h5.parts"
    (parts / "case.fatigue.abcd_012.tmp").mkdir(parents=True)
    for left in ("lock", "case.stress.h5.0123456789abcdef.tmp", "case.fatigue.abcd_012.tmp/stress.h5"):
        (parts / left).touch()
    (tmp_path / "case.stress.h5").unlink()
    assert invoke("run", case, "--resume", "-q").exit_code == 0
    assert names(tmp_path) == FILES
    assert {name: (tmp_path / name).read_bytes() for name in whole} == whole
    assert out.exists()


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["stress", "fatigue"])
def test_a_run_that_is_killed_in_its_side_outputs(tmp_path: Path, kind: str) -> None:
    depths = ", ".join(f"{depth}.5 um" for depth in range(30, 40))
    case = write_case(tmp_path, TWO_CYCLES + SIDES.replace("0, 20 um", f"0, {depths}"))
    parts = tmp_path / "case.h5.parts"
    with start("run", case, "-q") as process:
        wait_for(lambda: list(parts.glob(f"case.{kind}.*tmp")), process)
        process.send_signal(signal.SIGSTOP)
        assert "another run is writing this output" in refused(4, "run", case, "--resume", "-q")
        process.kill()
    assert names(tmp_path) - FILES == {"case.h5.parts"}
    assert finish("run", case, "--resume", "-q") == (0, "", "")
    assert names(tmp_path) == FILES
