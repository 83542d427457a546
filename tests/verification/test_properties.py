"""Whatever the case, every increment that is solved is certified and obeys the laws; the rest is refused in words.

The grids are small and the tolerances those of users. `SlidingError` and the like are right answers here (a random
path soon pulls too hard); not to converge is not.
"""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from solving import LOAD, build

from fretsolve import run
from fretsolve.errors import ContactLostError, GridEdgeError, SlidingError
from fretsolve.result.state import Zone

RESIDUALS = ("residual_gap", "residual_stick", "residual_slip", "residual_bound", "residual_load")
REACH = 0.3
"""About the radius of the contacts (mm)."""

elastic = st.fixed_dictionaries(
    {"young_modulus": st.floats(7e4, 4e5), "poisson_ratio": st.one_of(st.just(0.3), st.floats(0.0, 0.5))}
)
bodies = st.one_of(
    elastic.map(lambda body: [body, body]),
    st.tuples(elastic, elastic).map(list),
    elastic.map(lambda body: ["rigid", body]),
    elastic.map(lambda body: [body, "rigid"]),
)
surfaces = st.one_of(
    st.just({"sphere": {"radius": 10.0}}),
    st.fixed_dictionaries(
        {
            "ellipsoid": st.fixed_dictionaries(
                {"radius_x": st.floats(6.0, 20.0), "radius_y": st.floats(6.0, 20.0), "angle": st.floats(0.0, 3.0)}
            )
        }
    ),
    st.just({"cone": {"angle": 0.03}}),
    st.just({"punch": {"radius": 0.35, "edge_radius": 0.2}}),
)
part = st.integers(-60, 60).map(lambda percent: percent / 100)


@st.composite
def cases(draw):
    friction = draw(st.one_of(st.just(0.0), st.floats(0.01, 1.0)))
    pull, twist, turn = friction * LOAD, friction * LOAD * REACH, 1e-3 * REACH
    moves = {
        "P": part.map(lambda share: LOAD * (1.0 + share)),
        "Qx": part.map(lambda share: pull * share),
        "Qy": part.map(lambda share: pull * share),
        "Mz": part.map(lambda share: twist * share * 0.5),
        "delta_x": part.map(lambda share: 4e-3 * share),
        "delta_y": part.map(lambda share: 4e-3 * share),
        "phi_z": part.map(lambda share: 1e-2 * share),
        "My": part.map(lambda share: LOAD * 0.05 * share),
        "phi_x": part.map(lambda share: turn * share),
    }
    counts = st.one_of(st.just("auto"), st.integers(1, 3))
    path = [{"P": LOAD, "increments": draw(st.integers(1, 3))}]
    some = st.lists(st.sampled_from(sorted(moves)), min_size=1, max_size=2, unique=True)
    for names in draw(st.lists(some, max_size=3)):
        if {"Mz", "phi_z"} <= set(names) or {"Qx", "delta_x"} <= set(names) or {"Qy", "delta_y"} <= set(names):
            names = names[:1]
        path.append({name: draw(moves[name]) for name in names} | {"increments": draw(counts)})
    points = [draw(st.integers(9, 20)), draw(st.integers(9, 20))]
    return build(
        bodies=draw(bodies),
        surface=draw(surfaces),
        friction=friction,
        grid={"points": points, "size": [1.1, 1.2]},
        coupling=draw(st.sampled_from(["auto", "auto", "none", "tangential", "full"])),
        load_path=path,
    )


def check(case, state):
    fields, summary = state.fields, state.summary
    friction, tolerance = case.friction.coefficient, case.solver.tolerance
    highest = max(summary.max_pressure, 1e-9)
    assert max(getattr(summary, name) for name in RESIDUALS) <= tolerance
    assert (fields.pressure >= 0.0).all()
    assert (np.hypot(*fields.shear) <= friction * fields.pressure + tolerance * highest).all()
    assert (fields.gap >= -tolerance * max(abs(summary.delta_z), np.ptp(fields.gap))).all()
    assert summary.work >= 0.0
    assert ((fields.zone == Zone.OPEN) == (fields.pressure == 0.0)).all()
    assert fields.slip_path.min() >= 0.0
    assert (np.hypot(*fields.slip) <= fields.slip_path * (1.0 + 1e-12) + 1e-300).all()


def check_loads(case, scene_loads, state):
    """Return what was imposed by the end of a stage is there."""
    carried = case.friction.coefficient * state.summary.P
    scales = {"P": LOAD, "Qx": carried, "Qy": carried, "Mz": carried, "My": LOAD, "Mx": LOAD}
    for name, value in scene_loads.items():
        rounding = 1e-16  # of displacements, which add up increment by increment
        assert abs(getattr(state.summary, name) - value) <= 2e-6 * scales.get(name, 0.0) + rounding


@settings(max_examples=25, deadline=None, derandomize=True)
@given(cases())
def test_solved_increments_obey_the_laws(case):
    stages = {stage.number: stage for stage in case.stages()}
    imposed: dict[str, float] = {}
    before = None
    try:
        for state in run(case):
            check(case, state)
            if before is not None and state.summary.stage != before.summary.stage:
                check_loads(case, imposed | dict(stages[before.summary.stage].targets), before)
            before = state
    except (SlidingError, ContactLostError, GridEdgeError) as error:
        assert error.key[0] in ("load_path", "grid")
        return
    assert before is not None
    assert before.summary.stage == len(stages)
    check_loads(case, dict(stages[len(stages)].targets), before)
