"""What the optional parts need, and how it is installed."""

from __future__ import annotations


def how_to_install(extra: str) -> str:
    """The command that installs an extra: fretsolve is installed from its sources."""
    return f"pip install '.[{extra}]' in a clone of fretsolve"
