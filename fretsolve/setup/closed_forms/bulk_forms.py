"""Find the closed form that holds for a sphere under a tangential force and bulk stress together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from fretsolve.model.required_terms import Model
from fretsolve.reference.bulk_stress import SphereUnderBulk
from fretsolve.reference.hertz import HertzContact

ALIKE = 1e-3
"""Part of the mismatch along x by which that across it may differ from the one that the closed form needs."""


class NoClosedFormError(Exception):
    """There is none; the text says why."""


def sphere_under_bulk(
    model: Model, contacts: Sequence[HertzContact | None], loads: Sequence[Mapping[str, float]]
) -> tuple[int, SphereUnderBulk]:
    """Return the stage with the largest force, from 0, and the solution there.

    contacts: by Hertz; loads: what is imposed; both at the end of each stage. Raises NoClosedFormError.
    """
    bulk = model.bulk
    assert bulk is not None
    circles = [one for one in contacts if one is not None]
    if not circles or not circles[-1].is_circle or model.coupled:
        raise NoClosedFormError("it needs a sphere on a body of its own material")
    P = np.array([load.get("P", np.nan) for load in loads])
    force = np.array([load.get("Qx", np.nan) for load in loads])
    across = np.array([load.get("Qy", np.nan) for load in loads])
    xx, yy, xy = np.array([bulk.mismatch(load) for load in loads]).T
    stage = int(np.abs(np.nan_to_num(force)).argmax())
    if not np.nanmax(np.abs(force), initial=0.0) or np.nan_to_num(across, nan=1.0).any() or xy.any():
        raise NoClosedFormError("it needs a force Qx and no other, and no shear stress")
    moved = int(np.flatnonzero((force != 0.0) | (xx != 0.0))[0])
    if np.ptp(P[max(moved - 1, 0) :]) > ALIKE * P[stage]:
        raise NoClosedFormError("P changes under shear")
    proportion = force * xx[stage] - force[stage] * xx
    if np.abs(proportion).max() > ALIKE * abs(force[stage] * xx[stage]):
        raise NoClosedFormError("force and bulk stress are not in proportion")
    material = model.compliances
    try:
        hertz = contacts[stage]
        assert hertz is not None
        compliances = material.A, material.B
        found = SphereUnderBulk(hertz, model.friction, compliances, float(force[stage]), float(xx[stage]))
    except ValueError:
        raise NoClosedFormError("the stick zone reaches the edge of the contact") from None
    wanted = found.mismatch_across if model.terms.in_plane_coupling else 0.0
    if abs(yy[stage] - wanted) > ALIKE * abs(xx[stage]):
        needed, given = wanted / xx[stage], yy[stage] / xx[stage]
        raise NoClosedFormError(f"it needs a mismatch along y of {needed:.4g} times that along x, not {given:.4g}")
    return stage, found
