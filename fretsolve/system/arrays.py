"""Array types, named once for the whole package."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.floating]
"""Floating point of either precision."""

DoubleArray = NDArray[np.float64]
ComplexArray = NDArray[np.complexfloating]
BoolArray = NDArray[np.bool_]
IndexArray = NDArray[np.intp]

Vector = NDArray[np.float64]
"""Three values, one per rigid mode."""
