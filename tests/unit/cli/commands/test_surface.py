"""``fretsolve surface``, ``validate`` and ``plot surface``: what they say of measured maps, and what they warn of."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from command_line import invoke, python, refused
from small_cases import CASE, write_case

from fretsolve import open_result

SPACING = 5e-3  # mm
PLACES = (np.arange(64) - 31.5) * SPACING


def text_map(folder: Path, heights: np.ndarray, header: str = "", name: str = "scan.txt") -> Path:
    """A map [x, y] as instruments write it: lines along x, the one with the largest y first."""
    path = folder / name
    with path.open("w", encoding="utf-8") as file:
        file.write(header)
        np.savetxt(file, heights.T[::-1], fmt="%.8g")
    return path


def tilted_ball(radius: float = 10.0, slope: float = 0.002) -> np.ndarray:
    """The separation (mm) of a ball that is tilted along x."""
    x, y = PLACES[:, None], PLACES[None, :]
    return (x**2 + y**2) / (2.0 * radius) + slope * x + 0.0 * y


def heights_case(folder: Path, keys: str, grid: str = "{points: 32, size: 0.25 mm}") -> Path:
    text = CASE[: CASE.index("expect")].replace("{sphere: {radius: 10 mm}}", f"{{heights: {{{keys}}}}}")
    text = text.replace("400 N", "20 N").replace("20 N, increments: 4", "1 N, increments: 4")
    return write_case(folder, text.replace("grid: {points: 16}", f"grid: {grid}"))


class TestSurface:
    def test_size_form_and_sides_are_said(self, tmp_path: Path) -> None:
        span = 64 * SPACING * 1e3
        header = f"# Width: {span} µm\n# Height: {span} µm\n# Value units: mm\n"
        done = invoke("surface", text_map(tmp_path, tilted_ball(), header), "--set", "level=plane")
        assert done.exit_code == 0
        assert "64 x 64 points, spacing 5 um x 5 um, span 0.315 mm x 0.315 mm" in done.stdout
        assert "level: plane taken off, tilts 0.002" in done.stdout
        assert "radius of the best sphere 10 mm" in done.stdout

    def test_sides_are_those_of_the_file_as_it_is_looked_at(self, tmp_path: Path) -> None:
        bump = np.zeros((64, 64))
        bump[:32, 32:] = 0.001  # left, top
        done = invoke("surface", text_map(tmp_path, bump), "--set", "unit=mm", "--set", "spacing=5 um")
        assert (
            "left, x < 0: 0.25 um; right, x > 0: -0.25 um; bottom, y < 0: -0.25 um; top, y > 0: 0.25 um" in done.stdout
        )
        turned = invoke("surface", tmp_path / "scan.txt", "--set", "spacing=5 um", "--set", "flip=y")
        assert "bottom, y < 0: 0.25 um; top, y > 0: -0.25 um" in turned.stdout

    def test_few_points_per_wave_warn(self, tmp_path: Path) -> None:
        wave = 1e-5 * np.cos(2.0 * np.pi * PLACES / 0.02)[:, None] * np.ones(64)
        done = invoke("surface", text_map(tmp_path, wave), "--set", "spacing=5 um")
        assert "the shortest wave of the map, 19 um, has 3.8 points; ten are needed" in done.stderr

    def test_profile(self, tmp_path: Path) -> None:
        (tmp_path / "p.txt").write_text("".join(f"{x:.6f} {x**2 / 20:.9f}\n" for x in PLACES))
        done = invoke("surface", tmp_path / "p.txt", "--profile", "--set", "unit=mm")
        assert "64 points, spacing 5 um, span 0.315 mm" in done.stdout
        assert "radius of the best sphere 10 mm" in done.stdout
        assert "plane: strain" in refused(4, "surface", tmp_path / "p.txt")

    def test_a_picture_is_drawn(self, tmp_path: Path) -> None:
        path, picture = text_map(tmp_path, tilted_ball()), tmp_path / "scan.png"
        done = invoke("surface", path, "--set", "spacing=5 um", "--plot", picture)
        assert done.exit_code == 0
        assert picture.read_bytes().startswith(b"\x89PNG")

    @pytest.mark.parametrize(
        ("options", "told"),
        [
            (("--set", "level=planar"), "level: 'planar'"),
            (("--set", "spacing=5 N"), "spacing"),
            (("--set", "colour=red"), "unknown key 'colour'"),
            ((), "spacing is missing, and 'scan.txt' has none"),
        ],
    )
    def test_mistakes_are_told_in_one_line(self, tmp_path: Path, options: tuple[str, ...], told: str) -> None:
        assert told in refused(2, "surface", text_map(tmp_path, tilted_ball()), *options)

    def test_metres_without_a_word_are_refused_by_their_range(self, tmp_path: Path) -> None:
        keys = "--set", "spacing=5 um", "--set", "unit=m"
        told = refused(2, "surface", text_map(tmp_path, tilted_ball()), *keys)
        assert "range over" in told and "on a map of 0.315 mm" in told


class TestCases:
    def test_validate_holds_the_shortest_wave_against_the_cell(self, tmp_path: Path) -> None:
        wave = tilted_ball(slope=0.0) + 1e-5 * np.cos(2.0 * np.pi * PLACES / 0.06)[:, None]
        text_map(tmp_path, wave)
        done = invoke("validate", heights_case(tmp_path, "file: scan.txt, spacing: 5 um"))
        assert done.exit_code == 0
        assert "# scan.txt, in mm, x to the right and y up" in done.stdout
        assert "cells of the grid" in done.stdout

    def test_contact_lies_where_the_picture_has_it(self, tmp_path: Path) -> None:
        x, y = PLACES[:, None], PLACES[None, :]
        text_map(tmp_path, ((x + 0.08) ** 2 + (y - 0.04) ** 2) / 20.0)  # left of the middle, above it
        case = heights_case(tmp_path, "file: scan.txt, spacing: 5 um", "{points: 32, size: 0.3 mm}")
        assert invoke("run", case, "--set", "load_path=[{P: 0.5 N}]").exit_code == 0
        with open_result(case.with_suffix(".h5")) as result:
            pressure = result.field("pressure", 0)
            middle = [result.x @ pressure.sum(axis=1), result.y @ pressure.sum(axis=0)] / pressure.sum()
        assert middle == pytest.approx([-0.08, 0.04], abs=0.01)

    def test_contact_beside_a_hole_warns(self, tmp_path: Path) -> None:
        heights = tilted_ball(slope=0.0)
        heights[34:36, 30:32] = np.nan
        text_map(tmp_path, heights)
        case = heights_case(tmp_path, "file: scan.txt, spacing: 5 um")
        done = invoke("run", case)
        assert done.exit_code == 0
        assert "in contact lie beside holes of the map, where the pressure is infinite" in done.stderr
        filled = invoke("run", case, "--set", "surface.heights.fill=1 %", "--overwrite")
        assert filled.exit_code == 0
        assert "holes of the map" not in filled.stderr

    def test_points_farther_apart_than_the_grid_is_long_are_refused(self, tmp_path: Path) -> None:
        text_map(tmp_path, tilted_ball())
        told = refused(2, "run", heights_case(tmp_path, "file: scan.txt, spacing: 0.9 mm"))
        assert "the points of the map are 0.9 mm apart along x" in told and "is the spacing right?" in told

    @pytest.mark.slow
    def test_picture_of_the_surface_of_a_result(self, tmp_path: Path) -> None:
        text_map(tmp_path, tilted_ball(slope=0.0))
        case = heights_case(tmp_path, "file: scan.txt, spacing: 5 um")
        assert invoke("run", case).exit_code == 0
        assert invoke("plot", case.with_suffix(".h5"), "surface").exit_code == 0
        assert (tmp_path / "case.surface.png").exists()
        rough = case.read_text().replace(
            "{file: scan.txt, spacing: 5 um}}",
            "{file: scan.txt, spacing: 5 um}}, {roughness: {hurst: 0.8, rms_height: 10 nm, cutoff: 40 um, seed: 2}}]",
        )
        both = write_case(tmp_path, rough.replace("surface: {heights", "surface: [{heights"), "both.yaml")
        assert invoke("run", both).exit_code == 0
        assert invoke("plot", both.with_suffix(".h5"), "surface").exit_code == 0
        plain = write_case(tmp_path, CASE, "plain.yaml")
        assert invoke("run", plain).exit_code == 0
        assert "has neither heights nor roughness" in refused(2, "plot", plain.with_suffix(".h5"), "surface")

    def test_a_map_without_a_point_in_the_contact_is_refused(self, tmp_path: Path) -> None:
        heights = np.zeros((4, 4))  # its points lie at 0.15 and 0.45 mm, the contact is 0.04 mm wide
        text_map(tmp_path, heights, name="coarse.txt")
        case = heights_case(tmp_path, "file: coarse.txt, spacing: 0.3 mm", "{points: 32, size: 0.4 mm}")
        text = case.read_text().replace("surface: {heights", "surface: [{sphere: {radius: 10 mm}}, {heights")
        case.write_text(text.replace("0.3 mm}}", "0.3 mm}}]"))
        done = invoke("run", case, "-q", "--set", "load_path=[{P: 1 N}]")
        assert done.exit_code == 3
        told = done.stderr
        assert "no point of the height map lies in the contact" in told and "0.3 mm x 0.3 mm apart" in told

    def test_holes_are_told_from_ends_and_from_what_is_not_stored(self, tmp_path: Path) -> None:
        flat = np.zeros((64, 64))
        text_map(tmp_path, flat)
        case = heights_case(tmp_path, "file: scan.txt, spacing: 5 um")
        whole = case.read_text().replace("surface: {heights", "surface: [{punch: {radius: 0.1 mm}}, {heights")
        case.write_text(whole.replace("5 um}}", "5 um}}]"))
        done = invoke("run", case)
        assert done.exit_code == 0 and "holes of the map" not in done.stderr  # the punch ends, the map does not
        flat[34:36, 30:32] = np.nan
        text_map(tmp_path, flat)
        unloaded = "load_path=[{P: 20 N}, {P: 0 N}]"
        done = invoke("run", case, "--overwrite", "--set", unloaded)
        assert "in contact lie beside holes of the map" in done.stderr  # of the largest contact, not of the last one
        done = invoke("run", case, "--overwrite", "--set", "output={fields: [gap]}")
        assert done.exit_code == 0

    def test_friction_maps_and_roughness_are_said(self, tmp_path: Path) -> None:
        mu = np.full((64, 64), 0.1)
        mu[:32, 32:] = 0.3  # left, top
        text_map(tmp_path, mu, name="mu.txt")
        rough = "{roughness: {hurst: 0.8, rms_height: 10 nm, cutoff: 40 um, span: 0.3 mm}}"
        text = CASE[: CASE.index("expect")].replace(
            "{sphere: {radius: 10 mm}}", f"[{{sphere: {{radius: 10 mm}}}}, {rough}]"
        )
        text = text.replace("friction: 0.1", "friction: {map: mu.txt, spacing: 20 um}").replace(
            "16}", "64, size: 1.2 mm}"
        )
        done = invoke("validate", write_case(tmp_path, text))
        assert done.exit_code == 0, done.stderr
        assert "values from 0.1 to 0.3" in done.stdout
        assert "left, x < 0: 0.2; right, x > 0: 0.1; bottom, y < 0: 0.1; top, y > 0: 0.2" in done.stdout
        assert "root mean square height 10 nm" in done.stdout

    def test_cases_without_maps_load_no_reader(self, tmp_path: Path) -> None:
        path = write_case(tmp_path)
        script = (
            "import sys; from fretsolve.cli.commands.validate import validate_cases; from pathlib import Path;"
            f"validate_cases([Path({str(path)!r})], []);"
            "print([name for name in sys.modules if name == 'h5py' or name.endswith(('load_map', 'map_measures'))])"
        )
        assert python(script).splitlines()[-1] == "[]"
