"""The parameters of a fit by their names, and the names that are refused."""

from __future__ import annotations

from pathlib import Path

import pytest
from fitting import FIT_CASE
from small_cases import write_case

from fretsolve.case.loading import read_case
from fretsolve.errors import CaseError
from fretsolve.sweep.fit.parameters import Parameter, read_parameters


def parameters(folder: Path, *names: str, text: str = FIT_CASE, overrides: tuple[str, ...] = ()) -> list[Parameter]:
    read = read_case(write_case(folder, text)).overridden(overrides)
    return list(read_parameters(names, read, read.case()))


def test_values_in_their_own_units(tmp_path: Path) -> None:
    found = parameters(tmp_path, "friction", "rig.stiffness_x", "bodies.0.young_modulus", "stage.1.P")
    assert [(one.start, one.unit) for one in found] == [(0.14, ""), (70.0, "kN/mm"), (200.0, "GPa"), (400.0, "N")]
    assert [one.key for one in found][1:] == [
        ("rig", "stiffness_x"),
        ("bodies", 0, "young_modulus"),
        ("load_path", 0, "P"),
    ]
    assert found[1].written(49.36680267, 6) == "49.3668 kN/mm"


def test_value_of_an_override_and_of_a_material(tmp_path: Path) -> None:
    text = FIT_CASE.replace("rig: {stiffness_x: 70 kN/mm}", "").replace("actuator_x", "delta_x")
    text = text.replace("{young_modulus: 200 GPa, poisson_ratio: 0.3}   #", "{material: Ti-6Al-4V}   #")
    overrides = ("rig.stiffness_x=8e4",)
    spring, modulus = parameters(tmp_path, "rig.stiffness_x", "bodies.0.young_modulus", text=text, overrides=overrides)
    assert (spring.start, spring.unit) == (8e4, "")
    assert 100e3 < modulus.start < 130e3
    assert modulus.unit == ""


@pytest.mark.parametrize(
    ("names", "said"),
    [
        ("frictoin", "--for frictoin: is no key of the case; did you mean 'friction'?"),
        ("rig.stifness_x", "--for rig.stifness_x: is no key of the case; did you mean 'rig.stiffness_x'?"),
        ("bodies.0.youngs", "--for bodies.0.youngs: is no key of the case; did you mean 'bodies.0.young_modulus'?"),
        ("bodies.5.young_modulus", "--for bodies.5.young_modulus: the list has no entry 5;"),
        (
            "interface.shear_compliance",
            "--for interface.shear_compliance: has no value in the case; a value to start from is needed, as --set"
            " interface.shear_compliance=VALUE with a unit",
        ),
        ("title", "--for title: is no property of the contact; a number in bodies, surface, friction, rig,"),
        ("coupling", "--for coupling: is no property of the contact; a number in bodies, surface, friction, rig,"),
        (
            "grid.points",
            "--for grid.points: is no property of the contact; a number in bodies, surface, friction, rig,",
        ),
        ("rig", "--for rig: holds several values; rig.stiffness_x is needed"),
        ("bodies.0", "--for bodies.0: holds several values; bodies.0.young_modulus, bodies.0.poisson_ratio is needed"),
        ("friction,friction", "--for friction: is given twice; once is enough"),
        ("stage.1.P,load_path.0.P", "--for load_path.0.P: is the same as stage.1.P; keep one of them"),
        ("stage.9.P", "--for stage.9.P: the load path has no stage 9; its stages are 1 to 2"),
    ],
)
def test_refused_names(tmp_path: Path, names: str, said: str) -> None:
    with pytest.raises(CaseError) as caught:
        parameters(tmp_path, *names.split(","))
    assert str(caught.value).startswith(said)


def test_values_that_are_text_or_no_start(tmp_path: Path) -> None:
    text = FIT_CASE.replace("{young_modulus: 200 GPa, poisson_ratio: 0.3}   #", "{material: Ti-6Al-4V}   #")
    with pytest.raises(CaseError, match=r"--for bodies.0.material: is 'Ti-6Al-4V' in the case; a number is needed"):
        parameters(tmp_path, "bodies.0.material", text=text)
    with pytest.raises(CaseError, match=r"--for friction: is 0 in the case; a value above 0 to start from is needed"):
        parameters(tmp_path, "friction", overrides=("friction=0",))
