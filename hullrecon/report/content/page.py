# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Render the one page that people open first: self-contained, no network."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import resources


def render_page(context: Mapping[str, object]) -> str:
    """Return the HTML of the variables of page_context."""
    from jinja2 import DictLoader, Environment, StrictUndefined

    folder = resources.files("hullrecon.report") / "templates"
    page, script, style = (
        (folder / name).read_text(encoding="utf-8") for name in ("page.html", "report.js", "report.css")
    )  # the last two are built: report/web
    environment = Environment(
        loader=DictLoader({"page.html": page}), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    return environment.get_template("page.html").render(context, script=script, style=style)
