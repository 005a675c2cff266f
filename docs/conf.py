"""How the pages become a site: `python -m sphinx -W --keep-going docs docs/_build`, offline.

The examples of the gallery and the notebook are executed in copies below `_build`, by the package
in this checkout.
"""

import os
import shutil
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
WORK = HERE / "_build" / "examples"  # where examples run, and leave their archives

sys.path[:0] = [str(ROOT), str(HERE / "site")]
os.environ["PYTHONPATH"] = str(ROOT)  # for the notebook, which runs in a process of its own
os.environ["IPYTHONDIR"] = str(HERE / "_build" / "ipython")  # its settings, not those of the user
os.environ.setdefault("PYDEVD_DISABLE_FILE_VALIDATION", "1")  # its debugger warns about Python

from nlds_vines.archives.provenance import version as version_of  # noqa: E402 - found by the above

settings = Path(os.environ["IPYTHONDIR"], "profile_default", "ipython_kernel_config.py")
settings.parent.mkdir(parents=True, exist_ok=True)
settings.write_text(
    "c.IPKernelApp.log_level = 'ERROR'  # it warns that it listens on this machine\n"
)
shutil.rmtree(WORK, ignore_errors=True)
shutil.copytree(HERE / "gallery", WORK, ignore=shutil.ignore_patterns("__pycache__"))

project = "nlds_vines"
author = "The nlds_vines authors"
copyright = "the nlds_vines authors, MIT license"
release = version_of("nlds-vines")

extensions = [
    "myst_nb",  # the pages, in Markdown, and the notebook, executed
    "sphinx.ext.autodoc",  # the public functions and classes, from their docstrings
    "sphinx.ext.napoleon",  # which list parameters as numpydoc does, or as `Arguments:`
    "sphinx_gallery.gen_gallery",  # examples, executed
    "mathml",  # formulas, without scripts
]
html_math_renderer = "mathml"
html_theme = "furo"
html_title = "nlds_vines"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_js_files = ["copy.js", "fold.js"]
html_show_sourcelink = False
html_copy_source = False
exclude_patterns = ["_build", "gallery", "site", "reproduction/archives"]
exclude_patterns += [
    "_gallery/*.ipynb",
    "_gallery/*.py",
    "_gallery/*.json",
    "_gallery/*.zip",
]  # downloads
templates_path: list[str] = []

myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 4
nb_execution_mode = "force"
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 300

default_role = "literal"  # docstrings say `name` for code
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
napoleon_custom_sections = [("Arguments", "Args")]

sphinx_gallery_conf = {
    "examples_dirs": str(WORK),
    "gallery_dirs": "_gallery",
    "filename_pattern": r"\.py$",
    "parallel": min(4, os.cpu_count() or 1),  # processes, of up to 0.7 GB where they compile
    "within_subsection_order": "FileNameSortKey",
    "thumbnail_size": (480, 340),
    "image_scrapers": ("matplotlib", "pictures.written_pictures"),
    "capture_repr": (),
    "download_all_examples": False,
    "show_memory": False,
    "show_signature": False,
    "remove_config_comments": True,
    "abort_on_example_error": False,
    "min_reported_time": 1000,
    "write_computation_times": False,
}


def _as_written(app, what, name, thing, options, lines):
    """Keep a docstring from being read as markup: |mu| is a modulus, and a colon names no type."""
    lines[:] = [line.replace("|", r"\|") for line in lines]
    if what in ("property", "attribute"):
        lines[:1] = [line.replace(": ", " - ", 1) for line in lines[:1]]


def setup(app):
    """Register what docstrings need, before they are looked at for `Arguments:`."""
    app.connect("autodoc-process-docstring", _as_written, priority=400)
