"""Columns of the history that not every result has: bulk stresses, numbers of spots, and what belongs to a rig."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from fake_states import fake_header, fake_states, write_fake

from fretsolve.case.history import BULK, OF_RIG
from fretsolve.result import HistoryWriter, RunHeader, open_result
from fretsolve.result.layout import RIG_ERRORS
from fretsolve.result.state import State

NAMES = (*BULK[1], *BULK[2])


def header_with_bulk(errors: bool = False) -> RunHeader:
    header = fake_header(errors=errors)
    case = json.loads(header.effective_case)
    case["load_path"] += [{"cycle": {"times": 2, "stages": [{"Qx": 1.0}, {"bulk_2": {"xx": 70.0}}]}}]
    return replace(header, effective_case=json.dumps(case))


def states(count: int, errors: bool, after: State | None = None) -> list[State]:
    found = fake_states(count, after, errors=errors)
    return [
        replace(one, summary=replace(one.summary, bulk_2_xx=0.1 * one.summary.step, bulk_1_xy=-1.5)) for one in found
    ]


@pytest.mark.parametrize("errors", [False, True])
def test_bulk_stresses_are_written_and_resumed_with_them(tmp_path: Path, errors: bool) -> None:
    whole, resumed, header = tmp_path / "whole.h5", tmp_path / "resumed.h5", header_with_bulk(errors)
    for out, stops in ((whole, [6]), (resumed, [2, 3, 6])):
        for stop in stops:
            with HistoryWriter.open(out, header, resume=True) as writer:
                for state in states(6, errors)[len(writer.summaries) : stop]:
                    writer.append(state)
                if stop == 6:
                    writer.finish("complete")
            with open_result(out) as result:
                assert result.history["bulk_2_xx"].tolist() == [0.1 * step for step in range(stop)]
                assert set(result.history["bulk_1_xy"]) == {-1.5}
                assert result.units("bulk_2_xx") == "MPa"
    assert whole.read_bytes() == resumed.read_bytes()
    with HistoryWriter.open(whole, header, resume=True) as writer:
        assert [summary.bulk_2_xx for summary in writer.summaries] == [0.1 * step for step in range(6)]


def test_other_results_have_no_bulk_stresses(tmp_path: Path) -> None:
    with open_result(write_fake(tmp_path / "out.h5")) as result:
        assert not set(NAMES) & set(result.history)
    with h5py.File(tmp_path / "out.h5") as file:
        assert not set(NAMES) & set(file["history"])


def header_with_spots() -> RunHeader:
    header = fake_header()
    case = json.loads(header.effective_case)
    case["surface"] = [{"sphere": {"radius": 10.0}}, {"cone": {"angle": 0.1}}]
    return replace(header, effective_case=json.dumps(case))


def test_numbers_of_spots_are_written_and_resumed_with_them(tmp_path: Path) -> None:
    out, header = tmp_path / "out.h5", header_with_spots()
    counted = [replace(one, summary=replace(one.summary, spots=3, small_spots=1)) for one in fake_states(4)]
    for stop in (2, 4):
        with HistoryWriter.open(out, header, resume=True) as writer:
            for state in counted[len(writer.summaries) : stop]:
                writer.append(state)
    with open_result(out) as result:
        assert result.history["spots"].tolist() == [3] * 4
        assert result.history["small_spots"].tolist() == [1] * 4
        assert result.history["spots"].dtype == np.int64


def test_a_beginning_with_other_columns_is_not_taken(tmp_path: Path) -> None:
    shared = {1: tmp_path / "shared" / "beginning.h5"}
    with HistoryWriter.open(tmp_path / "other.h5", fake_header(), shared=shared) as writer:
        for state in fake_states(2):
            writer.append(state)
    assert shared[1].exists()
    with HistoryWriter.open(tmp_path / "out.h5", header_with_bulk(), shared=shared) as writer:
        assert (writer.last_state, writer.summaries) == (None, [])


def header_with_rig(errors: bool, **more: object) -> RunHeader:
    header = fake_header(errors=errors)
    case = json.loads(header.effective_case) | {"rig": {"stiffness_x": 50e3}} | more
    return replace(header, effective_case=json.dumps(case))


def states_with_rig(errors: bool) -> list[State]:
    found = []
    for one in fake_states(6, errors=errors):
        of_rig = {name: 0.5 * one.summary.step + place for place, name in enumerate(OF_RIG)}
        bars = {column.name: 0.25 * one.summary.step + place for place, column in enumerate(RIG_ERRORS)}
        with_bars = one.errors if one.errors is None else replace(one.errors, **bars)
        found.append(replace(one, summary=replace(one.summary, **of_rig), errors=with_bars))
    return found


@pytest.mark.parametrize("errors", [False, True])
def test_what_belongs_to_a_rig_is_written_and_resumed_with_it(tmp_path: Path, errors: bool) -> None:
    whole, resumed, header = tmp_path / "whole.h5", tmp_path / "resumed.h5", header_with_rig(errors)
    for out, stops in ((whole, [6]), (resumed, [2, 6])):
        for stop in stops:
            with HistoryWriter.open(out, header, resume=True) as writer:
                for state in states_with_rig(errors)[len(writer.summaries) : stop]:
                    writer.append(state)
                if stop == 6:
                    writer.finish("complete")
    assert whole.read_bytes() == resumed.read_bytes()
    with open_result(whole) as result:
        assert result.history["spring_energy"].tolist() == [6.0 + 0.5 * step for step in range(6)]
        assert [result.units(name) for name in ("actuator_x", "actuator_phi_z", "spring_energy")] == ["mm", "rad", "mJ"]
        names = {column.name for column in RIG_ERRORS}
        assert names & set(result.history) == (names if errors else set())
        if errors:
            assert result.history["actuator_z_error"].tolist() == [0.25 * step for step in range(6)]
            assert result.units("spring_energy_corrected_error") == "mJ"
    with HistoryWriter.open(whole, header, resume=True) as writer:
        assert [summary.actuator_z for summary in writer.summaries] == [0.5 * step for step in range(6)]


@pytest.mark.parametrize("errors", [False, True])
def test_other_results_have_nothing_of_a_rig(tmp_path: Path, errors: bool) -> None:
    with open_result(write_fake(tmp_path / "out.h5", errors=errors)) as result:
        assert not [name for name in result.history if name.startswith(("actuator", "spring"))]
        assert ("Qx_error" in result.history) is errors


def test_energy_of_the_springs_of_a_line_contact_is_per_length(tmp_path: Path) -> None:
    with HistoryWriter.open(tmp_path / "out.h5", header_with_rig(False, plane="strain")) as writer:
        writer.append(states_with_rig(False)[0])
    with open_result(tmp_path / "out.h5") as result:
        assert (result.units("spring_energy"), result.units("actuator_x")) == ("mJ/mm", "mm")
