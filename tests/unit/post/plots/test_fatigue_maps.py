"""Maps of fatigue parameters."""

import h5py
import numpy as np
import pytest
from command_line import invoke, refused, result_of
from line_cases import LINE
from pictures import figure_texts
from small_cases import LOOP, write_case

from fretsolve import open_result
from fretsolve.errors import PictureError
from fretsolve.post.plots import fatigue_map

KEYS = "tension_limit=300 MPa,torsion_limit=190 MPa,young_modulus=200 GPa,poisson_ratio=0.3"
STEEL = """\
{tension_limit: 300 MPa, torsion_limit: 190 MPa, young_modulus: 200 GPa, poisson_ratio: 0.3, strain_life:
{strength: 900 MPa, strength_exponent: -0.09, ductility: 0.5, ductility_exponent: -0.6}}
"""


@pytest.fixture(scope="module")
def solved(tmp_path_factory):
    """A result with Findley's parameter, which is above its limit somewhere, and SWT's, which has none."""
    out = result_of(write_case(tmp_path_factory.mktemp("maps"), LOOP, "loop.yaml"), "--set", "friction=0.4")
    material = out.with_name("steel.yaml")
    material.write_text(STEEL)
    words = ("--material", material, "--criterion", "swt,findley", "-q")
    assert invoke("fatigue", out, *words).exit_code == 0
    return out


def test_section_and_layer_go_through_the_worst_place(solved):
    with h5py.File(solved.with_name("loop.fatigue.h5")) as file:
        x, y, depth = file["fatigue/body_2/findley"].attrs["worst_place"]
        used = file["fatigue/body_2/findley_utilisation"][()]
        normal = file["fatigue/body_2/findley_normal"][np.unravel_index(used.argmax(), used.shape)]
    with open_result(solved) as result:
        figure = fatigue_map(result, fields=["findley"])
    section, layer = figure.axes[:2]
    contact, worst, trace = section.lines
    np.testing.assert_allclose(worst.get_xydata(), [(x, depth)])
    np.testing.assert_allclose(layer.lines[0].get_xydata(), [(x, y)])
    along = np.diff(trace.get_xydata(), axis=0)[0]
    assert abs(along @ normal[[0, 2]]) < 1e-9 * np.linalg.norm(along)
    assert section.collections[0].norm.vmax == pytest.approx(used.max())
    # The bar of the contact is as wide as the contact, and ends inside the picture.
    touching = contact.get_xdata()[np.isfinite(contact.get_ydata())]
    with open_result(solved) as result:
        zone, row = result.field("zone"), int(np.abs(result.y - y).argmin())
    np.testing.assert_allclose(touching, result_x(solved)[zone[:, row] > 0], atol=1e-12)
    low, high = section.get_xlim()
    assert low < touching[0] or touching[-1] < high
    assert section.child_axes[0].get_ylabel().replace("\n", " ") == "Findley parameter over its limit"


def result_x(path):
    """The cells' middles along x."""
    with open_result(path) as result:
        return result.x


def test_lives_are_logarithmic_and_white_where_they_do_not_end(solved):
    with h5py.File(solved.with_name("loop.fatigue.h5")) as file:
        life = file["fatigue/body_2/swt_life"][()]
    assert np.isinf(life).any()
    with open_result(solved) as result:
        figure = fatigue_map(result, fields=["swt-life"])
    image = figure.axes[1].images[0]
    finite = np.isfinite(life[0])
    assert (np.ma.getmaskarray(image.get_array()) == ~finite.T).all()
    assert (image.norm.vmin, image.norm.vmax) == (life[0][finite].min(), life[0][finite].max())
    assert image.cmap.get_bad().tolist() == [1.0, 1.0, 1.0, 1.0]
    assert figure.axes[1].child_axes[0].get_ylabel() == "life by SWT (cycles)"
    assert "white: run-out" in figure_texts(figure)


def test_a_line_contact_shows_its_hot_spot_in_the_whole_contact(tmp_path):
    out = result_of(write_case(tmp_path, LINE, "line.yaml"))
    assert invoke("fatigue", out, "--material", KEYS, "--criterion", "swt", "-q").exit_code == 0
    with open_result(out) as result:
        figure, half = fatigue_map(result), float(result.history["contact_radius"][-1])
    spot, whole = figure.axes[:2]
    (frame,) = whole.patches
    assert (frame.get_x(), frame.get_x() + frame.get_width()) == pytest.approx(spot.get_xlim())
    assert frame.get_height() == pytest.approx(spot.get_ylim()[0])
    # The tension of body 2 is largest at its trailing edge, where the picture is small against the contact.
    assert spot.get_xlim()[0] < -half < spot.get_xlim()[1]
    assert np.ptp(spot.get_xlim()) < half
    assert whole.get_xlim()[0] < -half < half < whole.get_xlim()[1]
    assert spot.child_axes[0].get_ylabel().replace("\n", " ") == "SWT parameter (MPa)"


@pytest.mark.slow
def test_a_body_is_chosen_and_its_depth_points_away_from_the_contact(solved, tmp_path):
    both = solved.with_name("both.h5")
    both.write_bytes(solved.read_bytes())
    words = ("--material", KEYS, "--criterion", "findley", "--body", 1, "--body", 2, "-q")
    assert invoke("fatigue", both, *words).exit_code == 0
    with open_result(both) as result:
        upper, lower = (fatigue_map(result, body=body).axes[0] for body in (1, 2))
        everything = fatigue_map(result)
    labels = [axes.get_ylabel().replace("\n", " ") for axes in (upper, lower)]
    assert labels == ["depth (mm)", "depth (mm)"]  # on low panels
    assert upper.get_ylim() == lower.get_ylim()[::-1]
    assert upper.get_ylim()[1] > upper.get_ylim()[0] == 0.0
    titles = [axes.get_title() for axes in everything.axes if axes.get_title()]
    assert [title.split(",")[0] for title in titles] == ["body 2", "body 2", "body 1", "body 1"]
    message = "the file has no parameters of body 1, only of body 2"
    assert message in refused(2, "plot", solved, "fatigue-map", "--body", 1, "-o", tmp_path / "a.png")


def test_what_is_not_there_is_named(solved):
    with open_result(solved) as result, pytest.raises(PictureError, match="'crossland' is not in the file, which has"):
        fatigue_map(result, fields=["crossland"])
    other = solved.with_name("other.h5")
    other.write_bytes(solved.read_bytes())
    assert "there are no fatigue parameters in other.fatigue.h5; `fretsolve fatigue` writes" in refused(
        2, "plot", other, "fatigue-map"
    )
