"""A case that follows a measured loop: the stages that stay, those that come, and the force."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from fitting import FIT_CASE, mindlin_branch, record, write_record
from small_cases import write_case

from fretsolve.errors import CaseError
from fretsolve.sweep.fit.model_loop import LoopModel, area
from fretsolve.sweep.fit.plan import FitRequest, make_fit_plan

STAGES = FIT_CASE.partition("load_path:\n")[2]


def models(folder: Path, text: str = FIT_CASE, motion: str = "actuator_x (um)") -> tuple[LoopModel, ...]:
    loop = write_record(folder / "loop.csv", record(mindlin_branch(0.1, 50e3, 4e-3)), motion)
    return make_fit_plan(FitRequest(write_case(folder, text), (), loop, ("friction",))).models


def test_pressing_stays_and_the_motion_follows_the_turns(tmp_path: Path) -> None:
    model, _ = models(tmp_path, FIT_CASE.replace("{P: 400 N}", "{P: 300 N}\n  - {P: 400 N}"))
    case = model.case([0.2])
    assert case.friction.coefficient == 0.2
    moved = [dict(stage.targets) for stage in case.stages()]
    assert moved[:2] == [{"P": 300.0}, {"P": 400.0}]
    ends = [one["actuator_x"] for one in moved[2:]]
    start, turn = ends[0], ends[1]
    assert ends[:3] == [start, turn, start]
    assert (ends[18], ends[34], len(ends)) == (turn, start, 35)
    np.testing.assert_allclose([start, turn], [4e-3, -4e-3], rtol=2e-3)
    # closer where the force changes
    steps = -np.diff([start, *ends[3:19]])
    assert np.all(steps > 0.0)
    assert steps[:8].max() < 0.7 * steps[-4:].min()


def test_fine_grids_come_after_a_coarse_one(tmp_path: Path) -> None:
    text = FIT_CASE.replace("points: 24", "points: 64")
    assert [one.points for one in models(tmp_path, text)] == [32, None]
    assert [one.case([0.1]).grid.points for one in models(tmp_path, text)] == [(32, 32), (64, 64)]


def test_motion_of_the_contact_without_a_rig(tmp_path: Path) -> None:
    text = FIT_CASE.replace("rig: {stiffness_x: 70 kN/mm}", "").replace("actuator_x", "delta_x")
    model, _ = models(tmp_path, text, "delta_x (um)")
    assert model.motion == "delta_x"


def test_columns_name_the_motion(tmp_path: Path) -> None:
    loop = write_record(tmp_path / "loop.csv", record(mindlin_branch(0.1, 50e3, 4e-3)), "delta_x (um)")
    request = FitRequest(write_case(tmp_path, FIT_CASE), (), loop, ("friction",), ("Qx", "delta_x (um)"))
    assert make_fit_plan(request).models[-1].motion == "delta_x"
    loop.write_text(loop.read_text().replace("delta_x", "Stroke").replace("Qx", "Load"))
    request = FitRequest(request.case, (), loop, ("friction",), ("Load", "Stroke"))
    assert make_fit_plan(request).models[-1].motion == "actuator_x"
    no_rig = FIT_CASE.replace("rig: {stiffness_x: 70 kN/mm}", "").replace("actuator_x", "delta_x")
    request = FitRequest(write_case(tmp_path, no_rig), (), loop, ("friction",), ("Load", "actuator_x"))
    with pytest.raises(CaseError) as caught:
        make_fit_plan(request)
    said = "--columns actuator_x: is known with a rig alone; add rig: {stiffness_x: 50 kN/mm} to the case"
    assert str(caught.value) == said


@pytest.mark.parametrize(
    ("stages", "said"),
    [
        ("  - {P: 400 N, Qx: 10 N}\n", "stage.1: moves P beside the motion along x; a fit takes stages that press"),
        ("  - {P: 400 N}\n  - {Mz: 5 N mm}\n", "stage.2: moves Mz beside the motion along x; a fit takes"),
        ("  - {P: 400 N}\n  - {Qx: 5 N}\n  - {P: 300 N}\n", "stage.3: moves P beside the motion along x; a fit takes"),
        ("  - {P: 400 N, friction: 0.2}\n", "stage.1: moves friction beside the motion along x; a fit takes"),
        (
            "  - {P: 400 N}\n  - {bulk_2: {xx: 70 MPa}, Qx: 1 N}\n",
            "stage.2: moves bulk_2_xx beside the motion along x; a fit takes",
        ),
    ],
)
def test_refused_load_paths(tmp_path: Path, stages: str, said: str) -> None:
    with pytest.raises(CaseError) as caught:
        models(tmp_path, FIT_CASE.replace(STAGES, stages))
    assert said in str(caught.value)


def test_wear_is_refused(tmp_path: Path) -> None:
    cycle = "  - cycle: {represents: 1000, amplitude: {actuator_x: 4 um}}\n"
    text = (
        FIT_CASE.replace("  - {actuator_x: 4 um, increments: 20}\n", cycle)
        + "wear: {law: energy, alpha: 1e-4 mm^3/J}\n"
    )
    with pytest.raises(CaseError, match="wear: a fit follows one settled cycle, without wear; leave it out"):
        models(tmp_path, text)


def test_force_at_the_measured_motions(tmp_path: Path) -> None:
    loop = write_record(tmp_path / "loop.csv", record(mindlin_branch(0.1, 50e3, 4e-3), drifts=False))
    case = write_case(tmp_path, FIT_CASE.replace("points: 24", "points: 12"))
    plan = make_fit_plan(FitRequest(case, (), loop, ("friction", "rig.stiffness_x")))
    branches = plan.models[-1].branches([0.1, 50.0])
    assert branches.slides
    # Cattaneo's and Mindlin's loop, on a coarse grid
    force, slope = branches.at(plan.loop)
    assert np.abs(force - plan.loop.force).max() < 0.012 * 80.0
    assert area(*branches.curves(100)) == pytest.approx(area(plan.loop.motion, plan.loop.force), rel=5e-3)
    # the slope after a turn is that of the springs in series
    assert slope.max() == pytest.approx(26076.33, rel=0.02)
