"""Messages of a run: JSON lines, the whole history on request, colours only on a terminal."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from command_line import finish, invoke, refused
from small_cases import CASE, write_case

from fretsolve import open_result
from fretsolve.result.layout import HISTORY

NAMES = {quantity.name for quantity in HISTORY}


def events(output: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in output.splitlines()]


def test_json_lines_tell_the_whole_run(tmp_path: Path) -> None:
    case = write_case(tmp_path)
    result = invoke("run", case, "--log-json")
    assert (result.exit_code, result.stderr) == (0, "")
    start, warning, *increments, end = events(result.stdout)
    assert (start["event"], start["increments"], start["stages"], start["points"]) == ("start", 5, 2, [16, 16])
    assert (start["case"], start["result"]) == (str(case), str(case.with_suffix(".h5")))
    assert warning["event"] == "warning"
    assert warning["message"].startswith("grid.points: only 13.3 cells")
    assert [line["event"] for line in increments] == ["increment"] * 5
    assert all(line.keys() >= NAMES | {"step", "increments", "stages"} for line in increments)
    with open_result(case.with_suffix(".h5")) as found:
        for name in NAMES:
            assert [line[name] for line in increments] == found.history[name].tolist()
    assert (end["event"], end["status"], end["increments"]) == ("end", "complete", 5)
    again = events(invoke("run", case, "--log-json", "--resume").stdout)
    assert again == [{"event": "end", "status": "complete", "result": start["result"], "increments": 5}]


def test_json_lines_of_a_run_that_fails(tmp_path: Path) -> None:
    result = invoke("run", write_case(tmp_path, CASE.replace("20 N", "50 N")), "--log-json")
    assert result.exit_code == 3
    end = events(result.stdout)[-1]
    assert (end["event"], end["status"], end["increments"]) == ("end", "failed", 4)
    assert f"{end['message']}\n" == result.stderr


def test_json_has_no_nan(tmp_path: Path) -> None:
    case = write_case(tmp_path, CASE.replace("points: 16", "points: 32"))
    result = invoke("run", case, "--log-json", "--error-bars")
    assert result.exit_code == 0, result.stderr
    increments = [line for line in events(result.stdout) if line["event"] == "increment"]
    assert all("delta_x_error" in line for line in increments)
    assert "NaN" not in result.stdout


def test_verbose_tells_stages_settings_and_all_of_the_history(tmp_path: Path) -> None:
    result = invoke("run", write_case(tmp_path), "-v")
    assert result.exit_code == 0
    assert "stage 2: Qx -> 20 N in 4 increments" in result.stdout
    assert "threads: 1, tolerance: 1e-06, at most 2000 iterations" in result.stdout
    lines = [line.split() for line in result.stdout.splitlines() if line.startswith("step=")]
    assert len(lines) == 5
    assert all({word.split("=")[0] for word in words} >= NAMES for words in lines)


@pytest.mark.parametrize("words", [("-q", "-v"), ("-q", "--log-json"), ("-v", "--log-json")])
def test_one_way_of_telling_at_a_time(tmp_path: Path, words: tuple[str, ...]) -> None:
    assert "only one of -q, -v and --log-json is possible" in refused(2, "run", write_case(tmp_path), *words)
    assert not (tmp_path / "case.h5").exists()


def test_no_colours_in_a_pipe(tmp_path: Path) -> None:
    code, output, messages = finish("run", write_case(tmp_path))
    assert code == 0
    assert "\x1b" not in output + messages
