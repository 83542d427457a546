"""What is said of wear before a case is run."""

from __future__ import annotations

import pytest
from solving import DISSIMILAR, build

from fretsolve.errors import CaseError
from fretsolve.setup.problem_setup import set_up

WEAR = {"law": "energy", "alpha": 1e-7}


def test_pressing_alone_wears_only_unlike_bodies():
    path = [{"P": 400.0}, {"cycle": {"represents": 10, "stages": [{"P": 300.0}, {"P": 400.0}]}}]
    with pytest.raises(CaseError, match="the load path shears nothing, so that nothing wears; a stage that moves Qx"):
        set_up(build(grid={"points": 16}, wear=WEAR, load_path=path))
    assert set_up(build(grid={"points": 16}, wear=WEAR, load_path=path, bodies=DISSIMILAR)).model.has_shear
