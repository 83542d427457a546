from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fretsolve.case.keys.map_keys import HeightsSurface
from fretsolve.errors import CaseError, FileError
from fretsolve.problem.surface.files import text_map
from fretsolve.problem.surface.files.raw_map import RawMap
from fretsolve.problem.surface.files.text_map import read_text
from fretsolve.problem.surface.load_map import load_height_map

NAN = np.nan
MATRIX = np.array([[20.0, 10.0, 0.0], [21.0, 11.0, 1.0], [22.0, 12.0, 2.0], [23.0, 13.0, 3.0]])
"""Heights [x, y] of the lines 0 1 2 3, 10 11 12 13, 20 21 22 23, the first of which is the top."""


def read(folder: Path, content: str | bytes, *, line: bool = False) -> RawMap:
    file = folder / "map.txt"
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_text(file, line=line)


def refusal(folder: Path, content: str | bytes, *, line: bool = False) -> str:
    with pytest.raises(ValueError, match=r"^[^\n]+$") as caught:
        read(folder, content, line=line)
    return str(caught.value)


class TestMatrix:
    @pytest.mark.parametrize(
        "text",
        [
            "0 1 2 3\n10 11 12 13\n20 21 22 23\n",
            "  0   1 2.0 3\n\n10 11 12 13 # a remark\n# a line\n20 21 22 23",
            "# scan, 2 um\n\n0, 1, 2, 3\n10, 11, 12, 13\n20, 21, 22, 23",
            "0,1,2,3\n10,11,12,13\n20,21,22,23",
            "\ufeff0;1;2;3\r\n10;11;12;13\r\n20;21;22;23\r\n",
            "0;1;2;3;\n10;11;12;13;\n20;21;22;23;\n",
            "0,1,2,3\n10,11,12,13,\n20,21,22,23,\n",
            "0\t1\t2\t3\t# row along x\n10\t11\t12\t13\n20\t21\t22\t23\n".replace("3\t#", "3 #"),
            '"0.0","1.0","2.0","3.0"\n"10","11","12","13"\n"20","21","22","23"\n',
            "0,0;1,0;2,0;3,0\n10;11;12;13\n2,0e1;21;22;23",
            "0,0\t1,0\t2\t3\n10\t11\t12\t13\n20\t21\t22\t23",
            "0,0 1,0 2 3\n10 11 12 13\n20 21 22 23",
            '"0,0","1,0","2","3"\n"10","11","12","13"\n"20","21","22","23,0"\n',
            "0 1 2 3\r\n10 11 12 13\r\n20 21 22 23\r\n\x1a",
            "Scan of a specimen\nby hand, on Monday\n0 1 2 3\n10 11 12 13\n20 21 22 23\n",
        ],
    )
    def test_lines_run_along_x_from_the_top(self, tmp_path, text):
        np.testing.assert_array_equal(read(tmp_path, text).values, MATRIX)

    @pytest.mark.parametrize(
        ("encoding", "mark"),
        [
            ("utf-8", ""),
            ("utf-8", "\ufeff"),
            ("utf-16-le", "\ufeff"),
            ("utf-16-be", "\ufeff"),
            ("utf-16-le", ""),
            ("utf-16-be", ""),
            ("cp1252", ""),
        ],
    )
    def test_encodings(self, tmp_path, encoding, mark):
        text = f"{mark}# Value units: µm\r\n0 1 2 3\r\n10 11 12 13\r\n20 21 22 23\r\n"
        found = read(tmp_path, text.encode(encoding))
        np.testing.assert_array_equal(found.values, MATRIX)
        assert found.unit == pytest.approx(1e-3, rel=1e-12)

    def test_decimal_commas_are_told(self, tmp_path):
        assert read(tmp_path, "0,5;1;2;3\n1;2;3;4\n").remarks == ("decimal commas",)

    @pytest.mark.parametrize(
        ("text", "rows"),
        [
            ("1;2;;4\n;;;\n5;6;7;\n", [[1, 2, NAN, 4], [NAN] * 4, [5, 6, 7, NAN]]),
            ("1\t\t3\t4\n\t\t\t\n5\t6\t7\t8\n", [[1, NAN, 3, 4], [NAN] * 4, [5, 6, 7, 8]]),
            ("nan NaN Bad BAD\n1 2 3 4\n", [[NAN] * 4, [1, 2, 3, 4]]),
            ("1 *** --- void\n#N/A 2 NA inf\n", [[1, NAN, NAN, NAN], [NAN, 2, NAN, NAN]]),
            ("No Data 1 2 3\n4 5 ****** no data\n", [[NAN, 1, 2, 3], [4, 5, NAN, NAN]]),
            ("Height\n;;;\n1;2;3;4\n", [[NAN] * 4, [1, 2, 3, 4]]),
        ],
    )
    def test_lost_points(self, tmp_path, text, rows):
        found = read(tmp_path, text)
        np.testing.assert_array_equal(found.values, np.array(rows)[::-1].T)
        assert found.remarks == (f"{np.isnan(rows).sum()} of {np.size(rows)} points are lost: holes",)

    def test_of_a_case(self, tmp_path):
        (tmp_path / "map.csv").write_text("0 nan 2 1\n-inf 4 inf 1\n")
        found = load_height_map(HeightsSurface(file=str(tmp_path / "map.csv"), spacing=(2.0, 2.0)), ("heights",))
        np.testing.assert_array_equal(found.values, [[NAN, 0], [4, NAN], [NAN, 2], [1, 1]])

    def test_header_reaches_the_case(self, tmp_path):
        lines = "# Width: 10 µm\n# Height: 6 µm\n# Value units: m\n1e-9 2e-9 3e-9 4e-9\n1e-9 2e-9 3e-9 4e-9\n0 0 0 0\n"
        file = tmp_path / "map.txt"
        file.write_text(lines, encoding="utf-8")
        found = load_height_map(HeightsSurface(file=str(file)), ("heights",))
        assert found.spacing == pytest.approx((0.0025, 0.002), rel=1e-12)
        np.testing.assert_allclose(found.values[:, 1], [1e-6, 2e-6, 3e-6, 4e-6], rtol=1e-12)
        with pytest.raises(CaseError, match=r"its spacing along x is 2.5 um by the file, 5 um by the case"):
            load_height_map(HeightsSurface(file=str(file), spacing="5 um"), ("heights",))


