"""Stress intensity, arrest and life of cracks: certified values, closed forms, order in the cells and error bars."""

from __future__ import annotations

import math

import numpy as np
import pytest
from command_line import result_of
from line_cases import HERTZ, LINE, STEEL, A, modulus_of

from fretsolve import open_result
from fretsolve.case.keys.material_spec import Material, ParisLaw
from fretsolve.post.crack.analysis import crack_of
from fretsolve.post.crack.growth import GrowthRule, propagation_lives, threshold_of
from fretsolve.post.crack.place import at_edge, rows_of_contact
from fretsolve.post.crack.request import CrackRequest
from fretsolve.post.crack.stress_intensity import nodes
from fretsolve.post.crack.stress_line import stress_line
from fretsolve.post.fatigue.material import read_material
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.problem.model.grid import Grid
from fretsolve.reference.hertz import hertz_elliptic, hertz_sphere

P0 = HERTZ.max_pressure
BULK = 0.5904
CERTIFIED = {0.05: 0.33122, 0.2: 0.47769, 1.0: 0.64965}
"""K_I/(p0 sqrt(pi a)) over b/a: mu 0.75, Q/(mu P) 0.6, bulk 0.5904 p0 in phase, at the trailing edge."""

UNIT = P0 * math.sqrt(math.pi * 1e-3 * A)
LENGTHS = A * np.array(list(CERTIFIED))
EXACT = UNIT * np.array(list(CERTIFIED.values()))


class GivenTractions:
    """Tractions on strips of width h; has what `stress_line` reads of the history of a result."""

    plane_strain = True

    def __init__(self, cells, pressure, shear, bulk=0.0, center=0.0, width=A / 100):
        self.grid = Grid(cells, 1, width, width, center, 0.0)
        self.poisson_ratios = {1: 0.3, 2: 0.3}
        self.fields = {"p": pressure[:, None], "qx": shear[:, None]}
        self.bulk = np.array([bulk, 0.3 * bulk, 0.0])

    def extent(self, steps):
        return (slice(0, self.grid.nx), slice(0, 1)), tuple(self.fields)

    def read(self, step, window, names):
        return self.fields

    def bulk_stress(self, body, step):
        return self.bulk


def exact_tractions(cells, phase, sign=1.0):
    """Return Hertz's pressure and Hills and Nowell's shear as means over strips, `cells` of them per half-width.

    phase: share of a strip by which the edge of contact lies within it; sign: of the shear and the bulk stress.
    """
    edges = (np.arange(-math.ceil(1.2 * cells), math.ceil(1.2 * cells) + 2) - phase) / cells

    def mean(middle, half):
        x = np.clip((edges - middle) / half, -1.0, 1.0)
        return half**2 * cells * 0.5 * np.diff(x * np.sqrt(1.0 - x * x) + np.arcsin(x))

    pressure = mean(0.0, 1.0)
    shear = 0.75 * (pressure - mean(BULK / (4.0 * 0.75), math.sqrt(0.4)))
    middle = 0.5 * (edges[0] + edges[-1]) * A
    return GivenTractions(len(pressure), P0 * pressure, sign * P0 * shear, sign * BULK * P0, middle, A / cells)


def intensities(line, x, lengths):
    """Return K_I and K_II of the tractions, (2, steps, lengths)."""
    return np.stack([line.stress_intensity((x, 0.0), length)[:, 0] for length in lengths], axis=-1)


def of_exact_tractions(cells, phase, lengths=LENGTHS):
    return intensities(stress_line(exact_tractions(cells, phase), [0], 2), -A, lengths)[0, 0]


@pytest.mark.parametrize(
    ("stress", "certified"), [(lambda s: 1.0 + 0.0 * s, 1.12152), (lambda s: s, 0.682863), (np.square, 0.525488)]
)
def test_polynomial_stress(stress, certified):
    share, weights = nodes()
    found = math.sqrt(0.3) * float(weights @ stress(share))
    assert found / math.sqrt(math.pi * 0.3e-3) == pytest.approx(certified, rel=5e-4)


def test_enough_nodes():
    """The stress of cells at the edge of contact, as sharp as it gets, to 1e-6 up to ten half-widths."""
    line = stress_line(exact_tractions(100, 0.4), [0], 2)
    for ratio in (0.01, 0.3, 1.0, 10.0):
        found = line.stress_intensity((-A, 0.0), ratio * A)[0, 0, 0]
        share, weights = nodes(400)
        many = math.sqrt(ratio * A) * line.stress((-A, 0.0), ratio * A * share, ("xx",), weights[None])[0, 0, 0, 0]
        assert found == pytest.approx(many, rel=1e-6)


