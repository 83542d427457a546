"""Heights in files of instruments, which SurfaceTopography reads and gwyfile, scipy or the library itself write."""

from __future__ import annotations

import struct
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fretsolve.case.keys.map_keys import HeightsSurface
from fretsolve.errors import CaseError, FileError
from fretsolve.problem.surface.files.instrument_map import read_instrument
from fretsolve.problem.surface.height_map import HeightMap
from fretsolve.problem.surface.load_map import load_height_map

KEY = ("surface", 0, "heights")
IMAGE = np.array([[0.0, 1.0, 2.0, 3.0], [10.0, 11.0, 12.0, 13.0], [20.0, 21.0, 22.0, 24.0]])
"""Heights in um, rows as in a picture: the first is the top."""

MAP = np.array([[20.0, 10.0, 0.0], [21.0, 11.0, 1.0], [22.0, 12.0, 2.0], [24.0, 13.0, 3.0]])
"""The same, [x, y] with y upwards."""

ASCII_SDF = """aISO-1.0
ManufacID   = made
CreateDate  = 010120260000
ModDate     = 010120260000
NumPoints   = 4
NumProfiles = 3
Xscale      = 1.0E-5
Yscale      = 2.0E-5
Zscale      = 1.0E-6
Zresolution = -1
Compression = 0
DataType    = 7
CheckType   = 0
*
20 21 22 24 10 11 12 13 0 1 2 3
*
"""
"""Its first profile is at y = 0, the bottom (ISO 25178-71)."""


@pytest.fixture(scope="module")
def library() -> Any:
    """SurfaceTopography (extra ``test-surfaces``)."""
    return pytest.importorskip("SurfaceTopography", exc_type=ImportError)


def gwy(file: Path, channels: dict[str, tuple[str, Any]], mask: Any = None) -> Path:
    """Write channels with the unit and data of each, 40 um x 60 um wide, by gwyfile."""
    writer = pytest.importorskip("gwyfile.objects")
    container = writer.GwyContainer()
    for number, (title, (unit, data)) in enumerate(channels.items()):
        sizes = {"xreal": 40e-6, "yreal": 60e-6, "si_unit_xy": writer.GwySIUnit(unitstr="m")}
        field = writer.GwyDataField(np.array(data), si_unit_z=writer.GwySIUnit(unitstr=unit), **sizes)
        container[f"/{number}/data/title"], container[f"/{number}/data"] = title, field
        if mask is not None:
            container[f"/{number}/mask"] = writer.GwyDataField(np.array(mask, dtype=float), **sizes)
    container.tofile(str(file))
    return file


def al3d(file: Path) -> Path:
    """Write IMAGE, row by row from the top; rows fill whole multiples of 8 bytes."""
    tags = {"Version": "1", "TagCount": "6", "Cols": "4", "Rows": "3", "DepthImageOffset": "688"}
    tags |= {"PixelSizeXMeter": "1e-5", "PixelSizeYMeter": "2e-5", "InvalidPixelValue": "NaN"}
    head = b"AliconaImaging\0\r\n" + b"".join(
        key.encode().ljust(20, b"\0") + value.encode().ljust(30, b"\0") + b"\r\n" for key, value in tags.items()
    )
    file.write_bytes(head.ljust(686, b"\0") + b"\r\n" + (1e-6 * IMAGE).astype("<f4").tobytes())
    return file


def sur(file: Path) -> Path:
    """Write IMAGE, row by row from the top, as 16-bit numbers of 0.5 um."""
    names = ["X", "Y", "Z", "mm", "mm", "um", "mm", "mm", "um"]
    head = struct.pack(
        "<12s4H60x5H8xH4iI3f", b"DIGITAL SURF", 0, 1, 2, 2, 0, 0, 0, 0, 0, 16, 0, 48, 4, 3, 12, 0.01, 0.02, 0.5
    )
    head += b"".join(name.encode().ljust(16) for name in names) + struct.pack("<3f", 1, 1, 1)
    file.write_bytes(head.ljust(512, b"\0") + (2 * IMAGE).astype("<i2").tobytes())
    return file


def x3p(file: Path) -> Path:
    """Write IMAGE, row by row."""
    axes = "".join(
        f"<{name}><AxisType>{kind}</AxisType><DataType>D</DataType><Increment>{step}</Increment></{name}>"
        for name, kind, step in (("CX", "I", "1e-5"), ("CY", "I", "2e-5"), ("CZ", "A", "1"))
    )
    record = f"<Revision>ISO5436 - 2000</Revision><FeatureType>SUR</FeatureType><Axes>{axes}</Axes>"
    size = "<SizeX>4</SizeX><SizeY>3</SizeY><SizeZ>1</SizeZ>"
    link = "<DataLink><PointDataLink>bindata/data.bin</PointDataLink></DataLink>"
    last = f"<Record3><MatrixDimension>{size}</MatrixDimension>{link}</Record3>"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("main.xml", f"<ISO5436_2><Record1>{record}</Record1>{last}</ISO5436_2>")
        archive.writestr("bindata/data.bin", (1e-6 * IMAGE).tobytes())
    return file


