"""Random cases: every increment certified and lawful, symmetric, the same in all units; or the case refused.

``FRETSOLVE_RANDOM_CASES=1000`` runs that many of each kind, other ones each time.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from families.driving import Findings, OutOfTimeError, Parts, Run, solve_parts, time_limit
from families.pairs import elastic
from hypothesis import HealthCheck, Phase, assume, given, settings
from hypothesis import strategies as st
from solving import LOADS, MOTIONS

from fretsolve.case.history import ACTUATORS
from fretsolve.case.models import Case
from fretsolve.errors import CaseError, ContactLostError, GridEdgeError, NotConvergedError, SlidingError
from fretsolve.problem.model.required_terms import derive_model
from fretsolve.result.state import State, Zone

ASKED = int(os.environ.get("FRETSOLVE_RANDOM_CASES", "0"))
TOLERANCE = 1e-6
REFUSED = (SlidingError, ContactLostError, GridEdgeError, CaseError)
"""Right answers to a random case; not to converge is not."""
ODD_IN_Y = frozenset({"Mx", "phi_x", "Qy", "delta_y", "Mz", "phi_z"})
LENGTHS = frozenset({"delta_z", "delta_x", "delta_y", "radius", "radius_x", "radius_y", "half_width", "edge_radius"})


TALLIES: list[dict[str, int]] = []
"""Ends of the cases of each test so far, and their increments."""


@pytest.fixture(autouse=True)
def _tally(record_property: Callable[[str, object], None]) -> None:
    TALLIES.append({})
    record_property("random cases", TALLIES[-1])


def count(how: str, number: int = 1) -> None:
    TALLIES[-1][how] = TALLIES[-1].get(how, 0) + number


def examples(number: int) -> Callable[[Any], Any]:
    """So many of them, the same ones each time, unless the environment asks for more."""
    return settings(
        max_examples=ASKED or number,
        deadline=None,
        derandomize=not ASKED,
        database=None,
        suppress_health_check=list(HealthCheck),
        phases=[Phase.explicit, Phase.generate],  # to shrink a case takes minutes
    )


def decades(lowest: float, highest: float) -> st.SearchStrategy[float]:
    return st.floats(lowest, highest).map(lambda exponent: 10.0**exponent)


ratios = st.one_of(st.sampled_from([0.0, 0.3, 0.5]), st.floats(-0.9, 0.5).map(lambda ratio: round(ratio, 6)))
bodies = st.builds(elastic, ratios, decades(3.0, 7.0))
pairs = st.one_of(
    bodies.map(lambda body: [body, body]),
    st.tuples(bodies, bodies).map(list),
    bodies.map(lambda body: ["rigid", body]),
    bodies.map(lambda body: [body, "rigid"]),
)
surfaces = st.one_of(
    st.just({"sphere": {"radius": 10.0}}),
    st.builds(
        lambda one, other, angle: {"ellipsoid": {"radius_x": one, "radius_y": other, "angle": angle}},
        st.floats(3.0, 30.0),
        st.floats(3.0, 30.0),
        st.integers(0, 180).map(math.radians),
    ),
    decades(-3.0, -0.5).map(lambda angle: {"cone": {"angle": angle}}),
    st.sampled_from([0.05, 0.2, 0.3]).map(lambda edge: {"punch": {"radius": 0.3, "edge_radius": edge}}),
    st.just([{"sphere": {"radius": -20.0}}, {"punch": {"radius": 0.3, "edge_radius": 0.1}}]),
)
part = st.integers(-90, 90).map(lambda percent: percent / 100)


@st.composite
def cases(draw: Any) -> Parts:
    """Pressed, then moved by up to three stages; mu |beta| at most 1, motions of the order of the elastic ones."""
    parts: Parts = {"bodies": draw(pairs), "surface": draw(surfaces), "solver": {"tolerance": TOLERANCE}}
    beta = abs(dundurs(parts))
    friction = draw(st.one_of(st.just(0.0), decades(-5.0, 0.5)))
    friction = min(friction, 1.0 / beta) if beta > 1e-3 else friction
    load = draw(decades(-2.0, 3.5))
    compliance = 1.0 / contact_modulus(parts)
    pull, arm = friction * load, 0.1
    shift, turn = 4.0 * pull * compliance / arm, 8.0 * pull * compliance / arm**2
    moves = {
        "P": part.map(lambda share: load * (1.0 + 0.7 * share)),
        "Qx": part.map(lambda share: pull * share),
        "Qy": part.map(lambda share: pull * share),
        "Mz": part.map(lambda share: pull * arm * share),
        "delta_x": part.map(lambda share: shift * share),
        "delta_y": part.map(lambda share: shift * share),
        "phi_z": part.map(lambda share: turn * share),
    }
    if "sphere" in parts["surface"]:  # elsewhere a moment may topple the body
        radius = math.cbrt(0.75 * load * 10.0 * compliance)
        moves |= dict.fromkeys(("Mx", "My"), part.map(lambda share: 0.3 * radius * load * share))
    path = [{"P": load, "increments": draw(st.integers(1, 3))}]
    for names in draw(st.lists(st.sets(st.sampled_from(sorted(moves)), min_size=1, max_size=3), max_size=3)):
        names -= {motion for force, motion in zip(LOADS, MOTIONS, strict=True) if force in names}
        stage = {name: draw(moves[name]) for name in sorted(names)}
        path.append(stage | {"increments": draw(st.integers(1, 3))})
    grid = {"points": [draw(st.integers(14, 26)), draw(st.integers(14, 26))]}
    return parts | {"friction": friction, "load_path": path, "grid": grid}


def dundurs(parts: Parts) -> float:
    return derive_model(model_of(parts)).compliances.dundurs_constant


def contact_modulus(parts: Parts) -> float:
    return derive_model(model_of(parts)).compliances.contact_modulus


def model_of(parts: Parts) -> Case:
    return Case.model_validate({"grid": {"points": 2}, "load_path": [{"P": 1.0}]} | parts)


def solved(parts: Parts) -> Run | None:
    """The case, with every increment examined; None where it is refused."""
    findings, ending = Findings(), "not solved"
    with TemporaryDirectory() as folder, time_limit(60.0):
        try:
            found = solve_parts(parts, Path(folder), findings)
            ending = "certified"
        except REFUSED as error:
            found = None
            ending = "refused"
            assert "\n" not in str(error)
            assert "nan" not in str(error)
        except NotConvergedError:
            ending = "given up"
            raise
        finally:
            count(ending)
            count("increments", findings.increments)
    assert findings.wrong == []
    return found


def motion(before: State, after: State) -> np.ndarray[Any, Any]:
    return np.array([getattr(after.summary, name) - getattr(before.summary, name) for name in MOTIONS])


def energy_defect(run: Run, before: State, after: State) -> tuple[float, float]:
    """Return what the trapezoidal work of the loads leaves over, and its scale.

    It is the change of elastic energy, the mean shear times the slip, and -(p0 g1 - p1 g0)/2, exactly (reciprocity).
    """
    grid, old, new = run.setup.grid, before.fields, after.fields
    tilt_y, tilt_x = grid.x[:, None], grid.y[None, :]
    material = np.isfinite(run.setup.separation())
    undeformed = np.where(material, run.setup.separation(), 0.0)

    def elastic_energy(state: State) -> float:
        s, found = state.summary, state.fields
        gap = np.where(material, found.gap, 0.0)
        uz = gap + s.delta_z + s.phi_x * tilt_x + s.phi_y * tilt_y - undeformed
        return 0.5 * float(np.vdot(found.pressure, uz) + np.vdot(found.shear, state.displacement))

    dx, dy, turn = motion(before, after)[3:]
    slip = before.displacement - after.displacement
    slip = slip + np.stack(np.broadcast_arrays(dx - turn * grid.y[None, :], dy + turn * grid.x[:, None]))
    sheared = float(np.vdot(0.5 * (old.shear + new.shear), slip))
    gaps = [np.where(material, state.fields.gap, 0.0) for state in (before, after)]
    opened = -0.5 * float(np.vdot(old.pressure, gaps[1]) - np.vdot(new.pressure, gaps[0]))
    stored = elastic_energy(after) - elastic_energy(before)
    mean = np.array([0.5 * (getattr(before.summary, name) + getattr(after.summary, name)) for name in LOADS])
    works = mean * motion(before, after)
    scale = float(np.abs(works).sum()) + elastic_energy(after) * grid.cell_area
    return abs(float(works.sum()) - (stored + sheared + opened) * grid.cell_area), scale


def check_laws(run: Run) -> None:
    """Check each increment's friction, gap, zones and slip, and the loads imposed by the end of each stage."""
    friction = run.setup.model.friction
    for state in run.states:
        fields, summary = state.fields, state.summary
        within = TOLERANCE * max(1.0, friction) * summary.max_pressure
        assert (np.hypot(*fields.shear) <= friction * fields.pressure + within).all()
        gap = fields.gap[np.isfinite(fields.gap)]
        assert gap.min() >= -TOLERANCE * max(abs(summary.delta_z), np.ptp(gap))
        assert ((fields.zone == Zone.OPEN) == (fields.pressure == 0.0)).all()
        assert (np.hypot(*fields.slip) <= fields.slip_path * (1.0 + 1e-12) + 1e-300).all()
    path, reach = run.setup.load_path, max(run.setup.grid.size)
    heaviest = max(state.summary.P for state in run.states)
    for last, stage in zip(path.last_steps, run.setup.case.stages(), strict=True):
        end = run.states[last].summary
        scales = dict.fromkeys(("Qx", "Qy"), friction * end.P) | {"Mz": friction * end.P * reach}
        scales |= {"P": heaviest} | dict.fromkeys(("Mx", "My"), heaviest * reach)
        for name, value in stage.targets:
            assert abs(getattr(end, name) - value) <= 2.0 * TOLERANCE * scales.get(name, 0.0) + 1e-10 * abs(value)


