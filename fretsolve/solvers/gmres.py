"""GMRES (Saad & Schultz, SIAM J. Sci. Stat. Comput. 7, 1986) for linear equations that are not symmetric.

SciPy's GMRES applies the operator once more per solve, and takes half a second to import.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fretsolve.system.arrays import FloatArray


def gmres(
    apply: Callable[[FloatArray], FloatArray], right: FloatArray, target: float, most: int
) -> tuple[FloatArray, int]:
    """Return x with ``|right - A x| <= target`` and the number of iterations, at most `most`.

    apply: returns A v; right: of any shape, which v, A v and x share.
    """
    length = float(np.linalg.norm(right))
    if length <= target or most < 1:
        return np.zeros_like(right), 0
    # pages of the basis that are not reached cost nothing
    basis, hessenberg = np.empty((most + 1, *right.shape)), np.zeros((most + 1, most))
    first_unit = np.zeros(most + 1)
    basis[0], first_unit[0] = right / length, length
    for k in range(most):
        # Arnoldi: the image of the last basis vector, made orthogonal to all of them
        image = apply(basis[k])
        for earlier in range(k + 1):
            hessenberg[earlier, k] = np.vdot(basis[earlier], image)
            image -= basis[earlier] * hessenberg[earlier, k]
        hessenberg[k + 1, k] = grown = float(np.linalg.norm(image))
        # the combination of basis vectors with the least residual
        system = hessenberg[: k + 2, : k + 1]
        shares = np.linalg.lstsq(system, first_unit[: k + 2], rcond=None)[0]
        residual = float(np.linalg.norm(system @ shares - first_unit[: k + 2]))
        if residual <= target or grown <= 1e-14 * length:
            break
        basis[k + 1] = image / grown
    return np.tensordot(shares, basis[: k + 1], axes=1), k + 1
