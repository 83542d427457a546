"""What a case requires: which influence coefficients, which solves, and why. Decided here and nowhere else."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from fretsolve.case import ElasticBody
from fretsolve.case.load_components import PAIRS, TANGENTIAL
from fretsolve.model.materials import Compliances, compliances
from fretsolve.model.term_errors import Drive, TermError, coupling_errors, cross_errors, negligible_coupling
from fretsolve.model.terms import Terms

if TYPE_CHECKING:
    from fretsolve.case import Body, Case

UNCOUPLED_BELOW = 1e-12
"""|Dundurs' constant| that counts as none: it is the rounding of equal elastic constants."""

TORSION = ("Mz", "phi_z")


Part = Literal[
    "normal problem",
    "tangential problem",
    "ux from qy, uy from qx",
    "between pressure and shear",
    "slip and work",
]

TAKES: dict[Part, str] = {
    "normal problem": "p, gap; uz from p",
    "tangential problem": "qx, qy; ux from qx, uy from qy",
    "ux from qy, uy from qx": "one coefficient for both",
    "between pressure and shear": "ux, uy from p, uz from qx, qy; both problems in turn",
    "slip and work": "slip, its path, work per area",
}
"""What a part takes where it is kept; nothing of it is allocated or computed where it is not."""


@dataclass(frozen=True)
class Decision:
    """Whether a part of the model is kept, the reason in words, and what it takes: unknowns, coefficients, fields."""

    part: Part
    kept: bool
    reason: str
    takes: str


@dataclass(frozen=True)
class Model:
    """The least model that the case requires, or the one that it asks for.

    coupling: `none`, `tangential` or `full`, in the words of the case file; has_shear: there is a shear to solve for;
    may_slip: there may be slip, with shear or without friction; else shear, slip and work are 0 and kept nowhere;
    decisions: one per part of the model; warnings: where the case asks for less than it requires.
    """

    compliances: Compliances
    friction: float
    terms: Terms
    has_shear: bool
    may_slip: bool
    coupling: Literal["none", "tangential", "full"]
    decisions: tuple[Decision, ...]
    warnings: tuple[str, ...]

    @property
    def coupled(self) -> bool:
        """Whether pressure and shear do act on each other, not only may: coupling can be asked for equal bodies too."""
        return self.terms.normal_tangential_coupling and _differ(self.compliances)


def _differ(material: Compliances) -> bool:
    """Whether pressure and shear act on each other between such bodies."""
    return abs(material.dundurs_constant) > UNCOUPLED_BELOW


def derive_model(case: Case) -> Model:
    """Decide from bodies, friction, loads and `coupling` what `case` needs."""
    material = compliances(*(_elastic(body) for body in case.bodies))
    friction = case.friction.coefficient
    moved = _moved_tangentially(case)
    beta = material.dundurs_constant
    dissimilar = _differ(material)
    matters = dissimilar and not (
        friction > 0.0 and negligible_coupling(material, friction, case.solver.tolerance)
    )
    coupled = case.coupling == "full" or (case.coupling == "auto" and matters)
    sheared = friction > 0.0 and (bool(moved) or coupled)
    slip_is_stored = bool({"slip", "slip_path"} & set(case.output.fields))
    coupled = coupled and (sheared or slip_is_stored)
    cross = sheared and (
        case.coupling in ("tangential", "full") or (case.coupling == "auto" and (material.B != 0.0 or coupled))
    )
    terms = Terms(tangential=sheared, in_plane_coupling=cross, normal_tangential_coupling=coupled)
    slides = sheared or coupled or bool(moved)
    reasons: dict[Part, tuple[bool, str]] = {
        "normal problem": (True, "the bodies are pressed together"),
        "tangential problem": (sheared, _why_sheared(friction, moved, coupled)),
        "ux from qy, uy from qx": (cross, _why_cross(case.coupling, sheared, material.B)),
        "between pressure and shear": (
            coupled,
            _why_coupled(case.coupling, beta, dissimilar, matters, sheared, coupled),
        ),
        "slip and work": (slides, _why_slides(sheared, slides, moved)),
    }
    decisions = tuple(Decision(part, kept, reason, TAKES[part]) for part, (kept, reason) in reasons.items())
    name: Literal["none", "tangential", "full"] = "full" if coupled else "tangential" if cross else "none"
    warnings = _warnings(case.coupling, moved, friction, material, matters)
    return Model(material, friction, terms, sheared, slides, name, decisions, warnings)


