"""The notebook of the documents: it runs, and what it draws agrees with the closed form."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

NOTEBOOK = Path(__file__).parents[2] / "docs" / "notebook.ipynb"


@pytest.mark.slow
def test_notebook_runs_and_agrees_with_mindlin(capsys: pytest.CaptureFixture[str]) -> None:
    cells = [cell for cell in json.loads(NOTEBOOK.read_text("utf-8"))["cells"] if cell["cell_type"] == "code"]
    assert not any(cell["outputs"] for cell in cells)
    names: dict[str, Any] = {}
    for number, cell in enumerate(cells):
        exec(compile("".join(cell["source"]), f"cell {number}", "exec"), names)
    assert capsys.readouterr().out.count("Qx =") == len(names["states"])
    closed = names["first_loading"](36.0)
    reached = int(np.argmax(names["force"]))
    assert names["displacement"][reached] == pytest.approx(closed, rel=0.02)
    assert 0.0 < names["error"][reached] < 0.05 * closed
    assert len(names["axes"].lines) >= 4
