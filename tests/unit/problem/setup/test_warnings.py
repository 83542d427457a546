"""The warnings of `validate`, `run` and `check`: theory, resolution, loads and settings."""

from __future__ import annotations

from pathlib import Path

import pytest
from command_line import invoke
from line_cases import line_case
from small_cases import CASE, UNLIKE, write_case
from solving import build

from fretsolve import load_case
from fretsolve.cli.commands.check import cases_at
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.problem.setup.warnings import case_warnings
from fretsolve.problem.setup.yield_warnings import cylinder_contact
from fretsolve.simulation.problem_setup import set_up

FINE = CASE.replace("points: 16", "points: 64")
CASES = cases_at(Path(__file__).parents[4] / "cases")[0]
PRESSED = "load_path.1.Qx=0 N"


def setup_of(folder: Path, *sets: str, text: str = FINE) -> object:
    return set_up(load_case(write_case(folder, text), sets))


LONG = "radius: 10 mm, length: 8 mm, end_radius: 4 mm"
WARNINGS = {
    ("grid.points=16",): "grid.points: only 13.3 cells across the contact; 20 or more",
    ("surface={cone: {angle: 2 deg}}", "grid.points=16"): "grid.points: only 13.3 cells across",
    (PRESSED, "grid={points: 64, size: 40 mm}"): "grid.points: only 0.96 cells across the contact; 20 or more",
    ("surface={punch: {radius: 0.2 mm}}", "grid={points: 64, size: 200 mm}"): "grid.points: only 0.13 cells across",
    (PRESSED, "surface={cone: {angle: 2 deg}}", "grid={points: 64, size: 8 mm}"): "grid.points: only 4.1 cells across",
    (f"surface={{cylinder: {{{LONG}, axis: x}}}}", "grid={points: [512, 60], size: [9 mm, 0.5 mm]}"): "only 18.2 cells",
    (f"surface={{cylinder: {{{LONG}, axis: y}}}}", "grid={points: [60, 512], size: [0.5 mm, 9 mm]}"): "only 18.2 cells",
    ("grid={points: 64, size: 1.9281 mm}",): "grid.points: only 19.9 cells across the contact; 20 or more",
    ("load_path.1.Qx=39.9999 N",): "grid.points: the stick zone shrinks to 0.72 cells across in stage 2 (Cattaneo",
    ("load_path.1.Qx=40 N",): "stage.2.Qx: 40 N is not below the 40 N (mu P) that friction carries",
    ("friction=0",): "20 N is not below the 0 N (friction is 0) that friction carries",
    ("load_path.1={Qx: 30 N, Qy: -31 N}",): "stage.2.Qy: 43.1393 N is not below the 40 N (mu P)",
    ("load_path.1={Mz: 7.1 N mm}",): "stage.2.Mz: 7.1 N mm is not below the 7.09467 N mm (3 pi mu P a/16)",
    ("load_path=[{P: 400 N}, {Qx: 30 N}, {P: 200 N}]",): "stage.3: 30 N is not below the 20 N",
    ("load_path.0={delta_z: 9 um}", "load_path.1.Qx=40 N"): "is not below the 39.5604 N (mu P)",
    ("load_path.0.P=400 kN", "grid.size=18 mm"): "load_path: the contact is large against the radius (a/R = 0.3, p0/",
    ("bodies.0.young_modulus=200 MPa", "grid.size=8 mm"): "are all units right?",
    ("surface={punch: {radius: 0.1 mm}}", "grid.size=0.3 mm"): "deep against its radius (delta_z/a = 0.18, mean",
    ("surface={punch: {radius: 0.1 mm}}", "grid.size=0.3 mm", "load_path.0={delta_z: 18.2 um}"): "delta_z/a = 0.18, m",
    ("grid.size=0.61 mm",): "grid.size: the contact comes near the grid's edge or reaches it; [0.723 mm, 0.723 mm]",
    ("grid={points: 64, size: 0.8 mm, center: [0.1 mm, 0]}",): "grid.size: the contact comes near",
    ("surface.sphere.radius=-10 mm", "grid.size=1 mm"): "surface.sphere.radius: -10 mm is concave",
    ("surface={cone: {angle: 80 deg}}",): "cone.angle: 80 deg between flank and contact plane is steep",
    ("load_path.1={delta_x: 5 mm}",): "load_path: delta_x moves the surfaces by 17 contact radii",
    ("load_path.1={phi_z: 90 deg}",): "load_path: phi_z moves the surfaces by 1.6 contact radii",
    ("solver.tolerance=0.5",): "solver.tolerance: 0.5 lets the contact conditions be violated by 50 %",
    ("solver={accuracy: 1 %, precision: single}", "grid.points=96"): (
        "solver.precision: single has too few digits for accuracy 1 % in many cases; take double, or an accuracy of 2 %"
    ),
    ("solver={accuracy: 1 %, tolerance: 1e-5}", "grid.points=96"): (
        "solver.tolerance: 1e-05 is looser than the 1e-06 that accuracy 1 % picks; leave it out to meet it"
    ),
    (UNLIKE, "load_path=[{P: 400 N}]", "expect=[]", "friction=0.05", "grid.points=32"): "(Spence: c = 0.0249 mm)",
}


