"""``fretsolve validate``: the effective case, the model, the grid, Hertz's contact and the cost, without solving."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import invoke, python, refused
from small_cases import CASE, UNLIKE, write_case

from fretsolve import load_case
from fretsolve.cli.commands.validate import effective_yaml
from fretsolve.problem.setup.cost_estimate import estimate
from fretsolve.simulation.accuracy.rounds import first_round
from fretsolve.simulation.problem_setup import set_up

ELLIPSOID = "surface={ellipsoid: {radius_x: 10 mm, radius_y: 25 mm, angle: 30 deg}}"


def validated(tmp_path: Path, *sets: str) -> tuple[str, str]:
    """Output and messages for the tiny case with `sets`."""
    words = [word for value in sets for word in ("--set", value)]
    result = invoke("validate", write_case(tmp_path), *words)
    assert result.exit_code == 0, result.stderr
    return result.stdout, result.stderr


def test_report_on_a_sphere(tmp_path: Path) -> None:
    output, messages = validated(tmp_path, "grid.points=64")
    assert re.search(r"tangential problem +on +\d+% +\d+%  qx, qy; ux .*: the load path moves Qx", output)
    assert "64 x 64 cells of 0.01129 x 0.01129 mm on 0.7227 x 0.7227 mm (auto)" in output
    assert "stage 1: P -> 400 N in 1 increment\n" in output
    assert "stage 2: Qx -> 20 N in 4 increments\n" in output
    assert "P = 400 N: a = 0.301107 mm, p0 = 2106.49 MPa, delta_z = 9.06654 um" in output
    assert "53.3 cells across the contact" in output
    assert "gross slip begins at Q = mu P = 40 N or at Mz = 7.09467 N mm" in output
    assert re.search(r"about \d+ MB of memory", output)
    assert messages == ""


def test_stick_radius_between_unlike_bodies_has_a_closed_form_under_p_alone(tmp_path: Path) -> None:
    none = "no closed form gives the stick radius under a tangential load between unlike bodies"
    assert none in validated(tmp_path, UNLIKE)[0]
    assert none not in validated(tmp_path)[0]
    pressed, _ = validated(tmp_path, UNLIKE, "load_path=[{P: 400 N}]", "expect=[]")
    assert none not in pressed and "(Spence" in pressed
    line = ("plane=strain", "surface={cylinder: {radius: 10 mm}}", "expect=[]")
    path = "load_path=[{P: 100 N/mm}, {Qx: 5 N/mm}]"
    assert none in validated(tmp_path, UNLIKE, *line, path)[0]
    assert none not in validated(tmp_path, *line, path)[0]


def test_effective_case_is_a_case(tmp_path: Path) -> None:
    case = load_case(write_case(tmp_path), [ELLIPSOID, "grid.center=[0.1 mm, 0]", "title='with: colon # and hash'"])
    written = effective_yaml(first_round(case))
    again = load_case(write_case(tmp_path, written, "effective.yaml"))
    assert again == case
    assert "&" not in written


def test_no_hertz_where_it_does_not_apply(tmp_path: Path) -> None:
    for path in ("[{P: 400 N, My: 20 N mm}]", "[{P: 0 N}]"):
        output, _ = validated(tmp_path, f"load_path={path}", "expect=[]", "grid.size=1 mm")
        assert "Hertz" not in output
        assert ("\nMy > 0 is more pressure at x > 0\n" in output) is ("My" in path)
    output, _ = validated(tmp_path, "surface={cone: {angle: 2 deg}}", "grid.size=1 mm")
    assert "Hertz" not in output


def test_several_cases_and_the_errors_of_all(tmp_path: Path) -> None:
    good = write_case(tmp_path, name="good.yaml")
    bad = write_case(tmp_path, CASE.replace("points", "pints"), "bad.yaml")
    result = invoke("validate", bad, good, tmp_path / "none.yaml")
    assert result.exit_code == 4
    assert f"{good}, with all defaults" in result.stdout
    lines = result.stderr.splitlines()
    assert lines[0].startswith(f"{bad}:6: grid.pints: unknown key")
    assert lines[-1].startswith(f"{tmp_path / 'none.yaml'}: cannot be read")
    assert invoke("validate", good, bad).exit_code == 2


def test_missing_height_map_is_found_before_the_run(tmp_path: Path) -> None:
    heights = "surface={heights: {file: map.npy, spacing: 1 um}}"
    told = refused(4, "validate", write_case(tmp_path), "--set", heights, "--set", "grid.size=1 mm")
    assert str(tmp_path / "map.npy") in told


def test_validate_loads_no_solver(tmp_path: Path) -> None:
    code = (
        "import sys; from fretsolve.cli.main import main; sys.argv = ['fretsolve', 'validate', sys.argv[1]]\n"
        "try: main()\nexcept SystemExit: pass\n"
        "print([name for name in ('pyfftw', 'h5py', 'rich', 'scipy.fft', 'scipy.special') if name in sys.modules])"
    )
    assert python(code, write_case(tmp_path)).splitlines()[-1] == "[]"


NORMAL = ("friction=0", "load_path=[{P: 400 N, increments: 2}]", "expect=[]")


RUN_AND_PRINT_MEMORY = """
import re
from pathlib import Path
from fretsolve.cli.main import main
try:
    main()
