"""Texts whose numbers may mean something else: warned of, or refused where one reading makes no sense."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fretsolve.problem.surface.files.raw_map import RawMap
from fretsolve.problem.surface.files.text_map import read_text

NOISE = np.random.default_rng(3).normal(size=(6, 8)).round(3)


def read(folder: Path, text: str, *, line: bool = False) -> RawMap:
    (folder / "map.csv").write_text(text, encoding="utf-8")
    return read_text(folder / "map.csv", line=line)


def as_text(rows: np.ndarray, separator: str = ";") -> str:
    return "".join(separator.join(f"{value:g}" for value in row) + "\n" for row in rows)


class TestCommas:
    def test_commas_that_may_part_thousands_warn(self, tmp_path: Path) -> None:
        raw = read(tmp_path, "1,500;1,743;3,391\n2,100;971;1,892\n")
        assert raw.doubts == ("decimal commas: '1,500' is read as 1.500",)

    def test_plain_decimal_commas_do_not(self, tmp_path: Path) -> None:
        assert read(tmp_path, "1,500;0,743;3,391\n2,100;0,971;1,892\n").doubts == ()
        assert read(tmp_path, "1,5;2,25;3,391\n2,100;3,971;1,892\n").doubts == ()

    def test_commas_of_both_kinds_are_refused(self, tmp_path: Path) -> None:
        with pytest.raises(ValueError, match="line 1: commas seem to separate numbers and to stand for decimals"):
            read(tmp_path, "0,000,0,012,0,345\n0,100,0,212,0,045\n")
        assert read(tmp_path, "0,1,20,3\n4,5,6,70\n").values.shape == (4, 2)


class TestLabels:
    def test_labels_of_columns_warn(self, tmp_path: Path) -> None:
        raw = read(tmp_path, as_text(np.vstack([np.arange(8.0), NOISE])))
        assert raw.doubts == ("the first line counts evenly from 1 to 7, as labels do; remove it if it is one",)

    def test_labels_of_lines_warn(self, tmp_path: Path) -> None:
        raw = read(tmp_path, as_text(np.column_stack([10.0 * np.arange(6.0), NOISE])))
        assert raw.doubts == ("the first column counts evenly from 10 to 50, as labels do; remove it if it is one",)

    def test_tilts_and_noise_do_not(self, tmp_path: Path) -> None:
        tilt = np.add.outer(np.arange(6.0), 2.0 * np.arange(8.0))
        assert read(tmp_path, as_text(tilt)).doubts == read(tmp_path, as_text(NOISE)).doubts == ()


class TestPoints:
    @pytest.mark.parametrize("first", [0, 1])
    def test_points_with_a_fourth_column_are_refused(self, tmp_path: Path, first: int) -> None:
        x, y = (part.ravel() for part in np.meshgrid(np.arange(5.0), np.arange(6.0)))
        points, beside = [x, y, np.sin(x * y)], np.cos(3.0 * x + y)
        rows = np.column_stack([*points, beside] if first == 0 else [beside, *points])
        with pytest.raises(ValueError, match=f"columns {first + 1} to {first + 3} of its 4 are points x y z of a grid"):
            read(tmp_path, as_text(rows))

    def test_a_narrow_matrix_is_a_matrix(self, tmp_path: Path) -> None:
        rows = np.random.default_rng(5).normal(size=(40, 4))
        assert read(tmp_path, as_text(rows)).values.shape == (4, 40)

    def test_missing_points_of_an_even_profile_are_holes(self, tmp_path: Path) -> None:
        kept = [place for place in range(60) if place not in (7, 30, 31)]
        raw = read(tmp_path, "".join(f"{0.5 * place:.3f} {place}\n" for place in kept), line=True)
        assert raw.spacing == pytest.approx((0.5,))
        assert np.flatnonzero(np.isnan(raw.values)).tolist() == [7, 30, 31]
        assert "3 of 60 points are missing: holes" in raw.remarks


def test_points_of_a_header_that_are_not_square_warn(tmp_path: Path) -> None:
    header = "# Width: 8 um\n# Height: 12 um\n# Value units: um\n"
    (doubt,) = read(tmp_path, header + as_text(NOISE, "\t")).doubts
    assert doubt == "the points of the header lie 1 apart along x, 2 along y; is the file cut short?"