@pytest.mark.parametrize("sets", WARNINGS, ids=" ".join)
def test_a_doubtful_case_gets_one_warning(sets: tuple[str, ...], tmp_path: Path) -> None:
    found = case_warnings(setup_of(tmp_path, *sets))
    assert sum(WARNINGS[sets] in text for text in found) == 1
    assert len(found) == 1
    assert all(text[0].islower() and "\n" not in text for text in found)


@pytest.mark.parametrize("case", CASES, ids=lambda path: path.stem)
def test_shipped_cases_get_no_warning(case: Path) -> None:
    setup = set_up(load_case(case))
    assert case_warnings(setup) == list(setup.model.warnings)


WORN = FINE.replace("20 N}", "20 N}\n  - cycle: {represents: 100, stages: [{Qx: -20 N}, {Qx: 20 N}]}") + "wear: WEAR\n"
BODIES = "bodies=[{young_modulus: E, poisson_ratio: 0.3}, rigid]"
CYLINDER = "surface=[{cylinder: {radius: 10 mm, crown_radius: 20 mm, axis: AXIS}}]"


@pytest.mark.parametrize(
    ("sets", "wear", "says"),
    [
        (BODIES.replace("E", "210"), None, "bodies.0.young_modulus: 210 without a unit is 210 MPa; is GPa meant?"),
        (BODIES.replace("E", "'210'"), None, "bodies.0.young_modulus: 210 without a unit is 210 MPa; is GPa meant?"),
        (BODIES.replace("E", "210e3"), None, None),
        (BODIES.replace("E", "210 MPa"), None, None),
        (CYLINDER.replace("AXIS", "30"), None, "axis: 30 without a unit is 30 rad, 1719 deg; is '30 deg' meant?"),
        (CYLINDER.replace("AXIS", "30 deg"), None, None),
        (CYLINDER.replace("AXIS", "0.5"), None, None),
        (CYLINDER.replace("AXIS", "x"), None, None),
        ("load_path.1={phi_z: 10}", None, "stage.2.phi_z: 10 without a unit is 10 rad, 573 deg; is '10 deg' meant?"),
        (
            "title=worn",
            "{law: energy, alpha: 1e-4}",
            "wear.alpha: 0.0001 without a unit is 0.0001 mm^3/(N mm), 0.1 mm^3/J; write which unit is meant",
        ),
        ("title=worn", "{law: archard, k: 1e-8}", "wear.k: 1e-08 without a unit is 1e-08 mm^3/(N mm), 1e-05 mm^3/J;"),
        ("title=worn", "{law: archard, k: 1e-8 mm^3/(N mm)}", None),
    ],
)
def test_a_bare_number_that_is_most_likely_in_another_unit(
    tmp_path: Path, sets: str, wear: str | None, says: str | None
) -> None:
    text = FINE if wear is None else WORN.replace("WEAR", wear)
    found = [one for one in case_warnings(setup_of(tmp_path, sets, "expect=[]", text=text)) if "without a unit" in one]
    assert len(found) == (says is not None)
    assert says is None or says in found[0]


