"""The command ``fretsolve``, and ``python -m fretsolve``."""

from __future__ import annotations

import signal


def start() -> None:
    """Run the command line. While it is being loaded, Ctrl-C ends the process without a traceback."""
    before = signal.getsignal(signal.SIGINT)
    if before is signal.default_int_handler:  # and not ignored, as in the background
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from fretsolve.cli.main import main

    signal.signal(signal.SIGINT, before)
    main(prog_name="fretsolve")


if __name__ == "__main__":
    start()