class TestProfile:
    @pytest.mark.parametrize("text", ["1.5\n2\n3\n", "1,5\n2\n3\n", "z [mm]\n1.5\n2\n3\n", "1.5;\n2;\n3;\n"])
    def test_one_column(self, tmp_path, text):
        found = read(tmp_path, text, line=True)
        np.testing.assert_array_equal(found.values, [1.5, 2.0, 3.0])
        assert found.spacing is None

    def test_two_columns(self, tmp_path):
        found = read(tmp_path, "X [mm];Z [µm]\n0;1\n0,5;3\n1;Bad\n", line=True)
        np.testing.assert_array_equal(found.values, [1, 3, NAN])
        assert found.spacing == (0.5,)
        assert (found.unit, found.xy_unit) == (pytest.approx(1e-3), 1.0)
        assert found.remarks[1:] == ("1 of 3 points are lost: holes", "decimal commas")

    def test_commas_part_numbers_where_points_are(self, tmp_path):
        found = read(tmp_path, "0,0\n1,0.5\n2,7\n", line=True)
        np.testing.assert_array_equal(found.values, [0.0, 0.5, 7.0])
        assert found.spacing == (1.0,)

    def test_stylus_profiler(self, tmp_path):
        text = "Scan Parameters\nStylus,Radius: 2.5 µm\nLength,1500.0 um\nScan Data\nLateral um,Raw Micrometer,\n"
        found = read(tmp_path, text + "0.0,-0.25,,\n0.5,-0.5,,\n1.0,0.75,,\n", line=True)
        np.testing.assert_array_equal(found.values, [-0.25, -0.5, 0.75])
        assert (found.spacing, found.unit, found.xy_unit) == ((0.5,), pytest.approx(1e-3), pytest.approx(1e-3))

    def test_needs_a_line_contact(self, tmp_path):
        assert refusal(tmp_path, "1 2\n3 4\n") == (
            "its 2 columns are x and z of a profile, for plane: strain; a map has more columns, or x y z"
        )


