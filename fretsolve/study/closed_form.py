"""Closed forms at the ends of the stages of a case, where they hold."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

from fretsolve.case import EllipsoidSurface, SphereSurface
from fretsolve.case.load_components import PAIRS, TANGENTIAL
from fretsolve.reference.closed_forms import (
    HertzContact,
    cattaneo_mindlin,
    full_slip_torque,
    hertz_elliptic,
    hertz_sphere,
    lubkin,
    mindlin_displacement,
)
from fretsolve.reference.cyclic_loading import SAME, TangentialForm, remembered
from fretsolve.study.quantity import Observable

if TYPE_CHECKING:
    from fretsolve.setup.problem_setup import ProblemSetup

Loads = Sequence[dict[str, float]]
Values = Iterator[tuple[str, float]]


def closed_form_values(setup: ProblemSetup) -> dict[Observable, float]:
    """Every value at the end of a stage that Hertz, Cattaneo and Mindlin, or Lubkin give for this very model.

    Hertz: a sphere or an ellipsoid under P, upright, without influence of shear on pressure. Cattaneo and Mindlin: a
    sphere under Qx or Qy at constant P, each traction acting on its own direction alone (coupling: none, or Poisson's
    ratios of 0). Lubkin: a sphere under Mz at constant P. Loads may go to and fro (Mindlin & Deresiewicz 1953).
    """
    loads = setup.load_path.imposed
    return {
        Observable(name, stage): value
        for stage in range(1, len(loads) + 1)
        for name, value in _at_end(setup, loads[:stage])
    }


def _at_end(setup: ProblemSetup, loads: Loads) -> Values:
    """Names and values after the last of `loads`."""
    yield from _hertz(setup, loads[-1])
    surface = setup.case.surface[0]
    if not isinstance(surface, SphereSurface) or surface.radius <= 0.0 or not _is_pressed(setup, loads[-1]):
        return
    sphere = hertz_sphere(loads[-1]["P"], surface.radius, setup.model.compliances.contact_modulus)
    if setup.model.friction > 0.0 and not _press_changes(loads):
        yield from _mindlin(setup, loads, sphere)
        yield from _lubkin(setup, loads, sphere)


def _hertz(setup: ProblemSetup, load: dict[str, float]) -> Values:
    if not _is_pressed(setup, load):
        return
    surface, modulus = setup.case.surface[0], setup.model.compliances.contact_modulus
    if isinstance(surface, SphereSurface):
        radii = surface.radius, surface.radius
    elif isinstance(surface, EllipsoidSurface):
        radii = surface.radius_x, surface.radius_y
    else:
        return
    if min(radii) <= 0.0:
        return
    ellipse = hertz_elliptic(load["P"], *radii, modulus)
    area = math.pi * ellipse.semi_axis_x * ellipse.semi_axis_y
    yield "delta_z", ellipse.delta_z
    yield "max_pressure", ellipse.max_pressure
    yield from _circle("contact", math.sqrt(area / math.pi))


def _mindlin(setup: ProblemSetup, loads: Loads, sphere: HertzContact) -> Values:
    """Under a force along x or along y."""
    friction, compliance = setup.model.friction, setup.model.compliances.tangential
    limit = friction * sphere.load
    for force, motion, across in (("Qx", "delta_x", "Qy"), ("Qy", "delta_y", "Qx")):
        path = _path(loads, force)
        alone = not any(map(any, (_path(loads, across), _path(loads, "Mz"))))
        if _linked(setup) or not alone or not any(path) or max(map(abs, path)) > limit:
            continue
        points = remembered(path, SAME * limit)
        form = TangentialForm(sphere, (0.0, 0.0), friction, compliance, (1.0, 0.0), points)
        yield motion, _superposed(points, lambda Q: mindlin_displacement(sphere, friction, Q, compliance))
        yield from _circle("stick", form.stick_ratio() * sphere.contact_radius)
        yield (
            "work_total",
            dissipated(path, lambda Q: cattaneo_mindlin(sphere, friction, Q, compliance).work_per_cycle),
        )


def _lubkin(setup: ProblemSetup, loads: Loads, sphere: HertzContact) -> Values:
    """Under a torque; without the influence across, bodies with Poisson's ratio above 0 do not turn like that."""
    friction, compliance = setup.model.friction, setup.model.compliances.torsional
    path, limit = _path(loads, "Mz"), full_slip_torque(sphere, friction) * (1.0 - SAME)
    alone = not any(map(any, (_path(loads, "Qx"), _path(loads, "Qy"))))
    whole = setup.model.terms.in_plane_coupling or setup.model.compliances.B == 0.0
    if not whole or not alone or not any(path) or max(map(abs, path)) > limit:
        return
    points = remembered(path, SAME * limit)
    form = TangentialForm(sphere, (0.0, 0.0), friction, compliance, None, points)
    yield "phi_z", _superposed(points, lambda Mz: lubkin(sphere, friction, Mz, compliance).phi_z)
    yield from _circle("stick", form.stick_ratio() * sphere.contact_radius)


