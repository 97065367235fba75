"""Sphinx's settings of the documentation site (scripts/build_docs.sh), for the pages that scripts/docs_site.py has made ready."""
import pathlib
import re

from pygments.lexers.special import TextLexer
from sphinx.highlighting import lexers

project = "surveymc"
author = copyright = "The surveymc authors"
source = pathlib.Path(__file__).resolve().parent
version = release = re.search(r"^project\(surveymc VERSION ([\d.]+)", (source / "CMakeLists.txt").read_text(), re.M)[1]
extensions = ["myst_parser"]
myst_heading_anchors = 4  # links to headings, as GitHub makes them
html_theme = "furo"
html_title = f"surveymc {version}"
html_copy_source = html_show_sourcelink = False
html_static_path = ["site.css"]
html_extra_path = ["extra"]  # pictures of the gallery, which is HTML
exclude_patterns = ["extra"]
html_css_files = ["site.css"]
highlight_language = "none"
lexers.update(csv=TextLexer(), output=TextLexer())  # words of the pages that name no language of Pygments
