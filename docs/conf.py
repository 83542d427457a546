"""Configure Sphinx, which makes web pages of the documents: python -m sphinx -W docs OUT (extra `docs`)."""

from fretsolve import __version__ as release

project = "fretsolve"
extensions = ["myst_parser"]
myst_enable_extensions = ["dollarmath", "html_image"]
myst_heading_anchors = 3
html_theme = "furo"
html_title = f"fretsolve {release}"
smartquotes = False
