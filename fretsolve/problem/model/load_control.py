"""Load control of three rigid modes: a resultant or a displacement is imposed on each, or a displacement through a rig.

Vectors of three follow the orders (delta_z, phi_x, phi_y) and (delta_x, delta_y, phi_z); resultants follow the orders
(P, Mx, My) and (Qx, Qy, Mz).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fretsolve.case.history import COMPONENTS, PAIRS
from fretsolve.problem.model.rig import Rig
from fretsolve.system.arrays import DoubleArray, Products, Vector


@dataclass(frozen=True)
class LoadControl:
    """forced: whether the resultant of each mode is imposed; values: the imposed resultants (N, N mm) or else
    displacements (mm, rad); three of each.

    compliance: of a rig in series, symmetric, (3, 3) (mm/N, rad/N, rad/(N mm)), None without one. A displacement is
    then imposed at the actuator, and the surfaces move by it less the compliance times the resultants.
    """

    forced: tuple[bool, ...]
    values: tuple[float, ...]
    compliance: Products | None = None

    def relative_to(self, rigid: Vector) -> LoadControl:
        """Return the same with imposed displacements counted from `rigid`."""
        counted = (v if f else v - float(r) for f, v, r in zip(self.forced, self.values, rigid, strict=True))
        return replace(self, values=(*counted,))

    def with_loads_scaled(self, factor: float) -> LoadControl:
        """Return the same with imposed resultants multiplied by `factor`."""
        scaled = (factor * v if f else v for f, v in zip(self.forced, self.values, strict=True))
        return replace(self, values=(*scaled,))

    def with_compliance(self, matrix: DoubleArray) -> LoadControl:
        """Return the same with a rig of this compliance (3, 3), as tuples, which compare; without one where it is 0."""
        one, two, three = matrix.tolist()
        return replace(self, compliance=((*one,), (*two,), (*three,)) if matrix.any() else None)

    @property
    def matrix(self) -> DoubleArray:
        """The compliance of the rig as an array (3, 3), 0 without a rig."""
        return np.zeros((3, 3)) if self.compliance is None else np.array(self.compliance)

    def displacement(self, resultants: Vector) -> Vector:
        """Return the imposed displacements of the surfaces, 0 where the resultant is imposed."""
        return self.imposed_displacement - self.given_way(resultants)

    def given_way(self, resultants: Vector) -> Vector:
        """Return by how much the rig gives way under `resultants`, (3,)."""
        return np.zeros(3) if self.compliance is None else self.matrix @ resultants

    def with_springs_at(self, resultants: Vector) -> LoadControl:
        """Return the control that imposes these resultants on the modes that give way."""
        if self.compliance is None:
            return self
        sprung = set(self.sprung_index)
        forced = tuple(forced or mode in sprung for mode, forced in enumerate(self.forced))
        values = (float(resultants[mode]) if mode in sprung else value for mode, value in enumerate(self.values))
        return LoadControl(forced, (*values,))

    @cached_property
    def sprung_index(self) -> list[int]:
        """Modes whose displacement is imposed through a rig that gives way."""
        return [] if self.compliance is None else [mode for mode in range(3) if any(self.compliance[mode])]

    @cached_property
    def forced_index(self) -> list[int]:
        """Modes whose resultant is imposed."""
        return [mode for mode, forced in enumerate(self.forced) if forced]

    @cached_property
    def fitted_index(self) -> list[int]:
        """Modes whose displacement the contact settles: with imposed resultants, or through a rig that gives way."""
        return sorted([*self.forced_index, *self.sprung_index])

    @cached_property
    def imposed_displacement(self) -> Vector:
        """The imposed displacements, of the actuator with a rig, 0 where the resultant is imposed; read-only."""
        return _read_only([0.0 if forced else value for forced, value in zip(self.forced, self.values, strict=True)])

    @cached_property
    def imposed_resultant(self) -> Vector:
        """The imposed resultants, 0 where the displacement is imposed; read-only."""
        return _read_only([value if forced else 0.0 for forced, value in zip(self.forced, self.values, strict=True)])


def _read_only(values: list[float]) -> Vector:
    vector: Vector = np.array(values, np.float64)
    vector.flags.writeable = False
    return vector


def load_controls(values: dict[str, float], rig: Rig | None) -> tuple[LoadControl, LoadControl, DoubleArray | None]:
    """Return what is imposed on the normal and on the tangential problem, and `coupling` as in `Increment`.

    Imposed loads bend the rig by a known part of the actuator's motion. That part is taken off.
    """
    forced = tuple(force in values for force, _ in PAIRS)
    imposed = [next(values[name] for name in names if name in values) for names in COMPONENTS]
    if rig is None:
        return LoadControl(forced[:3], (*imposed[:3],)), LoadControl(forced[3:], (*imposed[3:],)), None
    moved = np.array([actuator in values for *_, actuator in COMPONENTS])
    compliance = rig.compliance * moved[:, None]
    known = np.where(forced, imposed, 0.0)
    imposed = (np.array(imposed) - compliance @ known).tolist()
    compliance = compliance * moved
    coupling = compliance[:3, 3:]
    normal, tangential = (_control(forced, imposed, compliance, family) for family in (slice(0, 3), slice(3, 6)))
    return normal, tangential, coupling if coupling.any() else None


def _control(forced: tuple[bool, ...], imposed: list[float], compliance: DoubleArray, family: slice) -> LoadControl:
    return LoadControl(forced[family], (*imposed[family],)).with_compliance(compliance[family, family])
