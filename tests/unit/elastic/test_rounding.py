from __future__ import annotations

from fretsolve.elastic.rounding import named_rounding


def test_the_longest_length_is_named():
    lengths = {"heights": 1e9, "delta_z": 1.0}
    assert named_rounding(1e-7, lengths) == "1e-07 mm, the rounding of heights (1e+09 mm) in double precision"
    assert named_rounding(1e-3, lengths) == ""
    assert named_rounding(float("nan"), lengths) == ""
