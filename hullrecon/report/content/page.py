# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Render the one page that people open first: self-contained, no network."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import resources


def render_page(context: Mapping[str, object]) -> str:
    """Return the HTML of the variables of page_context."""
    # from report/web
    built = {"script": read_template("report.js"), "style": read_template("report.css")}
    return render_template("page.html", {**context, **built})


def render_template(name: str, variables: Mapping[str, object]) -> str:
    """Return the text of a template of this package. A variable that is not there is an error; what
    is no style is escaped.
    """
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    environment = Environment(
        loader=FunctionLoader(read_template),
        autoescape=lambda file: file is None or not file.endswith(".css"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(name).render(variables)


def read_template(name: str) -> str:
    """Return a file of report/templates."""
    return (resources.files("hullrecon.report") / "templates" / name).read_text(encoding="utf-8")