@examples(40)
@given(cases(), st.sampled_from(["auto", "auto", "none", "tangential", "full"]))
def test_increments_are_certified_lawful_and_balance_their_energy(parts: Parts, coupling: str) -> None:
    run = solved(parts | {"coupling": coupling})
    assume(run is not None)
    assert run is not None
    check_laws(run)
    for before, after in pairwise(run.states):
        defect, scale = energy_defect(run, before, after)
        assert defect <= 1e-6 * scale
        assert after.summary.work_total >= before.summary.work_total


@st.composite
def on_rigs(draw: Any) -> Parts:
    """Random cases on rigs from a hundred times as stiff as the contact to a hundred times as soft, with layers."""
    parts: Parts = draw(cases())
    load, compliance = parts["load_path"][0]["P"], 1.0 / contact_modulus(parts)
    size = 0.1
    stiffness = {"z": size / compliance, "phi_x": size**3 / compliance}
    stiffness |= {"x": stiffness["z"], "y": stiffness["z"], "phi_y": stiffness["phi_x"], "phi_z": stiffness["phi_x"]}
    keys = draw(st.sets(st.sampled_from(sorted(stiffness)), min_size=1))
    rig = {f"stiffness_{key}": stiffness[key] / draw(decades(-2.0, 2.0)) for key in sorted(keys)}
    path = [dict(stage) for stage in parts["load_path"]]
    for stage in path[1:]:
        for motion_name in MOTIONS:
            if motion_name in stage:
                own = ACTUATORS[motion_name]
                softness = stiffness[own.removeprefix("actuator_")] / rig.get(f"stiffness_{own[9:]}", math.inf)
                stage[own] = stage.pop(motion_name) * (1.0 + softness)
    layers: list[Parts] = [{}, {"shear_compliance": size * compliance * draw(decades(-3.0, 1.0))}]
    layers.append({"normal_compliance": size * compliance * draw(decades(-3.0, 1.0))})
    layer = draw(st.sampled_from(layers))
    pressed = draw(st.booleans())
    if pressed and "stiffness_z" in rig:  # by the actuator, as far as the load on the rig alone would move it
        path[0] = {name: value for name, value in path[0].items() if name != "P"}
        path[0]["actuator_z"] = load / rig["stiffness_z"] + (load * compliance) / size
        path[1:] = [stage for stage in path[1:] if not {"P", "Mx", "My"} & stage.keys()]  # which may topple the body
    return (
        parts
        | {"rig": rig, "load_path": path, "solver": {"tolerance": TOLERANCE}}
        | ({"interface": layer} if layer else {})
    )