def why_left_out(setup: ProblemSetup) -> str:
    """Why there is no closed form under tangential forces that would have one but for Poisson's ratio; or empty."""
    moved = {name for load in setup.load_path.imposed for name, value in load.items() if value}
    if not _linked(setup) or not moved & {"Qx", "Qy", "delta_x", "delta_y"}:
        return ""
    return (
        "with Poisson's ratios other than 0 shear along x moves the surfaces along y too, which Cattaneo and Mindlin"
        " neglect: they are exact with coupling: none only"
    )


def _linked(setup: ProblemSetup) -> bool:
    """Whether shear along x moves the surfaces along y."""
    return setup.model.terms.in_plane_coupling and setup.model.compliances.B != 0.0


def _path(loads: Loads, force: str) -> list[float]:
    """A tangential force at the end of each stage; infinite where its motion is imposed, but for 0 at the start."""
    motion = dict(PAIRS)[force]
    path: list[float] = []
    for load in loads:
        at_rest = load.get(motion) == 0.0 and not any(path)
        path.append(load.get(force, 0.0 if at_rest else math.inf))
    return path


def _is_pressed(setup: ProblemSetup, load: dict[str, float]) -> bool:
    """Whether P alone presses one body of a smooth shape, upright, and shear leaves the pressure as it is."""
    upright = load.get("phi_x", math.inf) == 0.0 and load.get("phi_y", math.inf) == 0.0
    apart = not setup.model.terms.normal_tangential_coupling
    return len(setup.case.surface) == 1 and apart and upright and load.get("P", 0.0) > 0.0


def _press_changes(loads: Loads) -> bool:
    """Whether P changes while or after the contact is sheared."""
    sheared = [index for index, load in enumerate(loads) if any(load.get(name) for name in TANGENTIAL)]
    if not sheared:
        return False
    return sheared[0] == 0 or any(load.get("P") != loads[-1]["P"] for load in loads[sheared[0] - 1 :])


def _circle(zone: str, radius: float) -> Values:
    yield f"{zone}_radius", radius
    yield f"{zone}_area", math.pi * radius**2


def _superposed(points: Sequence[float], on_loading: Callable[[float], float]) -> float:
    """Displacement after `points`: on first loading, then twice that of half of each branch (Masing)."""
    branches = [after - before for before, after in itertools.pairwise(points)]
    return sum(
        on_loading(branch) if index == 0 else 2.0 * on_loading(0.5 * branch) for index, branch in enumerate(branches)
    )


def dissipated(path: Sequence[float], per_cycle: Callable[[float], float]) -> float:
    """Work dissipated on a `path` of loads from 0; `per_cycle`: that of a full cycle between plus and minus a load.

    First loading takes a quarter of a cycle's, each later branch half of that of a cycle of half its length. A branch
    that closes a loop goes on as the one that the loop began from.
    """
    total, here, turned = 0.0, 0.0, [0.0]
    for load in path:
        if (load - here) * (here - turned[-1]) < 0.0:
            turned.append(here)
        while load != here:
            start, first = turned[-1], len(turned) == 1
            loop = math.inf if first else abs(start - turned[-2]) * (2.0 if len(turned) == 2 else 1.0)
            reached = load if abs(load - start) <= loop else start + math.copysign(loop, load - start)
            total += _on_branch(reached - start, first, per_cycle) - _on_branch(here - start, first, per_cycle)
            if reached != load:
                del turned[1 if len(turned) == 2 else -2 :]
            here = reached
    return total


def _on_branch(length: float, first: bool, per_cycle: Callable[[float], float]) -> float:
    return per_cycle(abs(length)) / 4.0 if first else per_cycle(abs(length) / 2.0) / 2.0