def test_exact_tractions_in_line_contact():
    np.testing.assert_allclose(of_exact_tractions(320, 0.0), EXACT, rtol=4e-4)
    np.testing.assert_allclose(of_exact_tractions(160, 0.4), EXACT, rtol=1e-3)


@pytest.mark.parametrize(("phase", "order"), [(0.0, 2.0), (0.4, 1.5)])
def test_order_in_the_cells(phase, order):
    """Order 2 where the edge of contact is that of a cell, else 1.5: the last cell is loaded as a whole."""
    exact = of_exact_tractions(1280, 0.0)
    errors = [np.abs(of_exact_tractions(cells, phase) - exact) for cells in (40, 160)]
    np.testing.assert_allclose(np.log2(errors[0][:2] / errors[1][:2]) / 2.0, order, atol=0.25)


@pytest.mark.parametrize("body", [1, 2])
def test_uniform_stress_alone(body):
    nothing = np.zeros(8)
    line = stress_line(GivenTractions(8, nothing, nothing, bulk=100.0), [0], body)
    K = intensities(line, 0.01, [0.05, 1.0])[:, 0]
    np.testing.assert_allclose(K[0], 1.12152 * 100.0 * np.sqrt(math.pi * np.array([0.05e-3, 1e-3])), rtol=1e-4)
    np.testing.assert_allclose(K[1], 0.0, atol=1e-12)


@pytest.mark.parametrize(("exponent", "tolerance"), [(3.0, 1e-4), (2.0, 1e-4), (8.0, 1e-4)])
def test_propagation_under_uniform_stress(exponent, tolerance):
    """N = int db/(C (1.12152 S sqrt(pi b))^m) has a closed form."""
    lengths = 1e-3 * 10.0 ** (np.arange(91) / 30)
    stress, end = 80.0, 0.777
    ranges = 1.12152 * stress * np.sqrt(math.pi * 1e-3 * lengths)
    found = propagation_lives(lengths, ranges[None], [1.0], ParisLaw(exponent=exponent, coefficient=1e-11), None, end)
    factor = 1e-11 * (1.12152 * stress * math.sqrt(math.pi)) ** exponent
    power = 1.0 - 0.5 * exponent
    b, last = 1e-3 * lengths[lengths < end], 1e-3 * end
    closed = np.log(last / b) if power == 0.0 else (last**power - b**power) / power
    np.testing.assert_allclose(found[: len(b)], closed / factor, rtol=tolerance)
    assert np.isnan(found[len(b) :]).all()


CASE = (
    LINE.replace("friction: 0.3", "friction: 0.75")
    .replace("points: 64", "points: {points}")
    .replace("size: 0.28 mm", "size: {size} mm")
    .replace("{Qx: 18 N/mm, increments: 4}", "{Qx: 45 N/mm, bulk_{body}: {xx: {bulk} MPa}, increments: 2}")
)


def crack_case(folder, points, size=0.28, body=2, back=""):
    text = CASE.replace("{points}", str(points)).replace("{size}", str(size)) + back
    text = text.replace("{body}", str(body)).replace("{bulk}", f"{BULK * P0:.6f}")
    (folder / "c.yaml").write_text(text)
    return result_of(folder / "c.yaml", "--overwrite")


def test_solved_line_contact(tmp_path):
    """256 points on 0.28 mm, 98 cells per half-width, meet 1e-3 at all three lengths, and so does body 1."""
    with open_result(crack_case(tmp_path, 256)) as result:
        tractions = TractionHistory(result)
        line = stress_line(tractions, result.steps, 2)
        place = at_edge(tractions, line, rows_of_contact(tractions, result.steps))
        assert place.x == pytest.approx(-A, rel=1e-4)
        K = intensities(line, place.x, LENGTHS)[:, -1]
    np.testing.assert_allclose(K[0], EXACT, rtol=1e-3)
    with open_result(crack_case(tmp_path, 256, body=1)) as result:
        tractions = TractionHistory(result)
        line = stress_line(tractions, result.steps, 1)
        place = at_edge(tractions, line, rows_of_contact(tractions, result.steps))
        assert place.x == pytest.approx(A, rel=1e-4)
        mirrored = intensities(line, place.x, LENGTHS)[:, -1]
    np.testing.assert_allclose(mirrored[0], EXACT, rtol=1e-3)
    np.testing.assert_allclose(mirrored[1], K[1], rtol=1e-3)


BACK = "  - {Qx: -45 N/mm, bulk_{body}: {xx: -{bulk} MPa}, increments: 2}\n"


