"""Which influence coefficients of the elastic operator are kept."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Terms:
    """Which influence coefficients are kept.

    tangential: shear to tangential displacement (ux from qx, uy from qy); cross: also ux from qy and uy from qx;
    coupled: pressure to tangential displacement and, where there is shear, shear to normal displacement.
    """

    tangential: bool
    cross: bool
    coupled: bool