except SystemExit as end:
    assert not end.code, end.code
print(re.search(r"VmHWM:\\s*(\\d+) kB", Path("/proc/self/status").read_text())[1])
"""
"""The process's own peak: what the parent's wait reports begins with the parent's size."""


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="reads Linux's /proc")
@pytest.mark.parametrize(
    "sets",
    [
        pytest.param(NORMAL, id="normal"),
        pytest.param((UNLIKE, "load_path.1.increments=1"), id="coupled", marks=pytest.mark.slow),
    ],
)
@pytest.mark.slow
def test_estimated_memory(sets: tuple[str, ...], tmp_path: Path) -> None:
    case = write_case(tmp_path)
    values = ["grid.points=256", *sets]
    words = [word for value in values for word in ("--set", value)]
    command = [sys.executable, "-c", RUN_AND_PRINT_MEMORY, "run", str(case), "-q", "--overwrite", *words]
    expected = estimate(set_up(load_case(case, values))).memory
    for last in (False, True):  # the first run may compile kernels, which takes memory too
        taken = 1024 * int(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
        if last or expected == pytest.approx(taken, rel=0.2):
            break
    assert expected == pytest.approx(taken, rel=0.2)


def test_flat_round_punch_has_its_closed_form(tmp_path: Path) -> None:
    case = write_case(tmp_path, CASE.replace("{sphere: {radius: 10 mm}}", "{punch: {radius: 1 um}}"))
    done = invoke("validate", case, "--set", "load_path=[{P: 4 N}]", "--set", "expect=[]")
    assert done.exit_code == 0
    told = "P = 4 N: a = 0.001 mm, mean pressure = 1.27324e+06 MPa, delta_z = 18.2 um\n"
    assert f"# Boussinesq at the largest load\n{told}" in done.stdout  # P/(pi a^2), P/(2 E* a)
    assert "load_path: the punch goes deep against its radius (delta_z/a = 18," in done.stderr
    rounded = invoke("validate", case, "--set", "surface.punch.edge_radius=0.1 um")
    assert "Boussinesq" not in rounded.stdout


def test_error_bars_as_a_run_has_them(tmp_path: Path) -> None:
    case = write_case(tmp_path)
    plain, with_bars = (invoke("validate", case, *options).stdout for options in ((), ("--error-bars",)))
    assert "error_bars: true" in with_bars and "error_bars: false" in plain
    plainly, more = (int(re.search(r"about (\d+) operator", text).group(1)) for text in (plain, with_bars))  # type: ignore[union-attr]
    assert more > plainly


def test_what_a_layer_adds(tmp_path: Path) -> None:
    alike = "bodies=[{young_modulus: 200 GPa, poisson_ratio: 0}, {young_modulus: 200 GPa, poisson_ratio: 0}]"
    output, _ = validated(tmp_path, alike, "interface={shear_compliance: 3.107233e-6 mm/MPa}", "expect=[]")
    assert "layer: it shears by L = 3.107e-06 mm/MPa, L E'/a = 1, 41.2 % of the motion while nothing slips\n" in output
    assert (
        "gross slip under Q begins at a displacement of 1.58014 um (Cattaneo-Mindlin and L mu p0 of the layer)\n"
        "just after a load turns back, Q changes by 36.564 N per um of the displacement\n"
        "no closed form gives the stick radius: a layer between the bodies shears, which Cattaneo and Mindlin do not"
        " have\n"
    ) in output
    output, _ = validated(tmp_path, "interface={normal_compliance: 1e-6 mm/MPa}", "expect=[]")
    assert "layer: it is compressed by 1e-06 mm/MPa, so that no closed form gives the contact\n" in output
    assert "Hertz" not in output
    line = ("plane=strain", "surface={cylinder: {radius: 10 mm}}", "load_path=[{P: 100 N/mm}, {Qx: 5 N/mm}]")
    output, _ = validated(tmp_path, *line, "interface={shear_compliance: 1e-6 mm/MPa}", "expect=[]")
    assert "layer: it shears by L = 1e-06 mm/MPa, L E'/a = 0.715\n" in output
    assert "no closed form gives the stick zone: a layer between the bodies shears" in output
