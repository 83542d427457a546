"""The command ``fretsolve``, and ``python -m fretsolve``."""

from __future__ import annotations

# `signal` first loads other modules, and Ctrl-C in them would print a traceback.
import _signal  # type: ignore[import-not-found]


def start() -> None:
    """Run the command line. Wherever nothing handles Ctrl-C, it ends the process by the signal, without a traceback."""
    handled = _signal.getsignal(_signal.SIGINT) is _signal.default_int_handler  # and not ignored, as in the background
    if handled:
        _signal.signal(_signal.SIGINT, _signal.SIG_DFL)
    from fretsolve.cli.main import main

    if handled:
        _signal.signal(_signal.SIGINT, _signal.default_int_handler)
    try:
        main(prog_name="fretsolve")
    except KeyboardInterrupt:
        _signal.signal(_signal.SIGINT, _signal.SIG_DFL)
        _signal.raise_signal(_signal.SIGINT)
    finally:
        if _signal.getsignal(_signal.SIGINT) is _signal.default_int_handler:
            _signal.signal(_signal.SIGINT, _signal.SIG_DFL)  # while the interpreter ends


if __name__ == "__main__":
    start()
