"""The least model that a case requires: the influence coefficients and the problems to solve, with reasons."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Literal

from fretsolve.case.dimensions import percent
from fretsolve.case.history import COMPONENTS, SHEARING, TANGENTIAL
from fretsolve.case.keys.unrolled_path import imposed_at_start
from fretsolve.case.models import Case
from fretsolve.problem.model.materials import BulkResponse, Compliances, Orthotropy, compliances
from fretsolve.problem.model.rig import Rig, rig_of
from fretsolve.reference.hertz import pressed_stick_ratio
from fretsolve.reference.tangential import spence_stick_ratio, torsion_error_without_in_plane_coupling

UNCOUPLED_BELOW = 1e-12
"""Bodies count as alike up to this |Dundurs' constant|, which is the rounding of equal elastic constants."""

LARGEST_COUPLING_CHANGE = 4.0
"""Limit of what the coupling changes in any cell: the shear over the largest friction limit, or the pressure over the
largest pressure, both divided by m max(mu, 1/mu) with m = |Dundurs' constant|. Measured for a sphere: 1.5 on 24 x 24
cells, 3 on 64 x 64. The change is largest at the edges, where the fields are steep, and grows slowly with the number of
cells."""

ModelPart = Literal[
    "normal problem",
    "tangential problem",
    "ux from qy, uy from qx",
    "between pressure and shear",
    "slip and dissipated energy",
]


@dataclass(frozen=True)
class Terms:
    """The influence coefficients of the elastic operator that are kept.

    tangential: ux from qx and uy from qy; in_plane_coupling: ux from qy and uy from qx as well;
    normal_tangential_coupling: ux, uy from p and, if there is shear, uz from qx, qy.
    """

    tangential: bool
    in_plane_coupling: bool
    normal_tangential_coupling: bool


@dataclass(frozen=True)
class Decision:
    """A part of the model: whether it is kept, why, and the unknowns, coefficients and fields that it takes.

    Where a part is not kept, nothing of what it takes is allocated or computed.
    """

    part: ModelPart
    kept: bool
    reason: str
    takes: str


@dataclass(frozen=True)
class Model:
    """The least model that the case requires, or the one that it asks for.

    has_shear: there is a shear traction to solve for; may_slip: slip is possible, under shear or without friction,
    otherwise slip and dissipated energy are 0 and not stored; coupling: the terms in the words of the case file; moved:
    the tangential components and bulk stresses that some stage moves away from 0; decisions: one per part of the model;
    warnings: of terms that the case leaves out although it needs them; bulk: the response to bulk stress, None where it
    never moves the surfaces apart; line: whether it is a line contact in plane strain; friction: the coefficient, or
    where it varies an estimate of the largest one, or of two the geometric mean; friction_evolves: with the slip so
    far; orthotropy: of the friction, None where it is alike in all directions.
    """

    compliances: Compliances
    friction: float
    terms: Terms
    has_shear: bool
    may_slip: bool
    coupling: Literal["none", "tangential", "full"]
    moved: tuple[str, ...]
    decisions: tuple[Decision, ...]
    warnings: tuple[str, ...]
    bulk: BulkResponse | None = None
    line: bool = False
    friction_evolves: bool = False
    orthotropy: Orthotropy | None = None
    rig: Rig | None = None
    at_start: dict[str, float] = field(default_factory=dict)

    @property
    def coupled(self) -> bool:
        """True if pressure and shear change each other. A case may ask for the coupling between equal bodies too."""
        return self.terms.normal_tangential_coupling and abs(self.compliances.dundurs_constant) > UNCOUPLED_BELOW


def derive_model(case: Case, largest_friction: float | None = None) -> Model:
    """Return the model that bodies, friction, loads and ``coupling`` of `case` require.

    largest_friction: the largest coefficient, where friction varies.
    """
    material = compliances(*case.bodies)
    if case.interface is not None:
        material = replace(material, layer_shear=case.interface.tangential, layer_normal=case.interface.normal)
    friction, asked = largest_friction, case.coupling
    if friction is None:
        assert isinstance(case.friction.coefficient, float)
        friction = case.friction.coefficient
    targets = [target for stage in case.stages() for target in stage.targets]
    bulk = _bulk_response(case)
    moves = SHEARING if bulk is not None else TANGENTIAL
    moved = tuple(dict.fromkeys(name for name, value in targets if name in moves and value))
    needed = _needs_coupling(material, friction, case.solver.tolerance)
    coupled = asked == "full" or (asked == "auto" and needed)
    has_shear = friction > 0.0 and (bool(moved) or coupled)
    coupled = coupled and (has_shear or bool({"slip", "slip_path"} & set(case.output.fields)))
    line = case.plane is not None
    in_plane = has_shear and (asked in ("tangential", "full") or (asked == "auto" and (material.B != 0.0 or coupled)))
    in_plane = in_plane and not line
    may_slip = has_shear or coupled or bool(moved)
    shear, slip = _why_shear(friction, moved, coupled), _why_slip(has_shear, may_slip, moved)
    directions = _why_in_plane(asked, has_shear, material.B) if not line else "in a line contact they do not act so"
    both = _why_coupled(asked, material, needed, has_shear, coupled)
    return Model(
        material,
        friction,
        Terms(tangential=has_shear, in_plane_coupling=in_plane, normal_tangential_coupling=coupled),
        has_shear,
        may_slip,
        "full" if coupled else "tangential" if in_plane else "none",
        moved,
        (
            Decision("normal problem", True, "the bodies are pressed together", "p, gap; uz from p"),
            Decision("tangential problem", has_shear, shear, "qx, qy; ux from qx, uy from qy"),
            Decision("ux from qy, uy from qx", in_plane, directions, "one coefficient for both"),
            Decision(
                "between pressure and shear", coupled, both, "ux, uy from p, uz from qx, qy; both problems in turn"
            ),
            Decision("slip and dissipated energy", may_slip, slip, "slip, slip path, dissipated energy"),
        ),
        tuple(_warnings(asked, moved, friction, material, needed, line)),
        bulk,
        line,
        case.friction.initial is not None,
        _orthotropy(case),
        rig_of(case),
        imposed_at_start(case.rig),
    )


