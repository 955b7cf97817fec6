"""How the templates of pages are filled in."""

from __future__ import annotations

import re
from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape


def page_templates(package: str) -> Environment:
    """The templates of a package, for HTML: everything is escaped, a name that is not given is an error."""
    return _templates(package)


@cache
def _templates(package: str) -> Environment:
    made = Environment(
        loader=PackageLoader(package, "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters["coded"] = coded  # before any template is compiled: they are compiled once, for all pages
    return made


def coded(text: str) -> Markup:
    """A message as HTML: what stands between back-ticks as code, all else escaped."""
    return Markup(re.sub(r"`([^`]+)`", r"<code>\1</code>", str(escape(text))))
