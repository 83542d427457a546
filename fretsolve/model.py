"""What a case requires: which influence coefficients, which solves, and why. Decided here and nowhere else."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from fretsolve.case import ElasticBody
from fretsolve.components import TANGENTIAL
from fretsolve.materials import Compliances, compliances
from fretsolve.terms import Terms

if TYPE_CHECKING:
    from fretsolve.case import Body, Case

UNCOUPLED_BELOW = 1e-12
"""|Dundurs' constant| that counts as none: it is the rounding of equal elastic constants."""

TORSION = frozenset({"Mz", "phi_z"})


@dataclass(frozen=True)
class Decision:
    """Whether a part of the model is kept, and the reason in words."""

    part: str
    kept: bool
    reason: str


@dataclass(frozen=True)
class Model:
    """The least model that the case requires, or the one that it asks for.

    coupling: `none`, `tangential` or `full`, in the words of the case file; sheared: there is a shear to solve for;
    decisions: one per part of the model; warnings: where the case asks for less than it requires.
    """

    compliances: Compliances
    friction: float
    terms: Terms
    sheared: bool
    coupling: Literal["none", "tangential", "full"]
    decisions: tuple[Decision, ...]
    warnings: tuple[str, ...]

    @property
    def interacting(self) -> bool:
        """Whether pressure and shear do act on each other, not only may: coupling can be asked for equal bodies too."""
        return self.terms.coupled and _differ(self.compliances)


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
    coupled = case.coupling == "full" or (case.coupling == "auto" and dissimilar)
    sheared = friction > 0.0 and (bool(moved) or coupled)
    slip_is_stored = bool({"slip", "slip_path"} & set(case.output.fields))
    coupled = coupled and (sheared or slip_is_stored)
    cross = sheared and (
        case.coupling in ("tangential", "full") or (case.coupling == "auto" and (material.B != 0.0 or coupled))
    )
    terms = Terms(tangential=sheared or coupled, cross=cross or coupled, coupled=coupled)
    decisions = (
        Decision("normal problem", True, "the bodies are pressed together"),
        Decision("tangential problem", sheared, _why_sheared(friction, moved, coupled)),
        Decision("ux from qy, uy from qx", terms.cross, _why_cross(case.coupling, sheared, material.B, coupled)),
        Decision(
            "between pressure and shear", coupled, _why_coupled(case.coupling, beta, dissimilar, sheared, coupled)
        ),
    )
    name: Literal["none", "tangential", "full"] = "full" if coupled else "tangential" if cross else "none"
    warnings = _warnings(case.coupling, moved, friction, beta if dissimilar else 0.0, material.B)
    return Model(material, friction, terms, sheared, name, decisions, warnings)


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


def _why_cross(asked: str, sheared: bool, b: float, coupled: bool) -> str:
    if coupled and not sheared:
        return "comes with the coupling"
    if not sheared:
        return "no shear"
    if asked == "auto":
        return "Poisson's ratio links the directions" if b else "Poisson's ratio is 0 in both bodies"
    return f"as the case asks (coupling: {asked})"


def _why_coupled(asked: str, beta: float, dissimilar: bool, sheared: bool, coupled: bool) -> str:
    if asked == "full" and not coupled:
        return "asked for (coupling: full), but there is no shear and no slip is stored"
    if asked != "auto":
        return f"as the case asks (coupling: {asked})"
    if not dissimilar:
        return "Dundurs' constant is 0"
    constant = f"Dundurs' constant is {beta:.4g}"
    if sheared:
        return constant
    if coupled:
        return f"{constant}: pressure moves the frictionless surfaces"
    return f"{constant}, but there is no shear and no slip is stored"


def _warnings(asked: str, moved: list[str], friction: float, beta: float, b: float) -> tuple[str, ...]:
    """Where a case that asks for fewer terms than `auto` keeps gets a wrong answer."""
    if friction == 0.0 or asked in ("auto", "full"):
        return ()
    found = []
    if beta:
        found.append(
            f"coupling: {asked} leaves out what pressure and shear do to each other, but Dundurs' constant is"
            f" {beta:.4g}; with auto they are kept"
        )
    if asked == "none" and moved and b:
        if TORSION & set(moved):
            found.append(
                "coupling: none is wrong for torsion: without ux from qy and uy from qx it gives a radial shear that"
                " is not there; with auto they are kept"
            )
        else:
            found.append(
                "coupling: none leaves out ux from qy and uy from qx, which turn the shear off the load's direction;"
                " with auto they are kept"
            )
    return tuple(found)
