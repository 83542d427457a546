"""Which influence coefficients of the elastic operator are kept."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Terms:
    """tangential: ux from qx and uy from qy; in_plane_coupling: ux from qy and uy from qx as well;
    normal_tangential_coupling: ux, uy from p and, if there is shear, uz from qx, qy."""

    tangential: bool
    in_plane_coupling: bool
    normal_tangential_coupling: bool
