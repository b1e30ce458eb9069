"""Sphinx configuration: ``sphinx-build -W docs build/docs``, or ``nox -s docs``. The build runs every example and needs no network."""

import sys
from pathlib import Path

import bristle_sim

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

project = "bristle_sim"
author = "The bristle_sim developers"
copyright = "2026, the bristle_sim developers"
version = release = bristle_sim.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.intersphinx",
    "sphinx_copybutton",
    "sphinx_design",
    "mathml",
    "bench",
    "scenario",
    "keys",
    "local_inventories",
]
exclude_patterns = ["_ext", "kept", "inventories"]
templates_path: list[str] = []

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

nb_execution_mode = "force"
nb_execution_timeout = 90
nb_execution_raise_on_error = True
nb_merge_streams = True
nb_execution_in_temp = True

autodoc_member_order = "bysource"
autodoc_typehints = "none"
autoclass_content = "class"
napoleon_google_docstring = True
napoleon_numpy_docstring = False

html_theme = "furo"
html_title = "bristle_sim"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_theme_options = {"navigation_with_keys": True}
