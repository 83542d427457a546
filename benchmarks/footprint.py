"""Size of the installed package and processor time of its start, bare and with each extra.

``python benchmarks/footprint.py`` makes an environment per extra and prints a table for docs/performance.md; it
needs an index of packages, and some minutes. ``python benchmarks/footprint.py --older CLONE`` compares the start with
that of an older clone in the environment at hand, both in turns and without numba.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

ROOT = Path(__file__).parents[1]
EXTRAS = ("", "fast", "plot", "xarray", "scale")
ROUNDS, ROUNDS_IN_TURNS = 3, 10

CASE = str(ROOT / "cases" / "mode1_similar.yaml")
SMALL = ("--set", "grid.points=32", "--set", "expect=[]")

STARTS = {
    "`--help`": ("-m", "fretsolve", "--help"),
    "`validate`": ("-m", "fretsolve", "validate", CASE),
    "`import fretsolve; fretsolve.run`": ("-c", "import fretsolve; fretsolve.run"),
}
STARTS_IN_TURNS = STARTS | {
    "`run`, 32 x 32 points": ("-m", "fretsolve", "run", CASE, *SMALL, "-q", "-o", "out.h5", "--overwrite")
}


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--older", type=Path, metavar="CLONE", help="compare with this clone, in turns")
    older = parser.parse_args().older
    if older is not None:
        compare(older.resolve())
        return
    print(f"| installed | MB | {' | '.join(f'{name}, s' for name in STARTS)} |")
    print("| --- | --- |" + " --- |" * len(STARTS))
    for extra in EXTRAS:
        with tempfile.TemporaryDirectory() as folder:
            python = installed(Path(folder), extra)
            size = megabytes(Path(folder))
            times = " | ".join(f"{least(python, words, folder):.2f}" for words in STARTS.values())
        print(f"| {f'fretsolve[{extra}]' if extra else 'fretsolve'} | {size:.0f} | {times} |", flush=True)


def compare(older: Path) -> None:
    """Print the processor time of each start from an older clone and from this tree."""
    print("| start | older, s | s | ratio |\n| --- | --- | --- | --- |")
    for name, words in STARTS_IN_TURNS.items():
        times: list[list[float]] = [[], []]
        with tempfile.TemporaryDirectory() as folder:
            for _ in range(1 + ROUNDS_IN_TURNS):
                for tree, found in zip((older, ROOT), times, strict=True):
                    cache = str(Path(folder) / f"cache of {tree.name}")
                    plain = {"PYTHONPATH": str(tree), "FRETSOLVE_NUMBA": "0", "FRETSOLVE_CACHE": cache}
                    found.append(seconds(Path(sys.executable), words, folder, plain))
        before, now = (min(found[1:]) for found in times)
        print(f"| {name} | {before:.2f} | {now:.2f} | {now / before:.2f} |", flush=True)


def installed(folder: Path, extra: str) -> Path:
    """Make an environment with the package, and return its interpreter."""
    subprocess.run([sys.executable, "-m", "venv", folder], check=True)
    python = folder / "bin" / "python"
    wanted = f"{ROOT}[{extra}]" if extra else str(ROOT)
    subprocess.run([python, "-m", "pip", "install", "--quiet", wanted], check=True)
    return python


def megabytes(folder: Path) -> float:
    """Return what the package and its dependencies take on disk, without what every environment has."""
    (packages,) = folder.glob("lib/python*/site-packages")
    ours = [path for path in packages.iterdir() if not path.name.startswith(("pip", "setuptools", "_distutils"))]
    return sum(file.stat().st_size for path in ours for file in [path, *path.rglob("*")] if file.is_file()) / 1e6


def least(python: Path, words: tuple[str, ...], folder: str) -> float:
    """Return the processor time of a start: the least of some, without the first one, which compiles the modules."""
    plain = {"FRETSOLVE_CACHE": folder}
    return min([seconds(python, words, folder, plain) for _ in range(1 + ROUNDS)][1:])


def seconds(python: Path, words: tuple[str, ...], folder: str, plain: Mapping[str, str]) -> float:
    """Return the processor time of a process that runs in `folder`, in an environment with `plain`."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"} | dict(plain)
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([python, *words], check=True, capture_output=True, env=environment, cwd=folder)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


if __name__ == "__main__":
    main()
