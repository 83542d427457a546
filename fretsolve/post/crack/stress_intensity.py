"""Stress intensity of a crack from the surface of a half-plane, normal to it, from the stress along its line.

With sigma(z) and tau(z) the stresses xx and xz where the crack of length b will be, before it is there,

    K_I = 2/sqrt(pi b) int_0^b sigma(z) (1 + F(z/b))/sqrt(1 - (z/b)^2) dz,   K_II the same of tau,

with a polynomial F (Hartranft & Sih 1973) that makes K wrong by 3e-4 at most. With z = b sin(a) and a = (pi/2) t^2 the
root at the tip is gone, and stress that varies like the root of z at the surface, as at the edge of a contact, is
smooth in t. So Gauss's nodes in t converge fast. With 48 nodes the error of the stress of a contact with half-width a
is below 1e-6 for b up to 10 a and 2e-5 for 100 a; at 1000 a it is 1e-3 of the contact's part, which is small there.
"""

from __future__ import annotations

import math

import numpy as np

from fretsolve.system.arrays import DoubleArray

NODES = 48

WEIGHT_ERROR = 3e-4
"""Error of K over K that the polynomial leaves."""

METRES = 1e-3
"""Metres in a millimetre: lengths are in mm, stress intensities in MPa m^0.5."""


def free_surface(share: DoubleArray) -> DoubleArray:
    """Return F at shares z/b of the length."""
    square = share * share
    powers = 0.2945 + square * (-0.3912 + square * (0.7685 + square * (-0.9942 + square * 0.5094)))
    return np.asarray((1.0 - square) * powers)


def nodes(count: int = NODES) -> tuple[DoubleArray, DoubleArray]:
    """Return depths over the crack's length, and the weights of the stresses there.

    K in MPa m^0.5 is sqrt(b) times the sum of weights times stresses (MPa), with b in mm.
    """
    points, weights = np.polynomial.legendre.leggauss(count)
    t = 0.5 * (points + 1.0)
    share = np.sin(0.5 * math.pi * t * t)
    return share, math.sqrt(METRES * math.pi) * t * weights * (1.0 + free_surface(share))
