"""fretsolve: fretting contact of elastic half-spaces with friction, stick and slip."""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:  # without an import: the command line handles Ctrl-C only once this module is loaded
    from typing import Any

__version__ = "0.1.0"

_PUBLIC = {
    "case_from_dict": "fretsolve.case.loading",
    "load_case": "fretsolve.case.loading",
    "run": "fretsolve.simulation.accuracy.in_memory",
    "run_with_error_bars": "fretsolve.simulation.accuracy.in_memory",
    "open_result": "fretsolve.result",
}
__all__ = ["__version__", "case_from_dict", "load_case", "open_result", "run", "run_with_error_bars"]


def __getattr__(name: str) -> Any:
    """Import the public functions on first use, so that ``fretsolve --help`` loads no numerics (PEP 562)."""
    if name in _PUBLIC:
        import importlib

        return getattr(importlib.import_module(_PUBLIC[name]), name)
    raise AttributeError(f"module 'fretsolve' has no attribute {name!r}")


def __dir__() -> list[str]:
    """List the public functions, also before their first use."""
    return sorted({*globals(), *_PUBLIC})