def _orthotropy(case: Case) -> Orthotropy | None:
    if case.friction.pair is None:
        return None
    return Orthotropy.of(case.friction.pair, case.friction.angle or 0.0)


def _bulk_response(case: Case) -> BulkResponse | None:
    """Return the response of the surfaces to bulk stress, None where it never moves one over the other."""
    named = [[target for target in stage.targets if target[0].startswith("bulk_")] for stage in case.stages()]
    if not any(named):
        return None
    response, stresses = BulkResponse(case.bodies, plane_strain=case.plane is not None), dict[str, float]()
    for targets in named:
        stresses |= dict(targets)
        if response.mismatch(stresses).any():
            return response
    return None


def _needs_coupling(material: Compliances, friction: float, tolerance: float) -> bool:
    """Return whether pressure and shear change each other, with friction by more than `tolerance` in some cell.

    Pressing causes a shear of up to m times the pressure, which is m/mu of the friction limit. A tangential force
    shifts the contact by m mu of its radius, which shows most at its edge. Scalars of the history change by the square
    of these.
    """
    m = abs(material.dundurs_constant)
    if m <= UNCOUPLED_BELOW:
        return False
    return friction == 0.0 or LARGEST_COUPLING_CHANGE * m * max(friction, 1.0 / friction) > tolerance


def _why_shear(friction: float, moved: tuple[str, ...], coupled: bool) -> str:
    if friction == 0.0:
        return "friction is 0, so there is no shear"
    if moved:
        return f"the load path moves {', '.join(moved)}"
    if coupled:
        return "pressure and shear act on each other: pressing alone may cause slip"
    return "no tangential load, and pressing alone causes no slip"


def _why_in_plane(asked: str, has_shear: bool, b: float) -> str:
    if not has_shear:
        return "no shear"
    if asked == "auto":
        return "Poisson's ratio links the directions" if b else "Poisson's ratio is 0 in both bodies"
    return f"as the case asks (coupling: {asked})"


def _why_coupled(asked: str, material: Compliances, needed: bool, has_shear: bool, coupled: bool) -> str:
    constant = f"Dundurs' constant is {material.dundurs_constant:.4g}"
    if asked == "full" and not coupled:
        return "asked for (coupling: full), but there is no shear and no slip is stored"
    if asked != "auto":
        return f"as the case asks (coupling: {asked})"
    if abs(material.dundurs_constant) <= UNCOUPLED_BELOW:
        return "Dundurs' constant is 0"
    if not needed:
        return f"{constant}: its effect stays below solver.tolerance"
    if has_shear:
        return constant
    if coupled:
        return f"{constant}: pressure moves the frictionless surfaces"
    return f"{constant}, but there is no shear and no slip is stored"


def _why_slip(has_shear: bool, may_slip: bool, moved: tuple[str, ...]) -> str:
    if has_shear:
        return "shear may cause slip"
    if moved:
        return f"without friction the whole contact slips as the load path moves {', '.join(moved)}"
    return "pressure moves the frictionless surfaces" if may_slip else "no shear"


def _warnings(
    asked: str, moved: tuple[str, ...], friction: float, material: Compliances, needed: bool, line: bool
) -> Iterator[str]:
    """Warn of each term that the case leaves out and ``auto`` would keep, with the error where theory gives one."""
    if friction == 0.0 or asked in ("auto", "full"):
        return
    if needed:
        beta = material.dundurs_constant
        if line:
            ratio = percent(pressed_stick_ratio(friction, beta), 3)
            sticks = f"a cylinder under P alone sticks on {ratio} of the contact's width"
        else:
            ratio = percent(spence_stick_ratio(friction, beta), 3)
            sticks = f"a sphere under P alone sticks on {ratio} of the contact radius"
        yield (
            f"coupling: {asked} leaves out what pressure and shear do to each other: with Dundurs' constant {beta:.4g}"
            f" and friction {friction:g} {sticks} (Spence), here on all of it; coupling: auto keeps it"
        )
    if asked == "none" and moved and material.B and not line:
        error = ""
        if set(COMPONENTS[5]) & set(moved):
            share = torsion_error_without_in_plane_coupling(material.B, material.torsional)
            error = f": under torsion the ratio phi_z/Mz is {percent(share)} too small"
        yield f"coupling: none leaves out ux from qy and uy from qx{error}; coupling: auto keeps them"