@pytest.mark.parametrize(("points", "size"), [(24, 0.3), (32, 0.28), (48, 0.31), (64, 0.28), (96, 0.28), (200, 0.28)])
def test_error_bars_hold(tmp_path, points, size):
    """Bars of K_I and K_II hold at both ends of the cycle: reversed loads have the same tractions, reversed."""
    with open_result(crack_case(tmp_path, points, size, back=BACK)) as result:
        crack = crack_of(TractionHistory(result), CrackRequest(read_material("threshold_range=2.1 MPa m^0.5")))
    some = slice(None, None, 4)
    lengths, bar = crack.lengths[some], crack.K_error[some]
    assert crack.place.x == pytest.approx(-A, abs=0.02 * crack.cell)
    for step, sign in ((2, 1.0), (4, -1.0)):
        exact = intensities(stress_line(exact_tractions(1280, 0.0, sign), [0], 2), -A, lengths)[:, 0]
        assert (np.abs(crack.K[:, step, some] - exact) < bar).all()
    long = lengths > 3.0 * crack.cell
    assert (bar[long] < 0.12 * np.abs(crack.K[0, :, some]).max(axis=0)[long]).all()


def test_short_cracks_stop_and_long_ones_do_not():
    """El Haddad's threshold is that of long cracks, and the smooth specimen's for short ones."""
    material = Material(threshold_range=2.1, fatigue_range=248.0)
    threshold = threshold_of(material)
    short, long = threshold(np.array([1e-5, 1e5]))
    assert long == pytest.approx(2.1, rel=1e-4)
    assert short == pytest.approx(248.0 * math.sqrt(math.pi * 1e-8), rel=1e-3)


SPHERE = """\
bodies: [{young_modulus: 200 GPa, poisson_ratio: 0.3}, {young_modulus: 200 GPa, poisson_ratio: 0.3}]
surface: {sphere: {radius: 10 mm}}
grid: {points: {points}, size: 0.5 mm}
friction: 0.5
load_path: [{P: 100 N}, {Qx: 40 N, increments: 2}, {Qx: -40 N, increments: 2}]
"""


@pytest.mark.slow
def test_error_bars_hold_below_a_sphere(tmp_path):
    """At the edge of a sphere's contact on its middle row, in all states, against a finer grid."""
    found = []
    for points in (25, 28, 33, 40, 57, 161):
        (tmp_path / "s.yaml").write_text(SPHERE.replace("{points}", str(points)))
        with open_result(result_of(tmp_path / "s.yaml", "--overwrite")) as result:
            found.append(crack_of(TractionHistory(result), CrackRequest(read_material("threshold_range=2 MPa m^0.5"))))
    *coarse, fine = found
    for one in coarse:
        inside = (fine.lengths > one.lengths[0]) & (fine.lengths < one.lengths[-1])
        b = fine.lengths[inside]
        bar = np.interp(b, one.lengths, one.K_error) + np.interp(b, fine.lengths, fine.K_error)
        for K, right in zip(one.K.reshape(-1, len(one.lengths)), fine.K.reshape(-1, len(fine.lengths)), strict=True):
            assert (np.abs(np.interp(b, one.lengths, K) - right[inside]) < bar).all()


ELLIPSE = hertz_elliptic(2000.0, 5.0, 60.0, modulus_of([STEEL, STEEL]))
AREA = """\
bodies: [{young_modulus: 200 GPa, poisson_ratio: 0.3}, {young_modulus: 200 GPa, poisson_ratio: 0.3}]
surface: {surface}
grid: {grid}
friction: 0.5
load_path: [{P: {P} N}, {Qx: 50 N, bulk_2: {xx: 50 MPa}, increments: 2}]
"""


def place_of(folder, surface, grid, load=2000):
    """Return the rows of contact and the edge of a contact on an area, with the result's pressure and axes."""
    text = AREA.replace("{surface}", surface).replace("{grid}", grid).replace("{P}", str(load))
    (folder / "a.yaml").write_text(text)
    with open_result(result_of(folder / "a.yaml", "--overwrite")) as result:
        tractions = TractionHistory(result)
        rows = rows_of_contact(tractions, result.steps)
        place = at_edge(tractions, stress_line(tractions, result.steps, 2), rows)
        return place, rows[-1], tractions.pressure(2), tractions.grid


