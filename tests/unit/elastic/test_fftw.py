"""pyFFTW is imported without Dask, which would cost every process half a second."""

from __future__ import annotations

from command_line import python


def test_dask_is_not_imported_and_can_be_later() -> None:
    code = "import sys; import fretsolve.simulation.simulation; print('dask' in sys.modules, 'pyfftw' in sys.modules)"
    assert python(code).split() == ["False", "True"]
