"""Increments under friction with two coefficients, solved in scaled shear tractions and slips (`Orthotropy`)."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from fretsolve.errors import SlidingError
from fretsolve.increment.increment import IncrementSolver, Solved
from fretsolve.increment.working_state import InitialState
from fretsolve.model.load_path import Increment


class OrthotropicIncrementSolver(IncrementSolver):
    """Solves increments of a model with orthotropic friction; start and result are in true tractions and slips.

    The certificate is that of the scaled problem.
    """

    def solve(self, increment: Increment, start: InitialState) -> Solved:
        """Solve an increment from `start` and certify it; as `IncrementSolver.solve`."""
        scale = self.model.orthotropy
        assert scale is not None
        scaled_start = replace(
            start,
            shear=scale.inverse.times(start.shear),
            displacement=scale.times(start.displacement),
            rigid=scale.times_motion(start.rigid),
            elastic_slip=None if start.elastic_slip is None else scale.times(start.elastic_slip),
            mismatch=None if start.mismatch is None else scale.times(start.mismatch),
        )
        scaled = replace(increment, tangential=scale.scaled(increment.tangential))
        try:
            solved = super().solve(scaled, scaled_start)
        except SlidingError as error:
            # the loads in the message, and the limit in brackets, are the scaled ones
            loads = zip(("Qx", "Qy"), increment.tangential.imposed_resultant, strict=False)
            named = ", ".join(f"{name} = {load:.6g} N" for name, load in loads if load)
            carried = re.sub(r" \(.*?\)", "", error.message.partition(":")[2], count=1)
            error.message = f"gross slip under {named}:{carried}"
            raise
        solution, evidence = solved.solution, solved.evidence
        shear, slip = scale.times(solution.shear), scale.inverse.times(evidence.slip)
        resultants = np.concatenate([evidence.resultants[:3], self._examiner.tangential.resultants(shear)])
        true = replace(
            solution,
            shear=shear,
            displacement=scale.inverse.times(solution.displacement),
            previous_displacement=start.displacement,
            rigid=scale.inverse.times_motion(solution.rigid),
            motion=scale.inverse.times_motion(solution.motion),
        )
        return replace(solved, solution=true, evidence=replace(evidence, slip=slip, resultants=resultants))