@examples(25)
@given(on_rigs())
@pytest.mark.slow
def test_rigs_and_layers_are_certified_lawful_and_balance_their_energy(parts: Parts) -> None:
    run = solved(parts)
    assume(run is not None)
    assert run is not None
    check_laws(run)
    rig = run.setup.model.rig
    assert rig is not None
    for before, after in pairwise(run.states):
        defect, scale = energy_defect(run, before, after)
        assert defect <= 1e-6 * scale
    for state in run.states:
        loads = np.array([getattr(state.summary, name) for name in LOADS])
        moved = np.array([getattr(state.summary, name) for name in MOTIONS])
        driven = np.array([getattr(state.summary, name) for name in ACTUATORS.values()])
        size = np.abs(moved) + rig.compliance @ np.abs(loads)
        arms = np.array([1.0, 0.1, 0.1, 1.0, 1.0, 0.1])
        assert (np.abs(driven - moved - rig.compliance @ loads) * arms <= 1e-5 * (size * arms).max()).all()


@examples(10)
@given(cases())
def test_mirror_image(parts: Parts) -> None:
    """y turned round."""
    here, there = solved(parts), solved(mirrored(parts))
    assert (here is None) == (there is None)
    if here is None or there is None:
        return
    peak = max(here.end.max_pressure, 1e-300)
    shear = 1e-3 * here.end.max_shear + 10.0 * TOLERANCE * peak  # slip is exact to a part of the approach
    found, image = here.last.fields, there.last.fields
    assert np.abs(found.pressure - image.pressure[:, ::-1]).max() <= 1e-4 * peak
    assert np.abs(found.shear[0] - image.shear[0, :, ::-1]).max() <= shear
    assert np.abs(found.shear[1] + image.shear[1, :, ::-1]).max() <= shear


