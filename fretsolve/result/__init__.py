"""The result file and the state that it stores.

In come a `RunHeader` and a `State` per increment, out comes a result that survives a kill and can be read while it
grows. For example::

    with HistoryWriter.open(out, header) as writer:
        writer.append(state)
        writer.finish("complete")
    pressure = open_result(out).field("pressure")

The names below are imported on demand: solvers need `state` alone, and h5py takes time to load.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # imported on demand, see above
    from fretsolve.result.header import RunHeader
    from fretsolve.result.reader import Result, open_result
    from fretsolve.result.writer import HistoryWriter

__all__ = ["HistoryWriter", "Result", "RunHeader", "open_result"]

_MODULES = {"HistoryWriter": "writer", "Result": "reader", "RunHeader": "header", "open_result": "reader"}


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
