"""``run``, ``show`` and ``stress`` say in a line where a body yields."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from command_line import invoke, result_of
from small_cases import write_case

TITANIUM = "bodies: [{material: Ti-6Al-4V}, {material: Ti-6Al-4V}]\n"
FLAT = f"""\
{TITANIUM}surface: {{sphere: {{radius: 10 mm}}}}
friction: 0.8
grid: {{points: 16}}
load_path: [{{P: 300 N}}, {{Qx: 239 N, increments: 2}}]
"""
ROUGH = f"""\
{TITANIUM}surface:
  - {{sphere: {{radius: 10 mm}}}}
  - {{roughness: {{rms_height: 3 um, hurst: 0.8, seed: 1, cutoff: 0.1 mm}}}}
friction: 0
grid: {{points: 64, size: 0.8 mm}}
load_path: [{{P: 120 N}}]
"""
WORN = """\
plane: strain
bodies: [{material: Ti-6Al-4V, yield_stress: 320 MPa}, {material: Ti-6Al-4V}]
surface: {cylinder: {radius: 10 mm}}
grid: {points: 40, size: 0.6 mm}
friction: 0.2
wear: {law: energy, alpha: 1e-4 mm^3/J}
load_path:
  - {P: 150 N/mm}
  - {Qx: 20 N/mm, increments: 1}
  - cycle: {represents: 200000, stages: [{Qx: -20 N/mm, increments: 1}, {Qx: 20 N/mm, increments: 1}]}
"""


def warnings(folder: Path, text: str, *options: str) -> list[str]:
    """The warnings of a quiet run that speak of yield."""
    result = invoke("run", write_case(folder, text), "-q", *options)
    assert result.exit_code == 0, result.stderr
    return [line.partition("warning: ")[2] for line in result.stderr.splitlines() if "yield" in line]


def ratio_of(line: str, after: str = " times the yield stress") -> float:
    return float(line.partition(after)[0].split()[-1])


def test_shear_at_the_surface_is_told_with_place_and_ratio(tmp_path: Path) -> None:
    """Hertz's p0 of 1341 MPa alone yields nothing, but friction carries mu p0, and sqrt(3) mu p0 is 1858 MPa."""
    before, _, one, two = warnings(tmp_path, FLAT)
    assert before.startswith("bodies.0.yield_stress: friction carries up to 1073 MPa of shear")
    assert before.endswith(
        "body 1 bears 508.1 MPa, the yield stress over sqrt(3): it may yield at the surface; the solution is elastic"
    )
    assert one.startswith("body 1 yields at the surface: the von Mises stress is at least 18")
    assert " MPa at x = " in one and ", y = " in one
    assert " mm in increment 2, sqrt(3) times the shear traction there, " in one
    assert ratio_of(one) == pytest.approx(1858 / 880, rel=0.03)
    assert two == one.replace("body 1", "body 2")


def test_no_place_without_fields(tmp_path: Path) -> None:
    *_, line = warnings(tmp_path, f"{FLAT}output: {{fields: []}}\n")
    assert " MPa in increment 2, sqrt(3) times" in line


def test_pressure_of_a_rough_sphere_is_told(tmp_path: Path) -> None:
    one, two = warnings(tmp_path, ROUGH)
    assert one.startswith("body 1 yields below the surface, if pressure falls off about as Hertz's does: ")
    assert " of the 1464 MPa" not in one and " times the 1464 MPa (1.664 times the yield stress 880 MPa)" in one
    assert one.endswith("at a depth of 0.495 times half the width of the contact there; the solution is elastic")
    largest = float(one.partition("does: ")[2].split()[0])
    assert largest > 1.5 * 1464
    assert ratio_of(one, " times the 1464 MPa") == pytest.approx(largest / 1464, rel=0.01)
    assert two.startswith("body 2")


@pytest.mark.slow
def test_pressure_at_the_edge_of_a_worn_contact_is_told(tmp_path: Path) -> None:
    """Hertz's 555 MPa is below 1.841 times the yield stress, 589 MPa; wear raises it at the edge of the stick zone."""
    (line,) = warnings(tmp_path, WORN)
    assert line.startswith("body 1 yields below the surface, if pressure falls off about as Hertz's does: ")
    assert " times the 589.1 MPa (1.841 times the yield stress 320 MPa) " in line
    assert line.endswith("at a depth of 0.736 times half the width of the contact there; the solution is elastic")


def test_what_was_told_before_the_run_is_not_told_again(tmp_path: Path) -> None:
    lines = warnings(tmp_path, FLAT.replace("0.8", "0.1").replace("239", "20").replace("300 N", "2 kN"))
    assert [line.split()[0] for line in lines] == ["bodies.0.yield_stress:", "bodies.1.yield_stress:"]
    assert " is above 1.664 times the yield stress, 1464 MPa, from where body 1 yields below" in lines[0]