@examples(15)
@given(cases(), decades(-6.0, 6.0), decades(-6.0, 6.0))
def test_other_units(parts: Parts, length: float, stress: float) -> None:
    """All lengths and all stresses multiplied, the grid's as well."""
    sized = with_size(parts)
    here, there = solved(sized), solved(scaled(sized, length, stress))
    assert (here is None) == (there is None)
    if here is None or there is None:
        return
    peak = max(here.end.max_pressure, 1e-300)
    assert np.abs(found_pressure(there) / stress - found_pressure(here)).max() <= 1e-5 * peak
    size = max(abs(getattr(here.end, name)) for name in ("delta_z", "delta_x", "delta_y"))
    for name in ("delta_z", "delta_x", "delta_y"):
        assert abs(getattr(there.end, name) / length - getattr(here.end, name)) <= 1e-5 * size
    work = here.end.P * here.end.delta_z * 1e-6 + here.end.work_total
    assert abs(there.end.work_total / (stress * length**3) - here.end.work_total) <= 1e-4 * abs(work)


def with_size(parts: Parts) -> Parts:
    """With the size of the grid that `auto` chooses."""
    with TemporaryDirectory() as folder:
        try:
            size = solve_parts(parts | {"load_path": parts["load_path"][:1]}, Path(folder)).setup.grid.size
        except (CaseError, GridEdgeError):
            size = (1.0, 1.0)
    return parts | {"grid": parts["grid"] | {"size": list(size)}}


