"""The sweep that the tests of engines run."""

from __future__ import annotations

from pathlib import Path

import pytest
from sweeping import manifest_of

from fretsolve.sweep.manifest import Manifest


@pytest.fixture
def manifest(tmp_path: Path) -> Manifest:
    return manifest_of(tmp_path)
