from __future__ import annotations

import numpy as np
import pytest

from fretsolve.problem.surface.files.raw_map import RawMap
from fretsolve.problem.surface.files.text_map import read_text

ROWS = "1 2 3 4\n5 6 7 8\n"
KEYENCE = "\r\n".join(
    [
        '"Measured date","2024-03-01 10:20:30"',
        '"Model","VK-X3000 Series"',
        '"Data type\n","ImageDataCsv"',
        '"Measurement data name","a, b.vk6"',
        '"Objective Lens Power","50"',
        '"XY Calibration","277.6","nm"',
        '"Output image data","Height"',
        '"Horizontal","4"',
        '"Vertical","2"',
        '"Minimum value","1.5"',
        '"Unit","um"',
        '"Reference data name",""',
        "",
        '"Height"',
        '"1.5","2.0","3.0","4.0"',
        '"5.0","6.0","","8.0"',
    ]
)
SPIP = "\n".join(
    [
        "# File Format = ASCII",
        "# Created by SPIP",
        "# x-pixels = 4",
        "# y-pixels = 2",
        "# x-length = 2000",
        "# y-length = 1500",
        "# Bit2nm = 0.5",
        "# Start of Data:",
        "1\t2\t3\t4\n5\t6\t7\t8",
    ]
)


@pytest.fixture
def read(tmp_path):
    def read(text: str, *, line: bool = False) -> RawMap:
        (tmp_path / "map.txt").write_text(text, encoding="utf-8", newline="")
        return read_text(tmp_path / "map.txt", line=line)

    return read


def in_um(found: RawMap) -> list[float]:
    """Return the spacing in um."""
    return [1e3 * found.xy_unit * step for step in found.spacing]


class TestFormats:
    @pytest.mark.parametrize(
        "names",
        [
            ("# Channel: Main", "# Width: {} {}", "# Height: {} {}", "# Value units: m"),
            ("# Kanal: Main", "# Breite: {} {}", "# Höhe: {} {}", "# Werteinheiten: m"),
            ("# チャネル： Main", "# 幅: {} {}", "# 高さ： {} {}", "# 値の単位: m"),
        ],
    )
    @pytest.mark.parametrize("micro", ["µm", "μm", "Âµm", "um"])
    def test_gwyddion(self, read, names, micro):
        title, width, height, unit = names
        found = read("\n".join([title, width.format("10.0", micro), height.format("6.0", micro), unit, ROWS]))
        assert in_um(found) == pytest.approx([2.5, 3.0], rel=1e-12)  # over the number of points, not of steps
        assert found.unit == 1e3
        assert found.remarks == ("the file says: heights in units of 1 m, spacing 2.5 um x 3 um",)

    @pytest.mark.parametrize("calibration", ['"XY Calibration","277.6"', '"XY-Justierung","277,6"'])
    def test_keyence(self, read, calibration):
        found = read(KEYENCE.replace('"XY Calibration","277.6"', calibration).replace("1.5", "1.5"))
        assert in_um(found) == pytest.approx([0.2776, 0.2776], rel=1e-12)
        assert found.unit == pytest.approx(1e-3, rel=1e-12)
        assert found.values[:, 1].tolist() == [1.5, 2.0, 3.0, 4.0]
        assert found.remarks[1] == "1 of 8 points are lost: holes"

    def test_spip(self, read):
        found = read(SPIP)
        assert in_um(found) == pytest.approx([0.5, 0.75], rel=1e-12)  # bare lengths of this format are in nm
        assert found.unit == pytest.approx(0.5e-6, rel=1e-12)
        assert read(SPIP.replace("Bit2nm = 0.5", "z-unit = [um]")).unit == pytest.approx(1e-3, rel=1e-12)

    @pytest.mark.parametrize(
        ("header", "spacing"),
        [
            ("dx = 0.5 um\ndy = 0.4 um", [0.5, 0.4]),
            ("dx [um] = 0.5\ndy [um] = 0.4", [0.5, 0.4]),
            ("Pixel size: 0.5 um x 0.4 um", [0.5, 0.4]),
            ("pixel_size\t500\tnm", [0.5, 0.5]),
            ("# SPACING: 0.5 µm/pixel", [0.5, 0.5]),
            ("spacing;0,5;um", [0.5, 0.5]),
            ("spacing,0.5,um", [0.5, 0.5]),
            ("spacing 0.5 um", [0.5, 0.5]),
            ("xy unit: um\nx spacing: 0.5\ny spacing: 0.4", [0.5, 0.4]),
            ("xy unit: um\nWidth: 2\nHeight: 1", [0.5, 0.5]),
        ],
    )
    def test_name_and_value(self, read, header, spacing):
        found = read(f"{header}\nz unit: um\n{ROWS}")
        assert in_um(found) == pytest.approx(spacing, rel=1e-12)
        assert found.unit == pytest.approx(1e-3, rel=1e-12)

    @pytest.mark.parametrize("header", ["Width: 4\nHeight: 2", "dx: 0.5 um", "spacing: unknown", "date: 1.2.2024"])
    def test_what_gives_no_spacing(self, read, header):
        assert read(f"{header}\n{ROWS}").spacing is None

    def test_numbers_without_unit_are_in_that_of_the_case(self, read):
        found = read(f"spacing: 2\n{ROWS}")
        assert (found.spacing, found.xy_unit, found.unit) == ((2.0, 2.0), None, None)

    def test_number_for_lost_points(self, read):
        found = read("ncols 4\nnrows 2\ncellsize 2.0\nNODATA_value -9999\n1 2 3 4\n5 -9999 7 8\n")
        assert found.remarks == ("1 of 8 points are lost: holes",)
        assert np.isnan(found.values[1, 0])
        assert found.spacing == (2.0, 2.0)

    def test_number_for_lost_points_leaves_coordinates(self, read):
        found = read("NODATA_value 0\n0 0 1\n1 0 2\n0 2 0\n1 2 4\n")
        np.testing.assert_array_equal(found.values, [[1.0, np.nan], [2.0, 4.0]])
        found = read("NODATA_value 0\n0 5\n1 0\n2 7\n", line=True)
        np.testing.assert_array_equal(found.values, [5.0, np.nan, 7.0])

    @pytest.mark.parametrize(
        ("line", "unit"),
        [
            ("# units metres", 1e3),
            ("# unit um", 1e-3),
            ("z units Micrometers", 1e-3),
            ("units: Å", 1e-7),
            ("units: angstrom", 1e-7),
            ("units: um (micrometers)", 1e-3),
            ("units: metres", 1e3),
            ("z unit\tÂµm", 1e-3),
        ],
    )
    def test_unit(self, read, line, unit):
        found = read(f"{line}\n{ROWS}")
        assert found.unit == pytest.approx(unit, rel=1e-12)
        assert not any("understood" in remark for remark in found.remarks)

    def test_unit_that_is_no_length(self, read):
        found = read(f"Value units: V\nunit: um\nxy unit: s\nspacing: 2\n{ROWS}")
        assert (found.unit, found.xy_unit, found.stated, found.xy_stated) == (None, None, "V", "s")
        found = read(f"Value units: px\nxy unit: s\nspacing: 2 um\n{ROWS}")
        assert (found.unit, found.stated, found.xy_stated) == (None, "", "")
        assert in_um(found) == pytest.approx([2.0, 2.0], rel=1e-12)

    @pytest.mark.parametrize("line", ["# all values in metres", "units are um or so", "x length in micrometers: 5"])
    def test_line_on_units_that_is_not_understood_is_told(self, read, line):
        found = read(f"title\n{line}\n{ROWS}")
        assert (found.unit, found.xy_unit) == (None, None)
        assert found.remarks == (f"line 2 is not understood: {line!r}",)

    def test_profile(self, read):
        found = read("Height [nm]\nspacing: 1 um\n1\n2\n4\n", line=True)
        assert (in_um(found), found.unit) == (pytest.approx([1.0]), pytest.approx(1e-6))


