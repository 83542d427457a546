"""GMRES (Saad & Schultz, SIAM J. Sci. Stat. Comput. 7, 1986) for linear equations that are not symmetric."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fretsolve.system.arrays import FloatArray


def gmres(
    apply: Callable[[FloatArray, FloatArray], None], right: FloatArray, target: float, basis: FloatArray
) -> tuple[FloatArray, int]:
    """Return x with ``|right - A x| <= target`` and the number of iterations.

    apply: ``apply(v, out)`` writes A v; right: of any shape, which v, out and x share, overwritten; basis: array to
    work in, one vector of that shape more than there may be iterations.
    """
    length, most = float(np.linalg.norm(right)), len(basis) - 1
    if length <= target or most < 1:
        return np.zeros_like(right), 0
    hessenberg = np.zeros((most + 1, most))
    np.divide(right, length, out=basis[0])
    part = right
    first_unit = np.zeros(most + 1)
    first_unit[0] = length
    for k in range(most):
        # Arnoldi: the image of the last basis vector, made orthogonal to all of them
        image = basis[k + 1]
        apply(basis[k], image)
        for earlier in range(k + 1):
            hessenberg[earlier, k] = np.vdot(basis[earlier], image)
            image -= np.multiply(basis[earlier], hessenberg[earlier, k], out=part)
        hessenberg[k + 1, k] = grown = float(np.linalg.norm(image))
        # the combination of basis vectors with the least residual
        system = hessenberg[: k + 2, : k + 1]
        shares = np.linalg.lstsq(system, first_unit[: k + 2], rcond=None)[0]
        residual = float(np.linalg.norm(system @ shares - first_unit[: k + 2]))
        if residual <= target or grown <= 1e-14 * length:
            break
        image /= grown
    return np.tensordot(shares, basis[: k + 1], axes=1), k + 1