WITHOUT_FRICTION = FINE.replace("friction: 0.1\n", "")


def test_missing_friction(tmp_path: Path) -> None:
    (found,) = case_warnings(setup_of(tmp_path, text=WITHOUT_FRICTION))
    assert found.startswith("friction: not given, so it is 0, although the load path moves Qx; write friction: 0 if")
    pressed = ("load_path=[{P: 400 N}]", "expect=[]")
    assert case_warnings(setup_of(tmp_path, *pressed, text=WITHOUT_FRICTION)) == []
    (found,) = case_warnings(setup_of(tmp_path, *pressed, UNLIKE, text=WITHOUT_FRICTION))
    assert "although the bodies differ (Dundurs' constant 0.1938)" in found
    assert case_warnings(setup_of(tmp_path, *pressed, UNLIKE, "friction=0")) == []


def test_no_warning_where_the_theory_does_not_apply(tmp_path: Path) -> None:
    assert case_warnings(setup_of(tmp_path, "load_path.0={P: 400 N, My: 8 N mm}", "grid.size=0.8 mm")) == []
    assert case_warnings(setup_of(tmp_path, "load_path.1={delta_x: 5 um}", "expect=[]")) == []
    assert case_warnings(setup_of(tmp_path, "load_path.1={phi_z: 1 deg}", "expect=[]")) == []


def test_no_warning_where_digits_suffice_for_the_accuracy(tmp_path: Path) -> None:
    for solver in ("accuracy: 2 %, precision: single", "accuracy: 1 %, tolerance: 4e-6", "accuracy: 1 %"):
        assert case_warnings(setup_of(tmp_path, f"solver={{{solver}}}", "grid.points=96")) == []


@pytest.mark.parametrize("command", ["validate", "run", "check"])
def test_commands_warn_alike_and_once(command: str, tmp_path: Path) -> None:
    text = CASE.replace("friction: 0.1\n", "").replace("{Qx: 20 N, increments: 4}", "{delta_x: 1 um}")
    case = write_case(tmp_path, text)
    sets = ("solver.tolerance=0.01", "expect=[{quantity: P, value: 400, rel: 1}]")
    result = invoke(command, case, "--set", sets[0], "--set", sets[1])
    assert result.exit_code == 0
    place, output = ("  ", result.stdout) if command == "check" else (f"{case}: ", result.stderr)
    lines = [line.partition("warning: ") for line in output.splitlines() if "warning" in line]
    assert [text.partition(":")[0] for _, _, text in lines] == ["friction", "grid.points", "solver.tolerance"]
    assert {begin for begin, _, _ in lines} == {place}
    assert command != "check" or result.stderr == ""


def test_validate_prints_the_closed_forms(tmp_path: Path) -> None:
    output = invoke("validate", write_case(tmp_path, FINE)).stdout
    assert "a/R = 0.0301, p0/E* = 0.0192, E* = 109890 MPa" in output
    assert "gross slip under Q begins at a displacement of 1.10094 um (Cattaneo-Mindlin)" in output
    assert "smallest stick radius c = 0.238989 mm, 42.3 cells across, at the end of stage 2 (Cattaneo" in output
    assert "Dundurs' constant 0\n" in output


