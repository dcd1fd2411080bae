"""Settings of Sphinx for the site of the documentation; ``packaging/docs_site.py`` runs it."""

from __future__ import annotations

import tomllib
from pathlib import Path

_ROOT = Path(__file__).resolve().parent.parent.parent
_PROJECT = tomllib.loads((_ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]

project = "hawk"
version = release = _PROJECT["version"]
language = "en"
root_doc = "index"
extensions = ["myst_parser"]
myst_heading_anchors = 4
"""Headings get the anchors that GitHub gives them, so that links work in both places."""
nitpicky = True

html_theme = "furo"
html_title = f"hawk {version}"
html_baseurl = ""
html_favicon = "../../hawk/web/page/public/icon.svg"
html_static_path = ["static"]
templates_path = ["templates"]
html_css_files = ["hawk.css"]
html_search_scorer = str(Path(__file__).with_name("search_scorer.js"))
html_theme_options: dict[str, list[str]] = {"top_of_page_buttons": []}
html_copy_source = False
html_show_sourcelink = False
html_show_copyright = False
html_use_index = False
html_domain_indices = False
