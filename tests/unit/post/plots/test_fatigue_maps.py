"""Maps of fatigue parameters."""

import h5py
import numpy as np
import pytest
from command_line import invoke, refused, result_of
from small_cases import LOOP, write_case

from fretsolve import open_result
from fretsolve.errors import PictureError
from fretsolve.post.plots import fatigue_map

KEYS = "tension_limit=300 MPa,torsion_limit=190 MPa,young_modulus=200 GPa,poisson_ratio=0.3"


@pytest.fixture(scope="module")
def solved(tmp_path_factory):
    """A result with Findley's parameter, which is above its limit somewhere, and SWT's, which has none."""
    out = result_of(write_case(tmp_path_factory.mktemp("maps"), LOOP, "loop.yaml"), "--set", "friction=0.4")
    words = ("--material", KEYS, "--criterion", "swt,findley", "-q")
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
    np.testing.assert_allclose(section.lines[0].get_xydata(), [(x, depth)])
    np.testing.assert_allclose(layer.lines[0].get_xydata(), [(x, y)])
    along = np.diff(section.lines[1].get_xydata(), axis=0)[0]
    assert abs(along @ normal[[0, 2]]) < 1e-9 * np.linalg.norm(along)
    assert section.collections[0].norm.vmax == pytest.approx(used.max())


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
    assert labels == ["depth in body 1 (mm)", "depth in body 2 (mm)"]
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