def load(file: Path, **keys: Any) -> HeightMap:
    return load_height_map(HeightsSurface(file=str(file), **keys), KEY)


@pytest.mark.usefixtures("library")
class TestFormats:
    def test_gwyddion(self, tmp_path):
        read = load(gwy(tmp_path / "map.gwy", {"Height": ("m", 1e-6 * IMAGE)}))
        np.testing.assert_allclose(read.values, 1e-3 * MAP, rtol=1e-14)
        assert read.spacing == pytest.approx((0.01, 0.02), rel=1e-14)
        assert read.remarks == ()

    def test_mask_of_gwyddion_marks_lost_points(self, tmp_path):
        read = load(gwy(tmp_path / "map.gwy", {"Height": ("m", 1e-6 * IMAGE)}, mask=IMAGE == 3.0))
        np.testing.assert_allclose(read.values, np.where(MAP == 3.0, np.nan, 1e-3 * MAP), rtol=1e-14)
        assert read.remarks == ("1 of its points are masked: they count as lost",)

    def test_first_channel_of_heights_or_the_one_asked_for(self, tmp_path):
        channels = {"Phase": ("deg", IMAGE), "Height": ("m", 1e-6 * IMAGE), "Back": ("m", 5e-7 * IMAGE)}
        file = gwy(tmp_path / "map.gwy", channels)
        read = load(file)
        np.testing.assert_allclose(read.values, 1e-3 * MAP, rtol=1e-14)
        assert read.remarks == ("channel 'Height' is read, the first of 'Height', 'Back'",)
        np.testing.assert_allclose(load(file, dataset="Back").values, 5e-4 * MAP, rtol=1e-14)

    def test_sdf(self, tmp_path):
        (tmp_path / "map.SDF").write_text(ASCII_SDF)
        read = load(tmp_path / "map.SDF")
        np.testing.assert_allclose(read.values, 1e-3 * MAP, rtol=1e-14)
        assert read.spacing == pytest.approx((0.01, 0.02), rel=1e-14)

    @pytest.mark.parametrize("write", [al3d, sur, x3p])
    def test_first_row_is_the_top(self, tmp_path, write):
        read = load(write(tmp_path / f"map.{write.__name__}"))
        np.testing.assert_allclose(read.values, 1e-3 * MAP, rtol=1e-6)
        assert read.spacing == pytest.approx((0.01, 0.02), rel=1e-6)
        untried = "which row of this format is the top was not tried: compare the sides with the instrument's picture"
        assert read.remarks == ((untried,) if write is x3p else ())

    @pytest.mark.parametrize("void", ["-1.7976931348623157e308", "1e300", "nan", "BAD"])
    def test_lost_points_of_sdf(self, tmp_path, void):
        (tmp_path / "map.sdf").write_text(ASCII_SDF.replace("22 24", f"22 {void}"))
        lost = load(tmp_path / "map.sdf").values
        np.testing.assert_allclose(lost, np.where(MAP == 24.0, np.nan, 1e-3 * MAP), rtol=1e-14)

    @pytest.mark.parametrize("periodic", [False, True])
    def test_netcdf3_of_the_library(self, tmp_path, periodic):
        from SurfaceTopography import Topography

        surface = Topography(MAP, (40.0, 60.0), unit="µm", periodic=periodic)  # [x, y], y upwards
        surface.to_netcdf(str(tmp_path / "map.nc"))
        read = load(tmp_path / "map.nc")
        np.testing.assert_allclose(read.values, 1e-3 * MAP, rtol=1e-14)
        assert read.spacing == pytest.approx((0.01, 0.02), rel=1e-14)

    def test_unit_that_is_no_length(self, tmp_path):
        from SurfaceTopography import Topography

        Topography(MAP, (40.0, 60.0), unit="V").to_netcdf(str(tmp_path / "map.nc"))
        with pytest.raises(CaseError, match=r"the file states its heights in 'V', which is no length; give unit$"):
            load(tmp_path / "map.nc")

    def test_netcdf3_without_size_and_unit(self, tmp_path):
        from scipy.io import netcdf_file

        with netcdf_file(tmp_path / "map.nc", "w") as stored:
            for name, points in (("x", 4), ("y", 3)):
                stored.createDimension(name, points)
            stored.createVariable("heights", "f8", ("x", "y"))[:] = MAP
        raw = read_instrument(tmp_path / "map.nc", None, KEY)
        assert (raw.spacing, raw.unit, raw.xy_unit, raw.remarks) == (None, None, None, ("it states no unit",))
        np.testing.assert_array_equal(load(tmp_path / "map.nc", unit="um", spacing="10 um").values, 1e-3 * MAP)

    def test_profile(self, tmp_path):
        from SurfaceTopography import UniformLineScan

        UniformLineScan(np.array([0.0, 1.0, 4.0, 9.0]), 40.0, unit="nm").to_netcdf(str(tmp_path / "map.nc"))
        raw = read_instrument(tmp_path / "map.nc", None, KEY)
        np.testing.assert_array_equal(raw.values, [0.0, 1.0, 4.0, 9.0])
        assert raw.spacing == (10.0,)
        assert (raw.unit, raw.xy_unit) == (pytest.approx(1e-6), pytest.approx(1e-6))


