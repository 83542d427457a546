"""Formulas of the case file."""

from __future__ import annotations

import numpy as np
import pytest

from fretsolve.case.expression import LONGEST, Expression
from fretsolve.case.quantities import QuantityError

X, Y = np.linspace(-1.0, 1.0, 5)[:, None], np.linspace(-0.5, 0.5, 3)[None, :]


def value(text: str) -> np.ndarray:
    found = Expression(text)(x=X, y=Y, r=np.hypot(X, Y))
    return np.broadcast_to(found, (5, 3))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("0.1", 0.1),
        ("1e-3 + 2E2", 200.001),
        ("0.1 + 0.2*(abs(y) < 0.1 mm)", 0.1 + 0.2 * (np.abs(Y) < 0.1)),
        ("(100um < r <= 0.5 mm) * 3", 3.0 * ((np.hypot(X, Y) > 0.1) & (np.hypot(X, Y) <= 0.5))),
        ("max(x, y)**2 - min(x, y)/2", np.maximum(X, Y) ** 2 - np.minimum(X, Y) / 2.0),
        ("-exp(-x) + tanh(pi*y)", -np.exp(-X) + np.tanh(np.pi * Y)),
    ],
)
def test_values(text, expected):
    assert value(text) == pytest.approx(np.broadcast_to(expected, (5, 3)), abs=1e-15)


def test_what_has_no_value_is_no_number():
    assert np.isinf(value("1/(x*0)")[0]).all()
    assert np.isnan(value("sqrt(x)")[0]).all()
    assert np.isinf(value("9**9**9**9")).all()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("__import__('os')", "is not allowed; numbers, "),
        ("x.real", "'x.real' is not allowed; numbers, "),
        ("(lambda: 1)()", "is not allowed"),
        ("[x for x in (1, 2)]", "is not allowed"),
        ("z + 1", "'z' is not allowed; numbers, .* and x, y, r, pi"),
        ("True", "is not allowed"),
        ("'a'*99", "is not allowed"),
        ("x and y", "is not allowed"),
        ("abs(x, y)", "abs takes 1 value"),
        ("abs(x=1)", "is not allowed"),
        ("0.1 +", "is not a formula; one such as"),
        ("", "is not a formula"),
        ("x\0", "is not a formula"),
        ("0.1*(r < 3 N)", "'3 N' is a force; a length such as '10 mm' is needed"),
        ("(" * 250, "is not a formula"),
        ("x" * (LONGEST + 1), "is too long"),
    ],
)
def test_anything_else_is_refused(text, message):
    with pytest.raises(QuantityError, match=message):
        Expression(text)