class TestStart:
    """Where the points of a list begin is told, since `crop` counts from there."""

    @pytest.mark.parametrize(
        ("header", "start"), [("x [mm] y [mm] z [um]", "x = 1 mm, y = -4 mm"), ("", "x = 1, y = -4")]
    )
    def test_of_a_map(self, tmp_path, header, start):
        found = read(tmp_path, f"{header}\n1 -4 1\n2 -4 2\n1 -2 3\n2 -2 4\n")
        assert found.remarks[-1] == f"its points begin at {start}, from which crop counts"

    def test_of_a_profile(self, tmp_path):
        assert read(tmp_path, "3 1\n4 2\n5 3\n", line=True).remarks == (
            "its points begin at x = 3, from which crop counts",
        )

    def test_at_zero(self, tmp_path):
        assert read(tmp_path, "0 0 1\n1 0 2\n0 2 3\n1 2 4\n").remarks == ()
        assert read(tmp_path, "0 1\n1 2\n2 3\n", line=True).remarks == ()


class TestFaults:
    @pytest.mark.parametrize(
        ("text", "message"),
        [
            ("", "it holds no numbers"),
            ("# only a comment\n", "it holds no numbers"),
            (b"\x00\x01\x02\x03ab\x00\x00", "it is not text"),
            (b"\xff\xfe1\x00\n", "it is cut short, or no utf-16 text"),
            (
                "height\n\n1 2 3 4\n1 2 x7 4\n",
                "line 4 holds 'x7', which is no number; a lost point is empty or nan, Bad",
            ),
            ("1 2 3O 4\n1 2 3 4\n1 2 3 4\n", "line 1 holds '3O', which is no number"),
            ("1 2 3 4\n1 2 1_0 4\n", "line 2 holds '1_0', which is no number"),
            ("# c\n1 2 3 4\n\n1 2 3\n", "line 4 has 3 columns, the lines above have 4; all need as many"),
            ("1 2 3 4\n1 2 1e400 4\n", "line 2 holds a number of no possible height"),
            ("4 2\n1 2 3 4\n1 2 3 4\n", "line 2 has 4 columns, the lines above have 2"),
            (
                "1;2;3;4\n1,5;2;3;4\n1.5;2;3;4\n",
                "line 3: it has decimal commas as well as points; write one of the two",
            ),
            ("1,5\n2,5\n", "'1,5' in line 1 may be one number or two; write decimal points, or separate numbers by"),
        ],
    )
    @pytest.mark.parametrize("line", [False, True])
    def test_are_told_with_their_line(self, tmp_path, text, message, line):
        assert refusal(tmp_path, text, line=line).startswith(message)

    def test_of_lists_are_told_with_their_line(self, tmp_path):
        points = "# x y z\n\n0 0 1\n1 0 2\n\n0 1 3\n1 1 4\n"
        assert refusal(tmp_path, points + "1 0 5\n").endswith(": lines 4 and 8 give one place, x = 1, y = 0")
        assert refusal(tmp_path, points + "nan 0 5\n") == "line 8 has a height, but its x or y is lost"
        assert refusal(tmp_path, "x z\n0 1\n\n2 1\n2 3\n", line=True).startswith("lines 4 and 5 have the same x, 2;")

    def test_no_header_is_endless(self, tmp_path):
        assert refusal(tmp_path, "words\n" * 1001) == "its first 1000 lines hold no numbers"

    def test_limits(self, tmp_path, monkeypatch):
        monkeypatch.setattr(text_map, "MOST_HEIGHTS", 12)
        assert read(tmp_path, "# a comment\n" + "1 2 3 4\n" * 3).values.shape == (4, 3)
        assert refusal(tmp_path, "1 2 3 4\n" * 4) == "it has more than 12 heights; give a part of it"
        monkeypatch.setattr(text_map, "LONGEST_LINE", 100)
        assert refusal(tmp_path, "1 2\n" + "1 " * 60) == "a line of it has more than 100 characters"

    def test_words_are_not_quoted_at_length(self, tmp_path):
        assert len(refusal(tmp_path, "1 2 3 4\n1 2 3 " + "secret" * 1000)) < 300

    def test_of_a_case(self, tmp_path):
        file = tmp_path / "map.txt"
        file.write_text("1 2 3 4\n1 2\n")
        with pytest.raises(FileError, match="the height map cannot be read: line 2 has 2 columns") as caught:
            load_height_map(HeightsSurface(file=str(file)), ("heights",))
        assert caught.value.file == file
