"""Which influence coefficients of the elastic operator are kept."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Terms:
    """Which influence coefficients are kept.

    tangential: shear to tangential displacement (ux from qx, uy from qy); in_plane_coupling: ux from qy and uy from
    qx as well; normal_tangential_coupling: pressure to tangential displacement and, where there is shear, shear to
    normal displacement.
    """

    tangential: bool
    in_plane_coupling: bool
    normal_tangential_coupling: bool
