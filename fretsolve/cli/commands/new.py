"""Carry out ``fretsolve new``, ``fretsolve materials`` and ``fretsolve schema``, which help to write a case.

Functions here raise CaseError and FileError.
"""

from __future__ import annotations

import json
from importlib import resources
from pathlib import Path

from fretsolve.reference.materials import LIBRARY
from fretsolve.system import atomic_files
from fretsolve.system.files import require_ending, require_free, writing

HEIGHTS = "HEIGHTS"
"""Placeholder of a template for the name of its height map."""


def new_case(kind: str, out: Path) -> int:
    """Write the case and its height map, if it has one; return the exit code. Raises CaseError, FileError."""
    require_ending(out, "a case", ".yaml", ".yml")
    text = resources.files("fretsolve.case.templates").joinpath(f"{kind}.yaml").read_text(encoding="utf-8")
    files = {out: text}
    if HEIGHTS in text:
        heights = out.with_suffix(".heights.txt")
        files = {heights: _heights(), out: text.replace(HEIGHTS, json.dumps(heights.name, ensure_ascii=False))}
    require_free(*files, advice="it is not touched; choose another name with -o")
    with atomic_files.all_or_none() as making:
        for path, content in files.items():
            with making(path), writing(path):
                atomic_files.write_text(path, content, exclusive=True)
    print(*files, sep="\n")
    return 0


def _heights() -> str:
    """Return a self-affine surface of 1.024 mm as a matrix of text in um, the largest y first."""
    import numpy as np

    from fretsolve.case.keys.body_specs import RoughnessSurface  # loads pydantic, which other templates do without
    from fretsolve.problem.surface.roughness import waves_of

    surface = RoughnessSurface(hurst=0.8, rms_height=1e-4, rolloff=0.25, cutoff=0.064, span=1.024)
    points = 6.4e-3 * np.arange(160.0)
    lines = 1e3 * waves_of(surface).heights(points, points).T[::-1]
    return "\n".join(" ".join(f"{value:.4f}" for value in line) for line in lines) + "\n"


def print_schema(path: Path | None, *, overwrite: bool) -> int:
    """Print the JSON Schema of the case file, or write it and print its path; return the exit code."""
    if path is not None:
        require_ending(path, "a JSON Schema", ".json")
        require_free(path, overwrite=overwrite)
    from fretsolve.case.schema import case_schema  # loads pydantic, which `new` does without

    text = json.dumps(case_schema(), indent=2, ensure_ascii=False)
    if path is not None:
        with writing(path):
            atomic_files.write_text(path, text + "\n", exclusive=not overwrite)
    print(text if path is None else path)
    return 0


def print_materials() -> int:
    """Print the library of materials with the source of each; return the exit code."""
    width = max(len(one.name) for one in LIBRARY)
    print(f"{'material':{width}}  {'E (GPa)':>7}  {'nu':>5}  {'yield (MPa)':>11}  other names")
    for one in LIBRARY:
        limit = "" if one.yield_stress is None else f"{one.yield_stress:g}"
        others = ", ".join(one.others)
        line = f"{one.name:{width}}  {1e-3 * one.young_modulus:7g}  {one.poisson_ratio:5g}  {limit:>11}  {others}"
        print(f"{line.rstrip()}\n    {one.source}")
    return 0
