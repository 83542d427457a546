"""Size of the installed package and processor time of its start, bare and with each extra.

``python benchmarks/footprint.py`` makes an environment per extra and prints a table for docs/performance.md; it
needs an index of packages, and some minutes.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
EXTRAS = ("", "fast", "plot", "xarray", "scale")
ROUNDS = 3

STARTS = {
    "`--help`": ("-m", "fretsolve", "--help"),
    "`validate`": ("-m", "fretsolve", "validate", str(ROOT / "cases" / "mode1_similar.yaml")),
    "`import fretsolve; fretsolve.run`": ("-c", "import fretsolve; fretsolve.run"),
}


def main() -> None:
    """Print the table."""
    print(f"| installed | MB | {' | '.join(f'{name}, s' for name in STARTS)} |")
    print("| --- | --- |" + " --- |" * len(STARTS))
    for extra in EXTRAS:
        with tempfile.TemporaryDirectory() as folder:
            python = installed(Path(folder), extra)
            size = megabytes(Path(folder))
            times = " | ".join(f"{seconds(python, words, folder):.2f}" for words in STARTS.values())
        print(f"| {f'fretsolve[{extra}]' if extra else 'fretsolve'} | {size:.0f} | {times} |", flush=True)


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


def seconds(python: Path, words: tuple[str, ...], folder: str) -> float:
    """Return the processor time of a start: the least of some, without the first one, which compiles the modules."""
    environment = {**os.environ, "FRETSOLVE_CACHE": folder}
    environment.pop("PYTHONPATH", None)
    times = []
    for _ in range(1 + ROUNDS):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([python, *words], check=True, capture_output=True, env=environment, cwd=folder)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        times.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return min(times[1:])


if __name__ == "__main__":
    main()
