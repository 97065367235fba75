"""The pages from their templates (Jinja2, folder templates/): texts are escaped, and what would move words on a page is an escape.

A folder of the user's own templates comes first; a template there may extend the one that it stands for:
{% extends "surveymc/page.html" %}.
"""

import json
import os

import jinja2

from ..plots.reading import PlotError
from ..streams import visible
from . import text

HERE = os.path.dirname(os.path.abspath(__file__))


def static(name):
    """A file of this folder, for a <style> or <script> of a page."""
    with open(os.path.join(HERE, name), encoding="utf-8") as file:
        return text.Markup(file.read())


def style():
    """The style sheet: light and dark, and for paper."""
    css, dark = static("report.css").split("/* dark */")
    return text.Markup(css + "@media (prefers-color-scheme: dark) { :root:not([data-theme=light]) {" + dark + "} }\n"
                       + ":root[data-theme=dark] {" + dark + "}\n" + static("print.css"))


def _as_shown(value):
    return visible(value) if isinstance(value, str) and not isinstance(value, text.Markup) else value


def in_script(data):
    """Data for a <script type="application/json">."""
    return text.Markup(json.dumps(data, separators=(",", ":"), ensure_ascii=False, allow_nan=False).replace("<", "\\u003c"))


def environment(folder=None):
    """What renders the templates. folder: of the user's own templates, or None."""
    shipped = jinja2.FileSystemLoader(os.path.join(HERE, "templates"))
    loaders = [jinja2.FileSystemLoader(folder)] if folder else []
    found = jinja2.Environment(loader=jinja2.ChoiceLoader([*loaders, shipped, jinja2.PrefixLoader({"surveymc": shipped})]),
                               autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True,
                               finalize=_as_shown)
    found.filters |= {"prose": text.prose, "grouped": text.grouped, "number": text.number, "unit": text.unit, "slug": text.slug, "in_script": in_script}
    found.globals |= {"static": static, "style": style, "kinds": text.VERDICT_MARKS, "counts_sentence": text.counts_sentence,
                      "total": text.total}
    return found


def render(environment, name, **values):
    """A page. PlotError where a template is wrong: the user's own may be."""
    try:
        return environment.get_template(name).render(**values)
    except jinja2.TemplateSyntaxError as error:
        raise PlotError(f"{error.filename or error.name}:{error.lineno}: {error.message}") from None
    except jinja2.TemplateError as error:
        raise PlotError(f"template {name}: {error.message or type(error).__name__}") from None