@pytest.mark.slow
def test_very_large_results_are_told_before_the_run() -> None:
    """10 000 cycles keep the fields of 200 000 increments, of which a few are enough."""
    path = [{"P": 400.0}, {"cycle": {"amplitude": {"Qx": 20.0}, "times": 10_000}}]
    (text,) = [text for text in case_warnings(set_up(build(grid={"points": 64}, load_path=path))) if "takes" in text]
    assert "since it keeps fields of 200011 increments; output: {every: " in text
    assert text.endswith("until: periodic ends a cycle that changes no more")
    every = int(text.partition("{every: ")[2].partition("}")[0])
    smaller = build(grid={"points": 64}, load_path=path, output={"every": every})
    assert not [text for text in case_warnings(set_up(smaller)) if "takes" in text]


@pytest.mark.parametrize(("limit", "warned"), [(1300.0, True), (1310.0, False)])
def test_yield_is_told_where_a_body_gives_its_yield_stress(limit: float, warned: bool) -> None:
    """400 N on steel press with p0 = 2106 MPa, 1.6128 times 1305.8 MPa, on a radius of 0.3012 mm."""
    steel = {"young_modulus": 200e3, "poisson_ratio": 0.3}
    case = build(bodies=[steel, steel | {"yield_stress": limit}], grid={"points": 64})
    found = [text for text in case_warnings(set_up(case)) if "yield" in text]
    assert found == warned * [
        "bodies.1.yield_stress: p0 = 2106 MPa is above 1.613 times the yield stress, 2097 MPa, from where body 2 yields"
        " below the surface, at a depth of 0.145 mm; the solution is elastic"
    ]


@pytest.mark.parametrize(
    ("friction", "told"),
    [
        (0.5, "friction carries up to 1053 MPa of shear, and body 2 bears 1039 MPa, the yield stress over sqrt(3): it"),
        (0.49, ""),
        pytest.param({"coefficient": 0.5, "shear_limit": 1000.0}, "", marks=pytest.mark.slow),
        pytest.param({"coefficient": 2.0, "shear_limit": 1040.0}, "up to 1040 MPa of shear", marks=pytest.mark.slow),
        ({"initial": 0.2, "final": 0.6, "slip": 1.0}, "friction carries up to 1264 MPa of shear"),
        ({"coefficient": [0.5, 0.2]}, "friction carries up to 1053 MPa of shear"),
    ],
)
def test_friction_that_may_yield_the_surface_is_told(friction: object, told: str) -> None:
    """sqrt(3) times the shear of 1053 MPa at friction 0.5 is 1824 MPa."""
    steel = {"young_modulus": 200e3, "poisson_ratio": 0.3, "yield_stress": 1800.0}
    path = [{"P": 400.0}, {"Qx": 10.0}]
    case = build(bodies=[steel | {"yield_stress": None}, steel], grid={"points": 64}, friction=friction, load_path=path)
    found = [text for text in case_warnings(set_up(case)) if "yield" in text]
    assert len(found) == bool(told)
    assert all(told in text and "below the surface" not in text for text in found)


def test_a_line_contact_yields_at_another_pressure() -> None:
    """Under a cylinder a body of nu = 0.3 yields from p0 = 1.7937 Y on: 200 N/mm on 10 mm press with 836.4 MPa."""
    steel = {"young_modulus": 200e3, "poisson_ratio": 0.3}
    for limit, told in ((466.0, True), (467.0, False)):
        case = line_case(bodies=[steel, steel | {"yield_stress": limit}], load_path=[{"P": 200.0}])
        assert any("p0 = 836.4 MPa is above 1.794 times" in text for text in case_warnings(set_up(case))) is told


def cylinder_setup(points: int = 64, size: object = "auto", **options: object) -> ProblemSetup:
    """A cylinder of 10 mm along y under 200 N."""
    surface = {"cylinder": {"radius": 10.0, "axis": "y", **options}}
    return set_up(build(surface=surface, grid={"points": [48, points], "size": size}, load_path=[{"P": 200.0}]))


