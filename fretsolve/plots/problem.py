"""What keeps a picture from being drawn."""

from __future__ import annotations

from fretsolve.errors import FretsolveError


class PictureError(FretsolveError):
    """The result, or what was asked for, does not give the picture; the text says why (exit code 2)."""

    exit_code = 2
