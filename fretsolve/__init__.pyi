"""The public functions for editors and type checkers, which do not see those that are imported on first use."""

from fretsolve.case.loading import case_from_dict as case_from_dict
from fretsolve.case.loading import load_case as load_case
from fretsolve.result import open_result as open_result
from fretsolve.simulation.accuracy.in_memory import run as run
from fretsolve.simulation.accuracy.in_memory import run_with_error_bars as run_with_error_bars

__version__: str
__all__ = ["__version__", "case_from_dict", "load_case", "open_result", "run", "run_with_error_bars"]