@pytest.mark.usefixtures("library")
class TestFaults:
    def test_unknown_ending_lists_the_known_ones(self, tmp_path):
        (tmp_path / "map.png").write_bytes(b"x")
        with pytest.raises(CaseError) as caught:
            load(tmp_path / "map.png")
        assert caught.value.key == (*KEY, "file")
        own = ".txt, .csv, .dat, .asc, .xyz, .npy, .npz, .h5, .hdf5, .hdf"
        assert caught.value.message.startswith(f"'map.png' has an unknown ending; {own} are read, and .001, ")
        assert all(f" .{end}," in caught.value.message for end in ("al3d", "gwy", "sdf", "sur", "vk4"))

    def test_unknown_channel(self, tmp_path):
        file = gwy(tmp_path / "map.gwy", {"Height": ("m", IMAGE), "Phase": ("deg", IMAGE)})
        with pytest.raises(CaseError) as caught:
            load(file, dataset="Phase")
        assert caught.value.key == (*KEY, "dataset")
        assert caught.value.message == "there is no channel 'Phase' in 'map.gwy', which has 'Height'"

    def test_no_channel_of_heights(self, tmp_path):
        with pytest.raises(FileError, match=r"cannot be read: it holds no heights$"):
            load(gwy(tmp_path / "map.gwy", {"Phase": ("deg", IMAGE)}))

    def test_uneven_profile(self, tmp_path):
        from SurfaceTopography import NonuniformLineScan

        NonuniformLineScan(np.array([0.0, 1.0, 3.0]), np.zeros(3), unit="um").to_netcdf(str(tmp_path / "map.nc"))
        with pytest.raises(FileError, match="the points of its profile are unevenly spaced; give them as text"):
            load(tmp_path / "map.nc")

    @pytest.mark.parametrize("suffix", ["al3d", "sur", "sdf", "x3p", "gwy", "opd", "plu", "nc", "nms", "vk4", "datx"])
    @pytest.mark.parametrize("content", [b"", b"no heights at all", bytes(4000)])
    def test_file_of_another_kind(self, tmp_path, suffix, content):
        file = tmp_path / f"map.{suffix}"
        file.write_bytes(content)
        with pytest.raises(FileError, match=r"the height map cannot be read: .") as caught:
            load(file)
        assert "\n" not in str(caught.value)

    @pytest.mark.parametrize("kept", [3, 40, 150, -1])
    def test_file_that_is_cut_short(self, tmp_path, kept):
        file = gwy(tmp_path / "map.gwy", {"Height": ("m", IMAGE)})
        file.write_bytes(file.read_bytes()[:kept])
        with pytest.raises(FileError, match=r"the height map cannot be read: .") as caught:
            load(file)
        assert "\n" not in str(caught.value)


def test_missing_library_is_told_with_the_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "SurfaceTopography.IO", None)
    monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
    (tmp_path / "map.al3d").write_bytes(b"x")
    with pytest.raises(CaseError) as caught:
        load(tmp_path / "map.al3d")
    assert caught.value.key == (*KEY, "file")
    assert "\n" not in str(caught.value)
    assert caught.value.message.startswith("'map.al3d' does not end in .txt, ")
    assert caught.value.message.endswith(": pip install '.[surfaces]' in a clone of fretsolve")


def test_other_files_do_not_load_the_library(tmp_path):
    np.save(tmp_path / "map.npy", 1e-3 * MAP)
    program = (
        "import sys\n"
        "from fretsolve.case.keys.map_keys import HeightsSurface\n"
        "from fretsolve.problem.surface.load_map import load_height_map\n"
        "load_height_map(HeightsSurface(file=sys.argv[1], spacing=1), ())\n"
        "print([name for name in sys.modules if name.startswith(('SurfaceTopography', 'matplotlib', 'pandas'))])\n"
    )
    line = [sys.executable, "-c", program, str(tmp_path / "map.npy")]
    assert subprocess.run(line, capture_output=True, text=True, check=True).stdout == "[]\n"


def test_library_warns_of_nothing(tmp_path, library):
    file = gwy(tmp_path / "map.gwy", {"Height": ("m", 1e-6 * IMAGE)})
    program = (
        "import sys\n"
        "from pathlib import Path\n"
        "from fretsolve.problem.surface.files.instrument_map import read_instrument\n"
        "print(read_instrument(Path(sys.argv[1]), None, ()).values.shape)\n"
    )
    line = [sys.executable, "-W", "error", "-c", program, str(file)]
    done = subprocess.run(line, capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("(4, 3)\n", "")
