"""The quick part of the families of extreme cases; ``benchmarks/extremes.py`` drives all of them."""

from __future__ import annotations

from pathlib import Path

import pytest
from families import FAMILIES
from families.driving import Probe, judge


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
    """Certified and near its limit in theory, or refused in words: see `families.driving`."""
    assert judge(probe, tmp_path).problem == ""


def test_every_family_has_a_quick_probe_and_no_label_twice() -> None:
    for family in FAMILIES:
        labels = [probe.label for probe in family.probes]
        assert len(set(labels)) == len(labels), family.name
        assert any(probe.quick for probe in family.probes), family.name
