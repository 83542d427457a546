"""The states of a cell are plain integers."""

from __future__ import annotations

import pytest

from fretsolve.result.state import ZONE_NAMES, Zone


@pytest.mark.parametrize(("zone", "name"), [(Zone.OPEN, "open"), (Zone.STICK, "stick"), (Zone.SLIP, "slip")])
def test_zones_are_plain_integers(zone: int, name: str) -> None:
    """NumPy would call Python for members of an enumeration, and lose an interrupt that comes meanwhile."""
    assert type(zone) is int
    assert ZONE_NAMES[zone] == name
