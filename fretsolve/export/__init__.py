"""Results for other tools: ParaView (VTK, XDMF), spreadsheets (CSV), NumPy (npz), written increment by increment."""

from __future__ import annotations

FORMATS = ("vtk", "xdmf", "csv", "npz")
"""In the words of the command line."""
