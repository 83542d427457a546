"""Melan's theorem: the ball around the path of the deviator against the yield surface."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from command_line import invoke, result_of
from small_cases import SPHERE, TWO_CYCLES, write_case

from fretsolve.post.fatigue.criteria import deviator_vectors
from fretsolve.post.fatigue.planes import smallest_ball
from fretsolve.post.fatigue.shakedown import Extent, WidestPath, widest_path

CROSSLAND = ("--material", "tension_limit=300 MPa,torsion_limit=190 MPa", "--criterion", "crossland")


def path(*states: tuple[float, ...]) -> np.ndarray:
    return np.array(states, float)[:, :, None]


def widest_of(*paths: np.ndarray, above: float = 0.0) -> tuple[float, int] | None:
    """Return the radius of the widest ball around paths at hand, and its place."""
    extent = Extent()
    for one in paths:
        extent.add(one)
    return widest_path(extent, lambda points: [one[:, :, points] for one in paths], above)


@pytest.mark.parametrize(
    ("states", "largest"),
    [
        (path((100, 0, 0, 0, 0, 0), (-100, 0, 0, 0, 0, 0)), 100),  # alternating tension: up to the yield stress
        (path((0, 0, 0, 0, 0, 0), (200, 0, 0, 0, 0, 0)), 100),  # pulsating tension: up to twice the yield stress
        (path((0, 0, 0, 60, 0, 0), (0, 0, 0, -60, 0, 0)), 60 * 3**0.5),  # torsion: up to k
        (path((0, 0, 0, 0, 0, 0), (0, 0, 0, 0, 60, 0)), 30 * 3**0.5),
        (path((70, 70, 70, 0, 0, 0), (-70, -70, -70, 0, 0, 0)), 0),  # pressure from all sides
        (path((100, 0, 0, 0, 0, 0), (0, 100, 0, 0, 0, 0), (0, 0, 100, 0, 0, 0)), 100),  # turning tension
    ],
)
def test_least_yield_stress_of_simple_cycles(states: np.ndarray, largest: float) -> None:
    """A cycle shakes down if the yield stress is at least sqrt(3) times the radius."""
    found = widest_of(states)
    assert (0.0 if found is None else 3**0.5 * found[0]) == pytest.approx(largest, abs=1e-9)


def test_bounds_leave_out_no_widest_path() -> None:
    stress = np.random.default_rng(5).normal(size=(7, 6, 300)) * np.linspace(0.5, 1.0, 300)
    radii, _ = smallest_ball(deviator_vectors(stress))
    for paths in ((stress,), (stress[:3], stress[3:])):
        radius, point = widest_of(*paths) or (0.0, 0)
        assert (radius, point) == (pytest.approx(radii.max(), rel=1e-12), radii.argmax())
    assert widest_of(stress, above=radii.max() * (1 + 1e-9)) is None


UNKNOWN = "whether elastic shakedown is possible cannot be said, since stress has no bound at a sharp edge or tip"


@pytest.mark.parametrize(
    ("radius", "error", "verdict"),
    [
        (70, 5, "elastic shakedown is impossible"),
        (60, 5, "elastic shakedown may be impossible"),
        (50, 5, "elastic shakedown is not ruled out"),
        (60, np.inf, UNKNOWN),
        (50, np.inf, UNKNOWN),
    ],
)
def test_verdicts(radius: float, error: float, verdict: str) -> None:
    """k is 57.74 MPa."""
    found = WidestPath(2, radius, error, 100.0, (0.1, 0.0, 0.02), averaged=False)
    assert not (np.isinf(error) and (found.possible or found.certain))
    text = str(found)
    assert text.startswith(f"body 2: {verdict}: the widest path of the deviator at x = 0.1, y = 0 mm, ")
    assert f"depth 0.02 mm, needs {radius / 57.735:.3g}" in text
    cells = " on these cells" if np.isinf(error) else ""
    assert f" times k = 57.74 MPa{cells} (Melan; yield stress 100 MPa)" in text
    assert ("necessary, not sufficient" in text) is ("not ruled out" in verdict)


@pytest.fixture(scope="module")
def loop(tmp_path_factory: pytest.TempPathFactory) -> Path:
    text = TWO_CYCLES.replace("poisson_ratio: 0.3}", "poisson_ratio: 0.3, yield_stress: 3 GPa}")
    return result_of(write_case(tmp_path_factory.mktemp("shakedown"), text, "loop.yaml"), "-q")


def test_stress_over_a_cycle_and_fatigue_tell_the_same(loop: Path) -> None:
    depths = ("--depth", "0mm", "--depth", "50um")
    told = invoke("stress", loop, *depths, "--cycle", "last").stdout.splitlines()[-1]
    assert told.startswith("body 2: elastic shakedown is not ruled out: ")
    assert invoke("stress", loop, *depths, "--cycle", "last", "-q", "--overwrite").stdout == ""
    material = "tension_limit=300 MPa,torsion_limit=190 MPa"
    found = invoke("fatigue", loop.with_suffix(".stress.h5"), "--material", material, "--criterion", "crossland")
    assert told in found.stdout.splitlines()
    assert "elastic shakedown" not in invoke("stress", loop, *depths, "--overwrite").stdout


def test_the_yield_stress_of_the_material_counts_where_the_body_has_none(tmp_path: Path) -> None:
    out = result_of(write_case(tmp_path, TWO_CYCLES, "loop.yaml"), "-q")
    keys, options = "tension_limit=300 MPa,torsion_limit=190 MPa", ("--criterion", "crossland", "-q", "--overwrite")
    assert invoke("fatigue", out, "--material", keys, *options).stderr == ""
    told = invoke("fatigue", out, "--material", f"{keys},yield_stress=100 MPa", *options).stderr
    assert told.startswith(f"{out}: warning: body 2: elastic shakedown is impossible: the widest path of the deviator")


def test_increments_without_fields_are_told(tmp_path: Path) -> None:
    text = TWO_CYCLES.replace("poisson_ratio: 0.3}", "poisson_ratio: 0.3, yield_stress: 3 GPa}")
    out = result_of(write_case(tmp_path, f"{text}output: {{every: 4}}\n", "loop.yaml"), "-q")
    told = invoke("stress", out, "--depth", "0mm", "--cycle", "last", "-q").stderr
    assert "shakedown is not looked at: increments without fields are among those where a stage" in told


def ratio_in(text: str) -> float:
    return float(text.partition("needs ")[2].split()[0])


def test_cycles_share_one_residual_stress(tmp_path: Path) -> None:
    """Between -480 and 480 MPa of bulk stress, 480 MPa over the yield stress are needed; each cycle needs 10 MPa."""
    cycle = "{{cycle: {{times: 1, stages: [{{bulk_2: {{xx: {} MPa}}}}, {{bulk_2: {{xx: {} MPa}}}}]}}}}"
    path = ["{P: 1 N}"]
    for size in (-480, 480):
        path += [f"{{bulk_2: {{xx: {size} MPa}}}}", cycle.format(size * 23 // 24, size)]
    text = f"{SPHERE.replace('points: 16', 'points: 8')}load_path: [{', '.join(path)}]\n".replace(
        "0.3}\nsurface", "0.3, yield_stress: 400 MPa}\nsurface"
    )
    out = result_of(write_case(tmp_path, text, "two.yaml"), "-q")
    depth = ("--depth", "0.5 mm", "--overwrite")
    together = invoke("stress", out, *depth, "--cycle", "all", "-q").stderr.splitlines()[-1]
    assert "body 2: elastic shakedown is impossible: the widest path of the deviator over 2 cycles together" in together
    assert ratio_in(together) == pytest.approx(480 / 400, rel=3e-3)
    found = invoke("fatigue", out.with_suffix(".stress.h5"), *CROSSLAND, "--cycle", "all").stderr.splitlines()[-1]
    assert found.partition("body 2")[2].split(" mm, needs")[0] == together.partition("body 2")[2].split(" mm, needs")[0]
    alone = invoke("stress", out, *depth, "--cycle", "2").stdout.splitlines()[-1]
    assert ratio_in(alone) == pytest.approx(10 / 400, rel=3e-3)


@pytest.mark.parametrize("increments", [3, 10])
def test_loading_from_rest_needs_half_of_the_largest_stress(tmp_path: Path, increments: int) -> None:
    """The von Mises stress below a sphere is at most .62004 p0 for nu .3, at a depth of .48 a."""
    text = SPHERE.replace("0.3}\nsurface", "0.3, yield_stress: 2 GPa}\nsurface").replace("points: 16", "points: 24")
    case = write_case(tmp_path, f"{text}load_path: [{{P: 400 N, increments: {increments}}}]\n", "ramp.yaml")
    told = invoke("stress", result_of(case, "-q"), "--depth", "145um", "--cycle", "last").stdout.splitlines()[-1]
    largest = 0.62004 * 2106.4  # MPa, of Hertz
    assert told.startswith("body 2: elastic shakedown is not ruled out")
    assert ratio_in(told) == pytest.approx(0.5 * largest / 2000, rel=5e-3)