def test_a_line_of_low_poisson_ratio_yields_at_the_surface(tmp_path: Path) -> None:
    """At nu .1, the von Mises stress at the surface is (1 - 2 nu) p0 = .8 p0, more than below."""
    body = "{young_modulus: 200 GPa, poisson_ratio: 0.1, yield_stress: 400 MPa}"
    text = f"plane: strain\nbodies: [{body}, {body}]\nsurface: {{cylinder: {{radius: 10 mm}}}}\nfriction: 0\n"
    text += "grid: {points: 48, size: 0.5 mm}\nload_path: [{P: 120 N/mm}]\n"
    lines = warnings(tmp_path, text)
    assert len(lines) == 2
    assert " is above 1.25 times the yield stress, 500 MPa, from where body 1 yields at the surface; the" in lines[0]
    assert "depth" not in lines[0]
    shown = invoke("show", tmp_path / "case.h5").stdout.splitlines()
    (line,) = (line for line in shown if line.startswith("body 1"))
    assert line.startswith("body 1 yields at the surface, if pressure falls off about as Hertz's does: ")
    assert line.endswith(" from where Hertz's pressure yields a body; the solution is elastic")


def test_bulk_stress_alone_is_told(tmp_path: Path) -> None:
    path = "[{P: 10 N}, {bulk_2: {xx: 800 MPa, yy: -200 MPa}, increments: 1}]"
    (line,) = warnings(tmp_path, FLAT.replace("0.8", "0.01").partition("load_path")[0] + f"load_path: {path}\n")
    value = (800**2 + 800 * 200 + 200**2) ** 0.5
    assert line == (
        f"body 2 yields by its bulk stress alone: the von Mises stress is {value:.4g} MPa in increment 1,"
        f" {value / 880:.3g} times the yield stress 880 MPa; the solution is elastic"
    )


def test_nothing_is_told_of_bodies_that_bear_it_or_have_no_yield_stress(tmp_path: Path) -> None:
    assert warnings(tmp_path, FLAT.replace("0.8", "0.1").replace("239", "20")) == []
    steel = FLAT.replace("material: Ti-6Al-4V", "young_modulus: 200 GPa, poisson_ratio: 0.3")
    assert warnings(tmp_path, steel, "--overwrite") == []


def test_other_formats_and_show_tell_it(tmp_path: Path) -> None:
    case = write_case(tmp_path, FLAT)
    events = [json.loads(line) for line in invoke("run", case, "--log-json").stdout.splitlines()]
    told = [one["message"] for one in events if one["event"] == "warning" and "yields" in one["message"]]
    assert len(told) == 2
    shown = invoke("show", case.with_suffix(".h5")).stdout
    assert all(shown.count(text) == 1 for text in told)
    assert invoke("run", case, "--overwrite").stdout.count(told[0]) == 0  # among the warnings alone


def test_computed_stress_is_compared_with_its_error(tmp_path: Path) -> None:
    """On the surface the von Mises stress under full sliding is larger than its least value from the shear."""
    out = result_of(write_case(tmp_path, FLAT), "-q")
    told = invoke("stress", out, "-q", "--depth", "0mm").stderr.splitlines()
    assert len(told) == 1
    assert told[0].startswith(f"{out}: warning: body 2 ")
    assert " ± " in told[0] and ", depth 0 mm, increment 2, " in told[0]
    # below, the computed stress is borne, but the bound at the surface holds
    told = invoke("stress", out, "-q", "--depth", "0.3mm", "--overwrite").stderr.splitlines()
    assert len(told) == 1 and "at least" in told[0]


def test_computed_stress_within_its_error_may_yield(tmp_path: Path) -> None:
    text = FLAT.replace("0.8", "0.1").replace("239", "20")
    out = result_of(write_case(tmp_path, text), "-q")
    lines = invoke("stress", out, "--depth", "0.06mm").stdout.splitlines()
    value, error = (float(part) for part in lines[1].split("stress")[1].split(" MPa")[0].split("±"))
    for limit, verb in ((value - 0.5 * error, "may yield"), (value - 2.0 * error, "yields"), (value + 2 * error, "")):
        new = text.replace("material: Ti-6Al-4V", f"material: Ti-6Al-4V, yield_stress: {limit} MPa")
        out = result_of(write_case(tmp_path, new, "limited.yaml"), "-q", "--overwrite")
        told = invoke("stress", out, "-q", "--depth", "0.06mm", "--overwrite").stderr.splitlines()
        assert [f"body 2 {verb}: the von Mises stress is " in line for line in told] == [True] * bool(verb)


def test_a_run_with_stresses_tells_each_body_once(tmp_path: Path) -> None:
    told = warnings(tmp_path, f"{FLAT}output: {{stress: {{bodies: [2], depths: [0 mm]}}}}\n")
    assert [line.split(":")[0] for line in told[2:]] == ["body 1 yields at the surface", "body 2 yields"]
