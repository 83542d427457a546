"""Ruiz's parameters: of a few states by hand, and of a line contact in closed form."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
from command_line import invoke, refused, result_of
from small_cases import write_case

from fretsolve.post.fatigue.ruiz import Sliding, ruiz_field

KEYS = "name=steel"


def test_tension_is_taken_along_the_slip() -> None:
    """Slip of 6 um from end to end along (0.6, 0.8), and a point that sticks."""
    along = np.array([0.6, 0.8])
    slip = np.zeros((3, 2, 2))
    slip[:, :, 0] = np.array([0.001, 0.007, 0.003])[:, None] * along
    shear = np.zeros((3, 2, 2))
    shear[:, :, 0] = [[30.0, 40.0], [-60.0, 80.0], [0.0, 10.0]]  # sizes 50, 100, 10
    stress = np.zeros((3, 6, 2))
    stress[:, 0], stress[:, 1], stress[:, 3] = 100.0, 50.0, 10.0
    stress[1] *= -1.0  # compression while the shear is largest
    tension = 0.36 * 100.0 + 0.64 * 50.0 + 2.0 * 0.48 * 10.0
    sliding = Sliding.of(slip, shear)
    np.testing.assert_allclose(sliding.amplitude, [0.003, 0.0], atol=1e-15)
    np.testing.assert_allclose(ruiz_field("ruiz-1", stress, sliding).value, [tension * 100.0 * 0.003, 0.0])
    np.testing.assert_allclose(ruiz_field("ruiz-2", stress, sliding).value, [tension * 50.0 * 0.003, 0.0])
    assert ruiz_field("ruiz-1", stress, sliding).units == "MPa^2 mm"
    assert (ruiz_field("ruiz-1", stress, None).value == 0.0).all()


LINE = """\
plane: strain
bodies:
  - {young_modulus: 200 GPa, poisson_ratio: 0.3}
  - {young_modulus: 200 GPa, poisson_ratio: 0.3}
surface: {cylinder: {radius: 10 mm}}
grid: {points: 320, size: 0.24 mm}
friction: 0.6
load_path:
  - {P: 100 N/mm}
  - {Qx: 36 N/mm, increments: 2}
  - cycle: {times: 1, stages: [{Qx: -36 N/mm, increments: 2}, {Qx: 36 N/mm, increments: 2}]}
"""


@pytest.fixture(scope="module")
def line(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return result_of(write_case(tmp_path_factory.mktemp("ruiz"), LINE))


def test_partial_slip_of_a_line_contact_in_closed_form(line: Path, tmp_path: Path) -> None:
    """At the ends of the cycle sxx = 2 mu p0 sqrt(x^2 - c^2)/a - p and q = mu p in the slip zone (Cattaneo, Mindlin).

    The slip amplitude is mu p0 c^2/(E* a) (t sqrt(t^2 - 1) - acosh t), t = |x|/c.
    """
    out = tmp_path / "f.h5"
    words = ("--material", KEYS, "--criterion", "ruiz_1,ruiz-2", "-q", "-o", out)
    done = invoke("fatigue", line, *words)
    assert done.exit_code == 0, done.stderr
    modulus, mu = 200e3 / (2.0 * (1.0 - 0.3**2)), 0.6
    a = np.sqrt(4.0 * 100.0 * 10.0 / (np.pi * modulus))
    p0, c = 200.0 / (np.pi * a), a * np.sqrt(1.0 - 0.6)
    with h5py.File(out) as file:
        group = file["fatigue/body_2"]
        x = group["x"][()]
        found = {name: group[name][0, :, 0] for name in ("ruiz_1", "ruiz_2")}
        assert not group["ruiz_1"][1:].any()
        assert "0 below, where nothing slips" in group["ruiz_1"].attrs["long_name"]
        worst, error = (group["ruiz_1"].attrs[key] for key in ("worst", "worst_error"))
        assert worst == found["ruiz_1"].max()
    slips = (abs(x) > c) & (abs(x) < a)
    at = abs(x[slips])
    pressure, t = p0 * np.sqrt(1.0 - (at / a) ** 2), at / c
    tension = 2.0 * mu * p0 * np.sqrt(at**2 - c**2) / a - pressure
    amplitude = mu * p0 * c**2 / (modulus * a) * (t * np.sqrt(t**2 - 1.0) - np.arccosh(t))
    expected = np.maximum(tension, 0.0) * mu * pressure * amplitude
    assert 0.0 < abs(worst - expected.max()) < error < 0.3 * worst
    for values in found.values():
        np.testing.assert_allclose(values[slips], expected, atol=0.025 * expected.max())
        assert values.max() == pytest.approx(expected.max(), rel=0.015)
        assert not values[abs(x) > a + 0.24 / 320].any()


def test_what_has_no_slip_is_refused(line: Path, tmp_path: Path) -> None:
    words = ("--material", KEYS, "--criterion", "ruiz-2", "-o", tmp_path / "none.h5")
    message = refused(2, "fatigue", line, *words, "--average", "point:20um")
    assert "ruiz-2 is a parameter of the surface, no average over depths; leave the average out" in message
    stored = "output={fields: [pressure, shear]}"
    case = write_case(tmp_path, LINE.replace("points: 320", "points: 32"))
    assert invoke("run", case, "-q", "--set", stored).exit_code == 0
    message = refused(2, "fatigue", case.with_suffix(".h5"), *words)
    assert "the result does not hold slip, which Ruiz's parameters need; output.fields in the case" in message
