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
        shear = scale.times(solved.shear)
        return replace(
            solved,
            shear=shear,
            displacement=scale.inverse.times(solved.displacement),
            previous_displacement=start.displacement,
            rigid=scale.inverse.times_motion(solved.rigid),
            motion=scale.inverse.times_motion(solved.motion),
            slip=scale.inverse.times(solved.slip),
            resultants=np.concatenate([solved.resultants[:3], self._verifier.tangential.resultants(shear)]),
        )
