"""Write a result for other programs, ParaView (VTK, XDMF), spreadsheets (CSV) and NumPy (npz), or print it.

A result and its chosen increments come in, files go out, written increment by increment; `text_report` prints.

    from fretsolve.post.export.vtk import write_vtk
    with fretsolve.open_result("case.h5") as result:
        write_vtk(result, result.steps, Path("case.pvd"))
"""

from __future__ import annotations

FORMATS = {"vtk": ".pvd", "xdmf": ".xdmf", "csv": ".csv", "npz": ".npz", "heights": ".heights.hdf5"}
"""The formats by their names on the command line, with the endings of their files."""