def test_sharp_ends_of_a_cylinder_are_told() -> None:
    setup = cylinder_setup(length=2.0)
    assert any(text.startswith("surface.0.cylinder.length: the ends of the cylinder") for text in case_warnings(setup))
    # Hertz's line contact under 100 N/mm, as in a line contact
    contact = cylinder_contact(setup)
    assert contact is not None
    found = (contact.load, contact.half_width, contact.max_pressure)
    assert found == pytest.approx((100.0, 0.107641, 591.431), rel=1e-5)


def test_rounded_ends_are_told_where_cells_do_not_resolve_the_contact_in_them() -> None:
    """The contact reaches 0.023 mm into roundings of 0.5 mm; cells of 0.01 mm show 0.96 of the pressure there."""
    beginning = "surface.0.cylinder.end_radius: the contact reaches about 0.027 mm into the rounding of the ends"
    for points, told in ((64, True), (160, False)):
        warnings = case_warnings(cylinder_setup(points, length=2.0, end_radius=0.5))
        assert any(text.startswith(beginning) for text in warnings) == told
        assert not any("ends of the cylinder are sharp" in text for text in warnings)
    contact = cylinder_contact(cylinder_setup(length=2.0, end_radius=0.5))
    assert contact is not None and contact.load == 200.0  # on the straight part


def test_cylinder_without_ends_ends_with_the_grid() -> None:
    setup = cylinder_setup(size=[0.4, 2.0])
    contact = cylinder_contact(setup)
    assert contact is not None and contact.load == pytest.approx(100.0)
    assert any("it has no ends, so that it ends at the grid's edge" in text for text in case_warnings(setup))


def test_crowned_cylinder_is_an_ellipsoid_unless_it_reaches_its_ends() -> None:
    ellipsoid = {"ellipsoid": {"radius_x": 10.0, "radius_y": 1000.0}}
    same = set_up(build(surface=ellipsoid, grid={"points": 64}, load_path=[{"P": 200.0}])).closed_forms.largest
    crowned = cylinder_setup(crown_radius=1000.0)
    found = crowned.closed_forms.largest
    assert found is not None and same is not None
    assert (found.max_pressure, found.delta_z) == pytest.approx((same.max_pressure, same.delta_z), rel=1e-9)
    assert found.half_extent == pytest.approx(same.half_extent, rel=1e-9)
    assert cylinder_setup(crown_radius=1000.0, length=4.0).closed_forms.largest == found
    assert not case_warnings(cylinder_setup(crown_radius=1000.0, length=4.0))
    assert cylinder_setup(crown_radius=1000.0, length=2.0).closed_forms.largest is None


@pytest.mark.parametrize(
    ("punch", "points", "plane", "warned"),
    [
        ({"radius": 0.5, "edge_radius": 0.1}, 48, None, True),
        ({"radius": 0.5, "edge_radius": 0.4}, 400, None, False),
        ({"half_width": 0.5, "edge_radius": 0.1}, 48, "strain", True),
        ({"half_width": 0.5, "edge_radius": 0.1}, 2048, "strain", False),
    ],
)
def test_a_rounding_that_the_contact_hardly_enters(punch, points, plane, warned, tmp_path):
    parts = {"surface": {"punch": punch}, "grid": {"points": points}, **({"plane": plane} if plane else {})}
    found = case_warnings(set_up(build(load_path=[{"P": 200.0}], **parts)), tmp_path / "out.h5")
    assert any("into the rounding of the edge" in text for text in found) == warned


@pytest.mark.parametrize(("motion", "warned"), [(0.02, False), (0.05, True)])
def test_motions_of_more_than_a_tenth_of_the_radius_are_told(motion: float, warned: bool) -> None:
    path = [{"P": 400.0}, {"delta_x": motion}]  # on a contact of 0.3 mm
    told = [
        text for text in case_warnings(set_up(build(load_path=path, grid={"points": 32}))) if "moves the surf" in text
    ]
    assert bool(told) == warned
    assert all("delta_x moves the surfaces by 0.17 contact radii" in text for text in told)