def found_pressure(run: Run) -> np.ndarray[Any, Any]:
    return run.last.fields.pressure


@examples(6)
@given(st.floats(0.2, 0.95), decades(-3.0, 0.5), ratios, st.floats(0.0, 6.28))
def test_area_of_the_second_loop_is_its_work(share: float, friction: float, ratio: float, angle: float) -> None:
    """Equal bodies; by trapezoids of ten increments per half the area falls short by their second order."""
    force = share * friction * 400.0
    pull = {"Qx": force * math.cos(angle), "Qy": force * math.sin(angle)}
    pull = {name: value if abs(value) > 1e-12 * force else 0.0 for name, value in pull.items()}  # no load of 1e-300 N
    back, forth = {name: -value for name, value in pull.items()}, pull
    count = {"increments": 10}
    path = [{"P": 400.0}, pull | count, {"cycle": {"times": 2, "stages": [back | count, forth | count]}}]
    run = solved({"bodies": [elastic(ratio)] * 2, "friction": friction, "grid": {"points": 20}, "load_path": path})
    assert run is not None
    area = sum(
        0.5 * (getattr(before.summary, load) + getattr(after.summary, load)) * moved
        for before, after in pairwise(run.states[-21:])
        for load, moved in zip(LOADS, motion(before, after), strict=True)
    )
    work = run.end.work_total - run.states[-21].summary.work_total
    assert 0.9 * work <= area <= work * (1.0 + 1e-6) + 1e-12 * force


@examples(15)
@given(cases(), decades(-12.0, 6.0), decades(-9.0, 9.0), st.sampled_from([1e-13, 1e-9, 1e-6, 1e-3, 0.5]))
def test_anything_ends_certified_or_in_words(parts: Parts, friction: float, size: float, tolerance: float) -> None:
    """Beyond the ranges above the solver may give up, but only in words, in time, and without a warning."""
    wild = scaled(parts, size, 1.0 / size) | {"friction": friction, "solver": {"tolerance": tolerance}}
    try:
        solved(wild)
    except NotConvergedError as error:
        assert "nan" not in str(error)
        assert ";" in str(error)
    except OutOfTimeError:
        raise AssertionError("not done in time") from None


def mirrored(parts: Parts) -> Parts:
    """The case as seen in a mirror that turns y round."""
    path = [{name: -v if name in ODD_IN_Y else v for name, v in stage.items()} for stage in parts["load_path"]]
    surface = parts["surface"]
    if "ellipsoid" in surface:
        surface = {"ellipsoid": surface["ellipsoid"] | {"angle": -surface["ellipsoid"]["angle"]}}
    return parts | {"load_path": path, "surface": surface}


def scaled(parts: Parts, length: float, stress: float) -> Parts:
    """The case with all lengths and all stresses multiplied."""
    factors = dict.fromkeys(("Mx", "My", "Mz"), stress * length**3)
    factors |= dict.fromkeys(("P", "Qx", "Qy"), stress * length**2) | dict.fromkeys(LENGTHS, length)
    factors["young_modulus"] = stress

    def grown(key: str, item: Any) -> Any:
        if key == "size":
            return [length * side for side in item]
        if isinstance(item, dict) or (isinstance(item, list) and key != "points"):
            return times(item)
        return item * factors[key] if key in factors else item

    def times(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: grown(key, item) for key, item in value.items()}
        if isinstance(value, str):
            return value
        return [times(item) for item in value]

    return {key: value if key in ("friction", "solver") else times(value) for key, value in parts.items()}
