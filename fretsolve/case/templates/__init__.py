"""Cases to start from. In comes a name of `TEMPLATES`, out comes the text of a case file. For example::

    files("fretsolve.case.templates").joinpath("hertz.yaml").read_text()

`fretsolve new` writes them.
"""

from __future__ import annotations

TEMPLATES = ("hertz", "mode1", "mode2", "mode3", "gross-slip", "rough", "line", "wear")
"""Their names, as the command line has them."""
