"""The kinds of pictures."""

from __future__ import annotations

from fretsolve import plots


def test_no_module_hides_a_public_function() -> None:
    for kind in plots.KINDS.values():
        assert callable(kind.draw)  # imports its module
    assert [name for name in plots.__all__ if not callable(getattr(plots, name))] == ["KINDS"]