def _elastic(body: Body) -> ElasticBody | None:
    """The body as `compliances` wants it, None for a rigid one."""
    return body if isinstance(body, ElasticBody) else None


def _moved_tangentially(case: Case) -> list[str]:
    """Tangential components that some stage moves away from nothing, in the order of their first appearance."""
    named = [(name, value) for stage in case.stages() for name, value in stage.targets]
    return list(dict.fromkeys(n for n, value in named if n in TANGENTIAL and value != 0.0))


def _why_sheared(friction: float, moved: list[str], coupled: bool) -> str:
    if friction == 0.0:
        return "friction is 0, so there is no shear"
    if moved:
        return f"the load path moves {', '.join(moved)}"
    if coupled:
        return "pressure and shear act on each other: pressing alone may cause slip"
    return "no tangential load, and pressing alone causes no slip"


def _why_cross(asked: str, sheared: bool, b: float) -> str:
    if not sheared:
        return "no shear"
    if asked == "auto":
        return "Poisson's ratio links the directions" if b else "Poisson's ratio is 0 in both bodies"
    return f"as the case asks (coupling: {asked})"


def _why_slides(sheared: bool, slides: bool, moved: list[str]) -> str:
    if sheared:
        return "what shears may slip"
    if moved:
        return f"without friction all slips as the load path moves {', '.join(moved)}"
    return "pressure moves the frictionless surfaces" if slides else "nothing shears"


def _why_coupled(
    asked: str, beta: float, dissimilar: bool, matters: bool, sheared: bool, coupled: bool
) -> str:
    if asked == "full" and not coupled:
        return "asked for (coupling: full), but there is no shear and no slip is stored"
    if asked != "auto":
        return f"as the case asks (coupling: {asked})"
    if not dissimilar:
        return "Dundurs' constant is 0"
    constant = f"Dundurs' constant is {beta:.4g}"
    if not matters:
        return f"{constant}: what it does stays below solver.tolerance"
    if sheared:
        return constant
    if coupled:
        return f"{constant}: pressure moves the frictionless surfaces"
    return f"{constant}, but there is no shear and no slip is stored"


def _warnings(
    asked: str, moved: list[str], friction: float, material: Compliances, matters: bool
) -> tuple[str, ...]:
    """What a case that asks for fewer terms than `auto` keeps has to expect of them."""
    if friction == 0.0 or asked in ("auto", "full"):
        return ()
    found = []
    driven = _driven(moved)
    if matters:
        errors = [error for drive, motion in driven for error in coupling_errors(material, friction, drive, motion)]
        found.append(
            f"coupling: {asked} leaves out what pressure and shear do to each other: with Dundurs' constant"
            f" {material.dundurs_constant:.4g} and friction {friction:g} expect errors of about {_listed(errors)};"
            " with auto it is kept"
        )
    if asked == "none" and moved and material.B:
        errors = [error for drive, motion in driven for error in cross_errors(material, drive, motion)]
        found.append(
            f"coupling: none leaves out ux from qy and uy from qx: expect errors of about {_listed(errors)};"
            " with auto they are kept"
        )
    return tuple(found)


def _driven(moved: list[str]) -> list[tuple[Drive, str]]:
    """What moves the contact, and the displacement, or force, that follows of each component moved."""
    partner = {name: other for pair in PAIRS for name, other in (pair, pair[::-1])}
    driven: list[tuple[Drive, str]] = [("torque" if name in TORSION else "force", partner[name]) for name in moved]
    return driven or [("pressing", "")]


def _listed(errors: list[TermError]) -> str:
    """The largest error of each quantity."""
    largest: dict[str, TermError] = {}
    for error in errors:
        if error.quantity not in largest or error.share > largest[error.quantity].share:
            largest[error.quantity] = error
    return ", ".join(map(str, largest.values()))
