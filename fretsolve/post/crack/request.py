"""Say which crack to look at, and check before a run that its result will allow it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from fretsolve.case.keys.output_spec import LIFE_CURVES, LifeCriterion
from fretsolve.case.models import Case
from fretsolve.errors import CaseError
from fretsolve.post.crack.place import CrackPlace, require_finite, require_inside, require_round
from fretsolve.post.fatigue.material import MaterialSource, placed
from fretsolve.post.fatigue.request import cycles_before, states_key
from fretsolve.post.stress.cycles import CycleChoice, require_states
from fretsolve.post.stress.influence import Body
from fretsolve.problem.setup.problem import ProblemSetup

KEY = ("output", "crack")


@dataclass(frozen=True)
class CrackRequest:
    """A crack to look at.

    at: its x (mm), or how to find it; body: by default 2, or 1 if that is rigid; criterion: of the cycles to a crack,
    by default one whose life curve the material has; final_length, thickness: in mm; cycles: that count. problem:
    makes the error of a key from the key and a message.
    """

    material: MaterialSource
    at: Literal["edge", "max"] | float = "edge"
    body: Body | None = None
    criterion: LifeCriterion | None = None
    final_length: float | None = None
    thickness: float | None = None
    cycles: CycleChoice = "last"
    problem: Callable[[str, str], CaseError] = lambda key, message: CaseError(message, (), f"--{key}")

    @property
    def last_length(self) -> float | None:
        """The length (mm) beyond which there is no crack: the final length, or the thickness of the body.

        Raises CaseError for a final length above the thickness.
        """
        final, thickness = self.final_length, self.thickness
        if final is not None and thickness is not None and final > thickness:
            message = f"{final:g} mm is more than the thickness {thickness:g} mm of the body"
            raise self.problem("final-length", f"{message}; a shorter length is needed")
        return thickness if final is None else final

    @property
    def life_criterion(self) -> LifeCriterion | None:
        """The criterion of the cycles to a crack, None if the material has no life curve."""
        curves = (name for name, key in LIFE_CURVES.items() if getattr(self.material.material, key) is not None)
        return self.criterion or next(curves, None)

    @property
    def cycles_key(self) -> str:
        """The key that chooses the cycles."""
        return "cycle" if isinstance(self.cycles, int | str) else "blocks"

    def require_curve(self) -> LifeCriterion:
        """Return the criterion. Raises CaseError for `at: max` if the material lacks its life curve."""
        criterion = self.life_criterion
        if criterion is None or getattr(self.material.material, LIFE_CURVES[criterion]) is None:
            needed = " or ".join(LIFE_CURVES.values() if criterion is None else [LIFE_CURVES[criterion]])
            message = f"max is where a fatigue parameter is largest, which needs {needed} of the material; it has none"
            raise self.problem("at", message)
        return criterion


def case_request(case: Case) -> CrackRequest:
    """Return what a case with `output.crack` asks for."""
    spec = case.output.crack
    assert spec is not None
    return CrackRequest(
        MaterialSource(spec.material, case.source, (*KEY, "material")),
        spec.at,
        spec.body,
        spec.criterion,
        spec.final_length,
        spec.thickness,
        spec.chosen,
        lambda key, message: case.source.problem(message, (*KEY, key.replace("-", "_"))),
    )


def require_crack(setup: ProblemSetup) -> None:
    """Raise CaseError, before the run, if the crack that a case asks for could not be looked at after it."""
    case, grid = setup.case, setup.grid
    request, surfaces = case_request(case), case.effective()["surface"]
    _ = request.last_length  # refuses one above the thickness
    criterion = request.require_curve() if request.at == "max" else request.life_criterion
    if criterion is not None and getattr(request.material.material, LIFE_CURVES[criterion]) is not None:
        body = case.bodies[(request.body or (1 if case.bodies[1] == "rigid" else 2)) - 1]
        assert body != "rigid"  # a case with such a body is refused
        request.material.with_elastic_constants(body.model_dump()).require((criterion,))
    with placed(lambda message: request.problem("at", message)):
        if request.at == "edge":
            require_round(surfaces)
        elif request.at != "max":
            require_inside(grid, request.at)
            require_finite(surfaces, grid, CrackPlace(request.at, 0.0, ""))
    with placed(lambda message: request.problem(request.cycles_key, message)):
        stored, cycles = cycles_before(setup, request.cycles)
    with placed(lambda message: case.source.problem(message, states_key(case))):
        for cycle in cycles:
            require_states(cycle, stored)
