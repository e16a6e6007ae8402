"""Settings of the site; build it with `sphinx-build -W --keep-going -b html docs docs/_build/html`.

Everything that the pages need is in the package's extra `docs`; neither the build nor the pages ask the
network.
"""

import hashlib
import os
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_extensions"))
os.environ["MPLBACKEND"] = "Agg"
os.environ["MATPLOTLIBRC"] = str(HERE / "matplotlibrc")  # sharp pictures, of cells too
os.environ["FRICTIONLAB_PROGRESS"] = "0"  # bars would stay on the pages as widgets without a kernel

import frictionlab  # noqa: E402  they read their variables when they are loaded

project = "frictionlab"
author = "frictionlab developers"
copyright = author
version = release = frictionlab.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.viewcode",
    "numpydoc",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinxcontrib.bibtex",
    "borrowed_pages",
    "gallery_pages",
    "live_pages",
    "mathml",
    "reference_pages",
    "schematics",
]
exclude_patterns = ["_build", "_extensions", "_templates"]
templates_path = ["_templates"]
nitpicky = True  # a name in the text that leads nowhere is a warning, and so an error
nitpick_ignore_regex = [
    ("py:.*", r"(matplotlib|numpy|scipy)\..*"),  # their pages are on other servers
    ("py:class", r".*\.EventOutputs"),  # of runs, from which users take columns by name
]

# Pages in Markdown; those with code cells are run while the site is built, and the course unless tests
# have left executed copies (see borrowed_pages.py).
myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
SOURCES = b"".join(path.read_bytes() for path in sorted(HERE.parent.glob("frictionlab/**/*.py")))
nb_execution_mode = "cache"  # until the page or the package changes
nb_execution_cache_path = str(HERE / "_build" / f"executed-{hashlib.sha256(SOURCES).hexdigest()[:12]}")
nb_execution_timeout = 600
nb_execution_raise_on_error = True
nb_merge_streams = True
nb_ipywidgets_js = {}  # widgets need a kernel; their scripts would come from another server

# The reference: one page for each public name.
autosummary_generate = True
autodoc_typehints = "none"  # numpydoc's sections say it with units and shapes
autodoc_member_order = "bysource"
numpydoc_show_class_members = False  # the page of a class has them

html_math_renderer = "mathml"
html_theme = "pydata_sphinx_theme"
html_title = "frictionlab"
html_context = {"default_mode": "auto"}
html_static_path = ["_static"]
html_favicon = "_static/favicon.svg"
bibtex_bibfiles = ["references.bib"]
copybutton_prompt_text = r">>> |\.\.\. |\$ "  # copied without
copybutton_prompt_is_regexp = True
html_css_files = ["site.css"]
html_js_files = ["live_pages.js", "fit_equations.js"]
html_show_sourcelink = False
html_copy_source = False
ALONE = (
    "index",
    "getting-started",
    "bibliography",
    "lecturer",
    "extending/index",
    "changelog",
)
html_sidebars = {page: [] for page in ALONE}  # nothing beside them in their section
html_theme_options = {
    "logo": {"text": f"frictionlab {version}"},
    "header_links_before_dropdown": 6,
    "navigation_with_keys": False,
    "show_toc_level": 2,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": ["theme-version"],
}
