"""``python -m fretsolve``."""

from __future__ import annotations

from fretsolve.cli.main import main

if __name__ == "__main__":
    main(prog_name="fretsolve")
