"""Compute the surfaces of both bodies, deformed and moved, from the tractions of an increment."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretsolve.case.keys.body_specs import ElasticBody
from fretsolve.case.models import Case
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.errors import FretsolveError
from fretsolve.problem.model.materials import compliances
from fretsolve.problem.model.required_terms import Terms
from fretsolve.problem.surface.separation import separation
from fretsolve.result import Result
from fretsolve.system.arrays import BoolArray, DoubleArray


class FlatError(Exception):
    """The surfaces of a result cannot be computed; the text says why."""


@dataclass(frozen=True)
class BodySurface:
    """The deformed surface of a body.

    points: (3, nx, ny) in mm, z towards body 1. displacement: rigid plus elastic, (3, nx, ny) in mm; `points` include
    it. material: where the body has material, (nx, ny); elsewhere z is the z of its highest point.
    """

    name: str
    points: DoubleArray
    displacement: DoubleArray
    material: BoolArray


class DeformedSurfaces:
    """The deformed surfaces of a result's bodies; body 1 has all of the undeformed separation, each its own wear.

    Raises FlatError if the result lacks the shape of the surfaces or the tractions.
    """

    def __init__(self, result: Result):
        self._result = result
        case = result.case
        if case is None:
            raise FlatError("the case in the result is not one of this version")
        if min(len(result.x), len(result.y)) < 2:
            raise FlatError("the grid has only one cell across")
        missing = [name for name in ("pressure", "shear_x", "shear_y") if name not in result.fields]
        self._sheared = bool(np.any(result.history["max_shear"]))
        if missing and (self._sheared or "pressure" in missing):
            name = missing[0].removesuffix("_x")
            raise FlatError(f"the result holds no {name}; output.fields in the case chooses it")
        self._share = None if case.wear is None else case.wear.share
        if self._share is not None and "wear_depth" not in result.fields:
            raise FlatError("the result holds no wear_depth; output.fields in the case chooses it")
        try:
            self._separation = separation(case.surface, result.x, result.y)
        except FretsolveError as error:
            raise FlatError(str(error)) from error
        self._operators = _body_operators(case, result)

    def at(self, step: int) -> tuple[BodySurface, BodySurface]:
        """Return bodies 1 and 2 at increment `step`, one of `result.steps`. Raises FileError."""
        result, shape = self._result, self._separation.shape
        pressure = np.asarray(result.field("pressure", step), np.float64)
        shear = np.zeros((2, *shape))
        if self._sheared:
            shear[:] = result.field("shear", step)
        x, y = result.x[:, None], result.y[None, :]
        delta_x, delta_y, delta_z, phi_x, phi_y, phi_z = (
            float(result.history[name][step]) for name in ("delta_x", "delta_y", "delta_z", "phi_x", "phi_y", "phi_z")
        )
        rigid = np.empty((3, *shape))
        rigid[0], rigid[1], rigid[2] = delta_x - phi_z * y, delta_y + phi_z * x, -(delta_z + phi_x * y + phi_y * x)
        elastic_1, elastic_2 = (_elastic(operator, pressure, shear) for operator in self._operators)
        elastic_1[:2] *= -1.0  # the operator's shear traction acts on body 2
        elastic_2[2] *= -1.0
        upper, lower = self._separation, np.zeros(shape)
        if self._share is not None:
            depth = np.asarray(result.field("wear_depth", step), np.float64)
            upper, lower = upper + self._share[0] * depth, -self._share[1] * depth
        return (_displaced("body 1", result, upper, rigid + elastic_1), _displaced("body 2", result, lower, elastic_2))


def _body_operators(case: Case, result: Result) -> list[ElasticOperator | None]:
    """Return the operator of each body alone, with the terms that the case keeps; None for a rigid body."""
    terms = Terms(True, case.coupling != "none", case.coupling in ("auto", "full"))
    shape = len(result.x), len(result.y)
    spacing = float(result.x[1] - result.x[0]), float(result.y[1] - result.y[0])
    first, second = (body if isinstance(body, ElasticBody) else None for body in case.bodies)
    team = ThreadTeam()  # both can use it, as they run one after the other
    return [
        ElasticOperator(shape, spacing, compliances(*pair), terms, team) if any(pair) else None
        for pair in ((first, None), (None, second))
    ]


def _elastic(operator: ElasticOperator | None, pressure: DoubleArray, shear: DoubleArray) -> DoubleArray:
    """Return (ux, uy, uz) of the operator, (3, nx, ny)."""
    displacement = np.zeros((3, *pressure.shape))
    if operator is not None:
        operator.all(pressure, shear, displacement[2], displacement[:2])
    return displacement


def _displaced(name: str, result: Result, height: DoubleArray, displacement: DoubleArray) -> BodySurface:
    material = np.isfinite(height)
    points = np.empty_like(displacement)
    points[0], points[1], points[2] = result.x[:, None], result.y[None, :], height
    points += displacement
    points[2][~material] = points[2].max(where=material, initial=-np.inf) if material.any() else 0.0
    return BodySurface(name, points, displacement, material)
