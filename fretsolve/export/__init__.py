"""Turn a result into files for other programs and into text: ParaView (VTK, XDMF), spreadsheets (CSV), NumPy (npz).

A result and its chosen increments come in, files go out, written increment by increment; `text_report` prints.

    from fretsolve.export.vtk import write_vtk
    with fretsolve.open_result("case.h5") as result:
        write_vtk(result, result.steps, Path("case.pvd"))
"""

from __future__ import annotations

FORMATS = ("vtk", "xdmf", "csv", "npz")
"""The formats, by their names on the command line."""
