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
    names = ("page.html", "style.css")
    texts = {name: (folder / name).read_text(encoding="utf-8") for name in names}
    environment = Environment(
        loader=DictLoader(texts), autoescape=lambda name: name == "page.html", undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    return environment.get_template("page.html").render(context)
