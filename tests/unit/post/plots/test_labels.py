"""Kinds of pictures, and units on axes."""

from __future__ import annotations

import numpy as np

from fretsolve.post import plots
from fretsolve.post.plots.labels import readable


def test_no_module_hides_a_public_function() -> None:
    for kind in plots.KINDS.values():
        assert callable(kind.draw)  # imports its module
    assert [name for name in plots.__all__ if not callable(getattr(plots, name))] == ["KINDS"]


def test_units_keep_numbers_short() -> None:
    lengths = [readable("mm", values) for values in ([2e-3, -0.05, np.inf], 0.2, 5e-6, 0.0)]
    assert [(unit.text, unit.factor) for unit in lengths] == [("µm", 1e3), ("mm", 1.0), ("nm", 1e6), ("mm", 1.0)]
    assert (readable("rad", 1e-3).text, readable("N mm", 5.0).text, readable("mJ/mm^2", 1.0).text) == (
        "mrad",
        "N mm",
        "mJ/mm²",
    )