class TestHeadings:
    @pytest.mark.parametrize(
        "headings",
        [
            "X [mm];Y [mm];Z [µm]",
            "x (mm) y (mm) z (um)",
            "X/mm\tY/mm\tZ/um",
            "# x [mm], y [mm], height [um]",
            "X;Y;Z\nmm;mm;µm",
        ],
    )
    def test_units_of_columns(self, read, headings):
        found = read(f"{headings}\n0 0 1\n1 0 2\n0 2 3\n1 2 4\n")
        assert found.spacing == (1.0, 2.0)
        assert (found.xy_unit, found.unit) == (1.0, pytest.approx(1e-3, rel=1e-12))

    def test_order(self, read):
        with pytest.raises(ValueError, match=r"^its columns are y, x, z; x, y, z in this order are needed$"):
            read("y;x;z\n0;0;1\n1;0;2\n0;2;3\n1;2;4\n")

    def test_lateral_units_of_a_list(self, read):
        found = read("# Lateral units: mm\n# Value units: m\n0 0 1\n1 0 2\n0 2 3\n1 2 4\n")
        assert (found.xy_unit, found.unit) == (1.0, 1e3)

    def test_width_tells_nothing_of_the_unit_of_coordinates(self, read):
        found = read("# Width: 2 um\n0 0 1\n1 0 2\n0 2 3\n1 2 4\n")
        assert (found.spacing, found.xy_unit) == ((1.0, 2.0), None)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (KEYENCE.replace('"4"', '"5"'), "line 9 says that it has 5 columns, it has 4"),
        (SPIP + "\n1\t2\t3\t4", "line 4 says that it has 2 rows, it has 3"),
        (f"unit: um\n\nunit: mm\n{ROWS}", "line 1 gives 'um' as its unit, line 3 'mm'; remove the wrong line"),
        (
            f"# Width: 10 um\nspacing: 3 um\n{ROWS}",
            "line 2 says that the spacing along x is 3 um, line 1 that it is 2.5 um; remove the line that is wrong",
        ),
        (
            "xy unit: mm\nspacing: 3 um\n0 0 1\n1 0 2\n0 2 3\n1 2 4\n",
            "its points say that the spacing along x is 1 mm, line 2 that it is 3 um; remove the line that is wrong",
        ),
    ],
)
def test_contradictions(read, text, message):
    with pytest.raises(ValueError, match=r".") as caught:
        read(text)
    assert str(caught.value) == message
