"""Studies of cases that expect quantities of cycles, and of files that a study does not write."""

from __future__ import annotations

from pathlib import Path

from command_line import invoke
from small_cases import LOOP, write_case

EXPECT = """\
output: {stress: {depths: [0 mm]}}
expect:
  - {quantity: max_mises, value: 1000 MPa, rel: 1 %}
  - {quantity: slip_amplitude, value: 1 um, rel: 1 %}
  - {quantity: energy_ratio, value: 0.2, rel: 1 %}
  - {quantity: dissipated_energy, value: 10 uJ, rel: 1 %, cycle: 1}
"""


def test_what_takes_files_or_fields_is_left_out_and_cycles_are_compared(tmp_path: Path) -> None:
    case = write_case(tmp_path, LOOP + EXPECT)
    words = ("study", case, "--vary", "grid.points=8,12", "-o", tmp_path / "study", "--truth", "expect")
    result = invoke(*words)
    assert result.exit_code == 0, result.stderr
    table = result.stdout.partition("worst")[2]
    assert "@last" in table and "@1 %" in table
    assert "mises" not in table and "slip" not in table
    result = invoke(*words, "--quantity", "max_mises")
    assert result.exit_code == 0, result.stderr
    assert "mises" in result.stdout
