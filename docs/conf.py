"""Configuration of Sphinx, which makes the pages: python -m sphinx -W docs OUT (extra `docs`)."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from fretsolve import __version__ as release

project = "fretsolve"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx_click", "generated"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
autodoc_typehints = "description"
autodoc_member_order = "bysource"
html_theme = "furo"
html_title = f"fretsolve {release}"
smartquotes = False
