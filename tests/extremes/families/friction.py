"""Indentation of dissimilar bodies with next to no friction, and with so much that all sticks."""

from __future__ import annotations

from solving import DISSIMILAR, LOAD

from .driving import Family, Parts, Probe, Run, by, led
from .limits import again, cattaneo_cells, of_bonded_punch, of_mindlin, off, spence_cells, worst
from .pairs import BONDED, FLAT_RIGID, elastic


def pressed(increments: int = 5, **parts: object) -> Parts:
    """An indentation in so many increments."""
    return led(by(increments, P=LOAD), bodies=DISSIMILAR) | parts


def of_frictionless(run: Run) -> float:
    """Approach and peak pressure against those without friction on the same cells."""
    free = again(run, friction=0.0).end
    return max(off(run.end.delta_z, free.delta_z), off(run.end.max_pressure, free.max_pressure))


def all_slips(run: Run) -> float:
    """Cells of the contact that stick, of all; Spence's stick zone is much smaller than a cell."""
    return run.end.stick_area / run.end.contact_area


def of_stuck(run: Run) -> float:
    """Approach against that of friction 10, where hardly anything slips."""
    return off(run.end.delta_z, again(run, friction=10.0).end.delta_z)


def work_share(run: Run) -> float:
    """Dissipated work over the work of the load, P delta_z; nothing slips, so there should be none."""
    return run.end.work_total / (run.end.P * run.end.delta_z)


NO_FRICTION = Family(
    "mode II, friction to 0",
    "friction 0 to 1e-3, beta 0.19 and 0.5",
    "frictionless; the stick zone vanishes (Spence)",
    tuple(
        Probe(
            f"{name} friction {mu:g}",
            pressed(bodies=bodies, friction=mu),
            worst(of_frictionless, all_slips),
            1e-6 + 2.0 * mu,
            quick=mu in (1e-12, 1e-3),
        )
        for name, bodies in (("unlike", DISSIMILAR), ("rigid on nu 0", FLAT_RIGID))
        for mu in (0.0, 1e-12, 1e-8, 1e-6, 1e-4, 1e-3)
    ),
)

SPENCE = Family(
    "mode II, stick radius",
    "friction 0.01 to 10, beta 0.19",
    "Spence's c, in cells",
    tuple(
        Probe(f"friction {mu:g}", pressed(20, friction=mu), spence_cells, 1.0, quick=mu in (0.01, 0.1, 10.0))
        for mu in (0.01, 0.03, 0.1, 0.3, 1.0, 10.0)
    ),
)

BONDED_PUNCH = Family(
    "mode II, friction to infinity: flat punch",
    "friction 1e2 to 1e6, beta 0.19 to 0.5",
    "bonded punch (Mossakovskii)",
    tuple(
        Probe(
            f"{name} friction {mu:g}",
            pressed(
                1, bodies=bodies, friction=mu, surface={"punch": {"radius": 0.3}}, grid={"points": 40, "size": 0.7}
            ),
            of_bonded_punch,
            0.01,
            quick=mu == 1e6,
        )
        for name, bodies in BONDED.items()
        for mu in (1e2, 1e4, 1e6)
    ),
)

BONDED_SPHERE = Family(
    "mode II, friction to infinity: sphere",
    "friction 1e2 to 1e6, beta 0.19 and 0.5",
    "friction 10, nearly bonded",
    tuple(
        Probe(f"{name} friction {mu:g}", pressed(bodies=bodies, friction=mu), of_stuck, 2e-3, quick=mu == 1e6)
        for name, bodies in (("unlike", DISSIMILAR), ("rigid on nu 0", FLAT_RIGID))
        for mu in (1e2, 1e4, 1e6)
    ),
)

NO_WORK = Family(
    "dissipated energy where everything sticks",
    "friction 1e3, 1e6",
    "none, of P delta_z or Q delta_x",
    (
        *(Probe(f"pressed, friction {mu:g}", pressed(friction=mu), work_share, 1e-6) for mu in (1e3, 1e6)),
        *(
            Probe(
                f"sheared, friction {mu:g}",
                led({"P": LOAD}, by(3, Qx=0.1 * LOAD), friction=mu),
                lambda run: run.end.work_total / (run.end.Qx * run.end.delta_x),
                1e-6,
            )
            for mu in (1e3, 1e6)
        ),
    ),
)

SCALED = Family(
    "mode I, friction over 18 decades",
    "friction 1e-12 to 1e6 at Q = mu P/2, equal bodies",
    "Cattaneo, Mindlin: delta_x, c in cells",
    tuple(
        Probe(
            f"nu {nu:g} friction {mu:g}",
            led({"P": LOAD}, by(2, Qx=0.5 * mu * LOAD), bodies=[elastic(nu)] * 2, friction=mu, coupling="none"),
            worst(of_mindlin, lambda run: 0.005 * cattaneo_cells(run)),
            5e-3,
            quick=mu in (1e-12, 1e6),
        )
        for nu in (0.0, 0.3)
        for mu in (1e-12, 1e-8, 1e-3, 1.0, 1e3, 1e6)
    ),
)

FAMILIES = (NO_FRICTION, SPENCE, BONDED_PUNCH, BONDED_SPHERE, NO_WORK, SCALED)
