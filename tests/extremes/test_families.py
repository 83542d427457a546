"""The quick part of the families of extreme cases; ``benchmarks/extremes.py`` drives all of them."""

from __future__ import annotations

from pathlib import Path

import pytest
from families import FAMILIES
from families.driving import Family, Probe, in_single, judge


@pytest.mark.parametrize(
    "probe",
    [
        pytest.param(probe, id=f"{family.name}: {probe.label}")
        for family in FAMILIES
        for probe in family.probes
        if probe.quick
    ],
)
def test_ends_as_it_has_to(probe: Probe, tmp_path: Path) -> None:
    """Certified and near its limit in theory, or refused: see `families.driving`."""
    assert judge(probe, tmp_path).problem == ""


@pytest.mark.slow
@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.name)
def test_in_single_precision(family: Family, tmp_path: Path) -> None:
    """The first and the last of the quick ones: certified to 1e-5, or refused with the precision named."""
    quick = [probe for probe in family.probes if probe.quick]
    assert {judge(in_single(probe), tmp_path).problem for probe in (quick[0], quick[-1])} == {""}


def test_every_family_has_a_quick_probe_and_no_label_twice() -> None:
    for family in FAMILIES:
        labels = [probe.label for probe in family.probes]
        assert len(set(labels)) == len(labels), family.name
        assert any(probe.quick for probe in family.probes), family.name