@pytest.mark.parametrize("points", [81, 96])
@pytest.mark.slow
def test_the_edge_of_a_contact_that_is_turned(tmp_path, points):
    """The ends of an ellipse turned by 40 degrees on its middle row, to 0.1 of a cell."""
    surface = "{ellipsoid: {radius_x: 5 mm, radius_y: 60 mm, angle: 40 deg}}"
    place, row, _, grid = place_of(tmp_path, surface, f"{{points: {points}, size: 2.4 mm}}")
    (across, along), angle = ELLIPSE.half_extent, math.radians(40.0)
    cosine, sine = math.cos(angle), math.sin(angle)
    # (c x + s y)^2/across^2 + (c y - s x)^2/along^2 = 1
    square = (cosine / across) ** 2 + (sine / along) ** 2
    mixed = 2.0 * cosine * sine * (across**-2 - along**-2) * row.y
    rest = row.y**2 * ((sine / across) ** 2 + (cosine / along) ** 2) - 1.0
    ends = np.sort(np.roots([square, mixed, rest]))
    np.testing.assert_allclose([row.left, row.right], ends, rtol=0, atol=0.1 * grid.dx)
    assert place.x in (row.left, row.right)
    assert row.half_width == pytest.approx(0.5 * (ends[1] - ends[0]), rel=0.02)


def test_the_edge_of_a_contact_off_the_centre(tmp_path):
    place, row, _, grid = place_of(
        tmp_path, "{sphere: {radius: 10 mm, center: [0.0837 mm, 0.0519 mm]}}", "{points: 96, size: 1.5 mm}", 1000
    )
    radius = hertz_sphere(1000.0, 10.0, modulus_of([STEEL, STEEL])).contact_radius
    half = math.sqrt(radius**2 - (row.y - 0.0519) ** 2)
    np.testing.assert_allclose([row.left, row.right], [0.0837 - half, 0.0837 + half], rtol=0, atol=0.02 * grid.dx)
    assert place.x in (row.left, row.right)


def test_the_edge_of_a_rough_contact(tmp_path):
    rough = "{roughness: {hurst: 0.8, rms_height: 0.3 um, rolloff: 0.3 mm, cutoff: 0.06 mm, seed: 3}}"
    place, row, pressure, grid = place_of(
        tmp_path, f"[{{sphere: {{radius: 10 mm}}}}, {rough}]", "{points: 96, size: 1.2 mm}", 200
    )
    loaded = grid.x[np.flatnonzero(pressure[:, np.abs(grid.y - row.y).argmin()])]
    assert -0.2 * grid.dx < loaded[0] - row.left < 0.84 * grid.dx
    assert -0.2 * grid.dx < row.right - loaded[-1] < 0.84 * grid.dx
    assert place.x in (row.left, row.right)
    assert place.y == row.y


def test_a_jump_at_the_threshold_is_exact():
    """Growth begins where a constant range exceeds the threshold, between two lengths: the life has a closed form."""
    lengths = 1e-3 * 10.0 ** (np.arange(91) / 30)
    slow, fast = np.full(91, 2.0), 3.0 * (lengths / 0.0345) ** 0.5
    law = ParisLaw(exponent=2.0, coefficient=1e-9)
    three = lambda b: np.full(np.shape(b), 3.0)  # noqa: E731
    found = propagation_lives(lengths, np.stack([slow + 2.0, fast]), [1.0, 1.0], law, three, 0.5)
    # up to 0.0345 mm 16, beyond it 16 + 9 b/0.0345, of C in two cycles
    slope, start, end = 9.0 / 0.0345, lengths[0], 0.5
    beyond = math.log((16.0 + slope * end) / 25.0) / slope
    assert found[0] == pytest.approx(2.0 * 1e-3 * ((0.0345 - start) / 16.0 + beyond) / 1e-9, rel=1e-6)


def test_a_crack_that_stops_has_no_end_of_life_unless_its_life_ends_before():
    """The range falls below the threshold at b = 0.1 mm; the bulk stress would begin a crack deeper in 1e9 cycles."""
    lengths = np.geomspace(1e-3, 10.0, 121)
    material = Material(threshold_range=2.0, fatigue_range=1e5, paris=ParisLaw(coefficient=1e-11, exponent=3.0))
    ranges = np.where(lengths < 0.1, 4.0, np.where(lengths < 1.0, 1.0, 10.0))[None]
    initiation = np.where(lengths < 0.5, 1e5, 1e9)
    stops = GrowthRule(material, (1.0,), final_length=8.0).growth(lengths, ranges, ranges[0], initiation)
    assert stops.arrest == pytest.approx(0.1, rel=0.1)
    assert (stops.life, stops.first) == (math.inf, None)
    assert stops.deeper == pytest.approx(1e9, rel=0.1)
    before = GrowthRule(material, (1.0,), final_length=0.05).growth(lengths, ranges, ranges[0], initiation)
    assert before.arrest == math.inf
    assert math.isfinite(before.life)
    assert before.deeper is None
