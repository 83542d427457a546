"""Cases that error bars and accuracies are tried on: parts of a case file each, and where their truth comes from.

Truth is a closed form where one is exact, and else a run with several times the points and the increments, corrected
for these. `CASES` were chosen by hand. `random_closed_forms` draws others, for accuracies that no finer run is exact
enough to judge. A case depends on its seed and its number alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from random import Random
from typing import Any

import fretsolve
from fretsolve.case.loading import case_model
from fretsolve.case.models import Case
from fretsolve.problem.model.materials import Compliances
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.problem.surface.edges import rounding
from fretsolve.reference.cyclic_loading import CyclicLoading
from fretsolve.reference.hertz import boussinesq_punch, hertz_elliptic, hertz_sphere, love_cone
from fretsolve.reference.tangential import cattaneo_mindlin, gross_slip_torque, lubkin
from fretsolve.result.state import CORRECTED
from fretsolve.simulation.error_bars.coarse_runs import FIRST_ORDER
from fretsolve.simulation.problem_setup import set_up

Truth = Mapping[int, Mapping[str, float]]
"""Values of the history at the end of stages (1-based)."""

LOAD, RADIUS = 400.0, 10.0


def hertz(pair: Compliances, load: float = LOAD, radius: float = RADIUS) -> Truth:
    """Return the values of a sphere, pressed."""
    found = hertz_sphere(load, radius, pair.contact_modulus)
    return {1: {"delta_z": found.delta_z, "max_pressure": found.max_pressure, "contact_radius": found.contact_radius}}


def elliptic(radius_x: float, radius_y: float, load: float = LOAD) -> Callable[[Compliances], Truth]:
    """Return the values of an ellipsoid, pressed."""

    def exact(pair: Compliances) -> Truth:
        found = hertz_elliptic(load, radius_x, radius_y, pair.contact_modulus)
        radius = found.contact_radius
        return {1: {"delta_z": found.delta_z, "max_pressure": found.max_pressure, "contact_radius": radius}}

    return exact


def driven(delta_z: float) -> Callable[[Compliances], Truth]:
    """Return the values of a sphere, pressed by displacement."""

    def exact(pair: Compliances) -> Truth:
        radius = math.sqrt(delta_z * RADIUS)
        load = 4.0 / 3.0 * pair.contact_modulus * radius**3 / RADIUS
        found = hertz_sphere(load, RADIUS, pair.contact_modulus)
        return {1: {"P": load, "max_pressure": found.max_pressure, "contact_radius": radius}}

    return exact


def cone(load: float, angle: float) -> Callable[[Compliances], Truth]:
    """Return the values of a cone, pressed."""

    def exact(pair: Compliances) -> Truth:
        found = love_cone(load, angle, pair.contact_modulus)
        return {1: {"delta_z": found.delta_z, "contact_radius": found.contact_radius}}

    return exact


def punch(pair: Compliances) -> Truth:
    """Return the values of a flat punch with a radius of 0.3 mm, pressed."""
    found = boussinesq_punch(LOAD, 0.3, pair.contact_modulus)
    return {1: {"delta_z": found.delta_z, "contact_radius": found.contact_radius}}


def mindlin(
    force: float, friction: float = 0.1, back: bool = False, load: float = LOAD, radius: float = RADIUS
) -> Callable[[Compliances], Truth]:
    """Return the values of a sphere, pressed and sheared; back: then unloaded, and sheared by the opposite force."""

    def exact(pair: Compliances) -> Truth:
        contact = hertz_sphere(load, radius, pair.contact_modulus)
        found = cattaneo_mindlin(contact, friction, force, pair.tangential)
        first = {
            "delta_z": contact.delta_z,
            "delta_x": found.delta_x,
            "stick_radius": found.stick_radius,
            "work_total": 0.25 * found.work_per_cycle,
        }
        values: dict[int, Mapping[str, float]] = {**hertz(pair, load, radius), 2: first}
        if back:
            unloaded = CyclicLoading(contact, (0.0, 0.0), friction, pair.tangential, (1.0, 0.0), (force, 0.0))
            values[3] = {"delta_x": unloaded.displacements()["delta_x"]}
            values[4] = {
                "delta_x": -found.delta_x,
                "stick_radius": found.stick_radius,
                "work_total": 0.75 * found.work_per_cycle,
            }
        return values

    return exact


def gross_slip(friction: float, motion: float) -> Callable[[Compliances], Truth]:
    """Return the values of a sphere moved by D, with gross slip from d on: mu P (D - 0.8 d) is dissipated."""

    def exact(pair: Compliances) -> Truth:
        contact = hertz_sphere(LOAD, RADIUS, pair.contact_modulus)
        limit = friction * LOAD
        last = 3.0 * limit * pair.tangential / (16.0 * contact.contact_radius)
        return {**hertz(pair), 2: {"Qx": limit, "work_total": limit * (motion - 0.8 * last)}}

    return exact


def torsion(
    torque: float, friction: float = 0.1, load: float = LOAD, radius: float = RADIUS
) -> Callable[[Compliances], Truth]:
    """Return the values of a sphere, pressed and twisted by a share of the torque of gross slip."""

    def exact(pair: Compliances) -> Truth:
        contact = hertz_sphere(load, radius, pair.contact_modulus)
        found = lubkin(contact, friction, torque * gross_slip_torque(contact, friction), pair.torsional)
        return {**hertz(pair, load, radius), 2: {"phi_z": found.phi_z, "stick_radius": found.stick_radius}}

    return exact


Row = Mapping[str, float]

CELLS_ON_EDGE = 4.0
"""Cells of a fine run on the radius of an edge, at least, for its largest pressure to be a truth."""


def corrected_run(setup: ProblemSetup) -> list[Row]:
    """Return the values of each increment; where the slip depends on the path, 2 Q_m - Q_(m/2) for what is corrected.

    The energy of the first stage is corrected by its own order. The first, the third and so on of the increments keep
    their values as run; all do if a stage has an odd number.
    """
    rows: list[Row] = [vars(state.summary) for state in fretsolve.run(setup)]
    counts = setup.load_path.counts
    if not setup.load_path.path_dependent or any(count % 2 for count in counts):
        return rows
    half = replace(setup, load_path=setup.load_path.with_counts(tuple(count // 2 for count in counts)))
    coarse = [vars(state.summary) for state in fretsolve.run(half)]
    energy = 0.0  # that the first stage has too much, by its order rather than by the first
    for place, row in enumerate(coarse):
        fine = 2 * place + 1  # all stages are halved
        if fine < counts[0]:
            energy = (rows[fine]["work_total"] - row["work_total"]) * (1.0 / (2.0**FIRST_ORDER - 1.0) - 1.0)
        corrected = {name: 2.0 * rows[fine][name] - row[name] for name in CORRECTED}
        rows[fine] = {**rows[fine], **corrected, "work_total": corrected["work_total"] + energy}
    return rows


def knows_peak(fine: ProblemSetup) -> bool:
    """Return whether the largest pressure of a fine run is one: no tip, sharp edge or rounding of few of its cells."""
    surfaces, side = fine.case.surface, max(fine.grid.dx, fine.grid.dy)
    radii = [0.0 if surface.kind == "cone" else rounding(surface) for surface in surfaces]
    return all(radius is None or radius >= CELLS_ON_EDGE * side for radius in radii)


STEEL = {"young_modulus": 200e3, "poisson_ratio": 0.3}
SIMILAR = [STEEL, STEEL]
DISSIMILAR = [{"young_modulus": 200e3, "poisson_ratio": 0.06}, {"young_modulus": 200e3, "poisson_ratio": 0.42}]
RIGID_ON_SOFT = ["rigid", {"young_modulus": 70e3, "poisson_ratio": 0.2}]
SPHERE = {"sphere": {"radius": 10.0}}


@dataclass(frozen=True)
class CalibrationCase:
    """parts: as in a case file; exact: closed forms from the pair's compliances, None where a fine run is needed.

    points, increments: how many times as many the fine run has.
    """

    name: str
    parts: Mapping[str, Any]
    exact: Callable[[Compliances], Truth] | None = None
    points: int = 4
    increments: int = 8

    def case(self) -> Case:
        """Return the case itself."""
        return self._with()

    def fine_case(self) -> Case:
        """Return the case on the same area with more points and increments, in each stage by the same factor."""
        setup = set_up(self.case())
        points = [self.points * count for count in setup.grid.shape]
        counts = setup.load_path.counts
        path = [
            {**dict(stage.targets), "increments": self.increments * count if count > 1 or self._slips else 1}
            for stage, count in zip(setup.case.stages(), counts, strict=True)
        ]
        grid = {"points": points, "size": list(setup.grid.size), "center": list(setup.grid.center)}
        return self._with(grid=grid, load_path=path)

    def _with(self, **parts: Any) -> Case:
        base = {"bodies": SIMILAR, "surface": SPHERE, "friction": 0.1}
        data = {**base, **self.parts, **parts}
        return case_model(data).model_validate(data)

    @property
    def _slips(self) -> bool:
        """Whether a stage of one increment takes more of them in the fine run."""
        return self.parts.get("friction", 0.1) > 0.0 and self.parts.get("bodies", SIMILAR) != SIMILAR


TORQUE = gross_slip_torque(hertz_sphere(LOAD, RADIUS, 109890.10989010989), 0.1)
"""At which the contact of two steel bodies turns."""


def _pressed(points: Any, **parts: Any) -> dict[str, Any]:
    return {"friction": 0.0, "grid": {"points": points}, "load_path": [{"P": LOAD}], **parts}


def _path(points: Any, *stages: Mapping[str, Any], **parts: Any) -> dict[str, Any]:
    return {"grid": {"points": points}, "load_path": list(stages), **parts}


def _alone(points: Any, *stages: Mapping[str, Any], **parts: Any) -> dict[str, Any]:
    """Return parts of a case without in-plane coupling, as the closed forms of shear have it."""
    return {**_path(points, {"P": LOAD}, *stages), "coupling": "none", **parts}


def _sheared(force: float, count: int) -> dict[str, Any]:
    return {"Qx": force, "increments": count}


def _pressing(count: int, load: float = LOAD) -> dict[str, Any]:
    return {"P": load, "increments": count}


def _unlike(points: Any, *stages: Mapping[str, Any], **parts: Any) -> dict[str, Any]:
    return _path(points, *stages, bodies=DISSIMILAR, **parts)


CASES = (
    CalibrationCase("Hertz, 24 points", _pressed(24), hertz),
    CalibrationCase("Hertz, 45 points", _pressed(45), hertz),
    CalibrationCase("Hertz, 96 points, wider", _pressed(96, grid={"points": 96, "size": 0.77}), hertz),
    CalibrationCase("Hertz, rigid on soft", _pressed(32, bodies=RIGID_ON_SOFT), hertz),
    CalibrationCase(
        "ellipse, radii 10 and 25 mm",
        _pressed(40, surface={"ellipsoid": {"radius_x": 10.0, "radius_y": 25.0}}),
        elliptic(10.0, 25.0),
    ),
    CalibrationCase(
        "ellipse, radii 5 and 100 mm",
        _pressed([32, 64], surface={"ellipsoid": {"radius_x": 5.0, "radius_y": 100.0}}),
        elliptic(5.0, 100.0),
    ),
    CalibrationCase(
        "cone", _pressed(48, surface={"cone": {"angle": 0.02}}, load_path=[{"P": 100.0}]), cone(100.0, 0.02)
    ),
    CalibrationCase(
        "punch, sharp edge", _pressed(40, surface={"punch": {"radius": 0.3}}, grid={"points": 40, "size": 0.72}), punch
    ),
    CalibrationCase(
        "Hertz, driven by delta_z",
        _pressed(24, grid={"points": 24, "size": 0.8}, load_path=[{"delta_z": 9e-3}]),
        driven(9e-3),
    ),
    CalibrationCase("Mindlin, 0.2 of sliding", _alone(32, _sheared(8.0, 2)), mindlin(8.0)),
    CalibrationCase("Mindlin, 0.5 of sliding, fine", _alone(96, _sheared(20.0, 2)), mindlin(20.0)),
    CalibrationCase(
        "Mindlin, 0.9, and back",
        _alone(48, _sheared(36.0, 4), _sheared(0.0, 4), _sheared(-36.0, 4)),
        mindlin(36.0, back=True),
    ),
    CalibrationCase("Mindlin, 0.985 of sliding", _alone(40, _sheared(39.4, 5)), mindlin(39.4)),
    CalibrationCase(
        "Mindlin, friction 0.6", _alone(28, _sheared(200.0, 3), friction=0.6), mindlin(200.0, friction=0.6)
    ),
    CalibrationCase(
        "gross slip, driven by delta_x", _alone(32, {"delta_x": 2.5e-3, "increments": 8}), gross_slip(0.1, 2.5e-3)
    ),
    CalibrationCase(
        "Lubkin, 0.7 of turning", _path(32, {"P": LOAD}, {"Mz": 0.7 * TORQUE, "increments": 2}), torsion(0.7)
    ),
    CalibrationCase(
        "Lubkin, 0.95 of turning", _path(48, {"P": LOAD}, {"Mz": 0.95 * TORQUE, "increments": 3}), torsion(0.95)
    ),
    CalibrationCase("I.2, cycle", _path(32, {"P": LOAD}, _sheared(36.0, 4), _sheared(-36.0, 8)), increments=2),
    CalibrationCase("I.3, 5 increments", _unlike(24, _pressing(5), _sheared(36.0, 5))),
    CalibrationCase("I.3, 10 increments, back", _unlike(32, _pressing(10), _sheared(36.0, 10), _sheared(0.0, 10))),
    CalibrationCase("I.3, 20 increments", _unlike(24, _pressing(20), _sheared(30.0, 20)), increments=4),
    CalibrationCase("I.3, 0.985 of sliding", _unlike(28, _pressing(6), _sheared(39.4, 6))),
    CalibrationCase("I.3, driven by delta_x", _unlike(28, _pressing(6), {"delta_x": 0.8e-3, "increments": 6})),
    CalibrationCase("II, friction 0.05", _unlike(32, _pressing(10), friction=0.05)),
    CalibrationCase("II, friction 0.2, 20 increments", _unlike(24, _pressing(20), friction=0.2), increments=4),
    CalibrationCase("II, rigid on soft, friction 0.3", _path(40, _pressing(8), friction=0.3, bodies=RIGID_ON_SOFT)),
    CalibrationCase("III.3", _unlike(32, _pressing(6), {"Mz": 4.0, "increments": 6})),
    CalibrationCase(
        "x, then y", _path(32, {"P": LOAD}, _sheared(24.0, 5), {"Qy": 28.0, "increments": 5}), increments=4
    ),
    CalibrationCase(
        "P and Q together", _path(32, {"P": 200.0}, {"P": 400.0, "Qx": 30.0, "increments": 10}), increments=4
    ),
    CalibrationCase(
        "P and Q together, dissimilar",
        _unlike(24, _pressing(6, 200.0), {"P": 400.0, "Qx": 24.0, "increments": 8}, {"P": 300.0, "increments": 4}),
    ),
    CalibrationCase(
        "ellipse, oblique, dissimilar",
        _path(
            [28, 36],
            _pressing(4),
            {"Qx": 15.0, "Qy": 22.0, "increments": 4},
            surface={"ellipsoid": {"radius_x": 10.0, "radius_y": 25.0, "angle": 0.5}},
            bodies=DISSIMILAR,
        ),
    ),
    CalibrationCase(
        "tilted, sheared",
        _path(40, {"P": LOAD, "Mx": 0.0, "My": 20.0}, _sheared(34.0, 3), grid={"points": 40, "size": 0.8}),
        increments=2,
    ),
    CalibrationCase(
        "punch, rounded edge, sheared",
        _path(
            32,
            {"P": 800.0},
            _sheared(60.0, 3),
            surface={"punch": {"radius": 0.3, "edge_radius": 0.1}},
            grid={"points": 32, "size": 0.72},
        ),
        increments=2,
    ),
    CalibrationCase(
        "crowned cylinder, sheared along y",
        _path(
            [24, 48],
            {"P": LOAD},
            {"Qy": 33.0, "increments": 3},
            surface={"cylinder": {"radius": 10.0, "axis": "y", "crown_radius": 80.0}},
        ),
        increments=2,
    ),
    CalibrationCase(
        "cone, sheared", _path(32, {"P": 100.0}, _sheared(8.0, 3), surface={"cone": {"angle": 0.02}}), increments=2
    ),
    CalibrationCase("partly unloaded under shear", _unlike(24, _pressing(6), _sheared(14.0, 4), _pressing(6, 200.0))),
    CalibrationCase(
        "torsion and shear", _path(28, {"P": LOAD}, {"Mz": 3.0, "increments": 4}, _sheared(24.0, 4)), increments=4
    ),
    CalibrationCase(
        "Hertz, 52 points, off the centre",
        _pressed(52, grid={"points": 52, "size": 0.75, "center": [0.01, 0.004]}),
        hertz,
    ),
    CalibrationCase(
        "ellipse, radii 8 and 12 mm",
        _pressed(30, surface={"ellipsoid": {"radius_x": 8.0, "radius_y": 12.0}}),
        elliptic(8.0, 12.0),
    ),
    CalibrationCase("Mindlin, 0.75 of sliding", _alone(36, _sheared(30.0, 3)), mindlin(30.0)),
    CalibrationCase("Lubkin, 0.85 of turning", _path(40, {"P": LOAD}, {"Mz": 0.85 * TORQUE}), torsion(0.85)),
    CalibrationCase(
        "I.2, driven by delta_x", _path(36, {"P": LOAD}, {"delta_x": 0.9e-3, "increments": 3}), increments=2
    ),
    CalibrationCase("I.3, 8 increments, reversed", _unlike(26, _pressing(8), _sheared(32.0, 8), _sheared(-32.0, 8))),
    CalibrationCase("II, friction 0.12", _unlike(38, _pressing(12), friction=0.12), increments=6),
    CalibrationCase(
        "III.3, rigid on soft",
        _path(30, _pressing(8), {"Mz": 12.0, "increments": 6}, friction=0.4, bodies=RIGID_ON_SOFT),
    ),
    CalibrationCase(
        "y, then x",
        _path(30, {"P": LOAD}, {"Qy": 30.0, "increments": 4}, {"Qx": 16.0, "Qy": 10.0, "increments": 6}),
        increments=4,
    ),
    CalibrationCase(
        "ellipse, pressed and turned, dissimilar",
        _unlike(
            [30, 26],
            _pressing(6),
            {"Mz": 3.0, "Qx": 10.0, "increments": 6},
            surface={"ellipsoid": {"radius_x": 16.0, "radius_y": 10.0}},
        ),
    ),
)
"""Cases chosen by hand."""


KINDS = ("sphere", "ellipsoid", "cone", "sheared", "sheared", "sheared back", "twisted", "twisted")


def random_closed_forms(seed: int, count: int) -> Iterator[CalibrationCase]:
    """Yield `count` cases."""
    for number in range(count):
        yield _draw(Random(f"closed {seed}-{number}"), f"closed {seed}-{number:02d}")


def _draw(random: Random, label: str) -> CalibrationCase:
    kind = random.choice(KINDS)
    radius = _log_uniform(random, 1.0, 50.0)
    load = float(f"{4.0 * radius**2 * random.uniform(0.5, 2.0):.4g}")
    body = {"young_modulus": _log_uniform(random, 3e3, 4e5), "poisson_ratio": round(random.uniform(0.0, 0.45), 2)}
    friction, share = _log_uniform(random, 0.02, 1.5), round(random.uniform(0.1, 0.97), 2)
    parts: dict[str, Any] = {"bodies": [body, body], "grid": {}, "friction": 0.0, "load_path": [{"P": load}]}
    match kind:
        case "sphere":
            parts["surface"] = {"sphere": {"radius": radius}}
            return CalibrationCase(f"{label} sphere", parts, partial(hertz, load=load, radius=radius))
        case "ellipsoid":
            other = float(f"{radius * _log_uniform(random, 1.2, 8.0):.4g}")
            parts["surface"] = {"ellipsoid": {"radius_x": radius, "radius_y": other}}
            return CalibrationCase(f"{label} ellipsoid", parts, elliptic(radius, other, load))
        case "cone":
            angle = round(random.uniform(0.01, 0.04), 4)
            parts["surface"] = {"cone": {"angle": angle}}
            return CalibrationCase(f"{label} cone", parts, cone(load, angle))
    parts |= {"surface": {"sphere": {"radius": radius}}, "friction": friction}
    words = f"{label} {kind}, friction {friction:g}, {share:g} of gross slip"
    if kind == "twisted":
        modulus = body["young_modulus"] / (2.0 * (1.0 - body["poisson_ratio"] ** 2))
        torque = share * gross_slip_torque(hertz_sphere(load, radius, modulus), friction)
        parts["load_path"] = [{"P": load}, {"Mz": torque}]
        return CalibrationCase(words, parts, torsion(share, friction, load, radius))
    force, back = share * friction * load, kind == "sheared back"
    forces = (force, 0.0, -force) if back else (force,)
    parts["coupling"] = "none"
    parts["load_path"] = [{"P": load}, *({"Qx": value} for value in forces)]
    return CalibrationCase(words, parts, mindlin(force, friction, back, load, radius))


def _log_uniform(random: Random, low: float, high: float) -> float:
    """Return a number between `low` and `high`, as likely in each decade, with three digits."""
    return float(f"{math.exp(random.uniform(math.log(low), math.log(high))):.3g}")
