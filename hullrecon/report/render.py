# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Render the page and the PDF from their templates: self-contained, nothing from a network."""

from __future__ import annotations

import io
import logging
import re
from collections.abc import Mapping
from contextlib import redirect_stdout
from importlib import resources
from pathlib import Path
from typing import Any

_FONT = "font:"  # scheme of the fonts named in print.css
MAX_CARDS = 40  # with more objects the PDF has a photo and a line for each, and an annex of numbers
_PICTURES = "/* Pictures */"  # mark in print.css after which the rules of plan and ship begin


def render_page(context: Mapping[str, object]) -> str:
    """Render the page that people open first, from the variables of page_context."""
    # built from report/web
    built = {"script": read_template("report.js"), "style": read_template("report.css")}
    return render_template("page.html", {**context, **built})


def render_template(name: str, variables: Mapping[str, object]) -> str:
    """Render a template of this package. A variable that is not there is an error.

    Values are escaped, but in style sheets.
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
    """Read a file of report/templates."""
    return (resources.files("hullrecon.report") / "templates" / name).read_text(encoding="utf-8")


def why_no_pdf() -> str | None:
    """Say why this machine cannot make a PDF. None if it can."""
    try:
        # where a library is missing, WeasyPrint prints how to install it
        with redirect_stdout(io.StringIO()):
            import weasyprint  # noqa: F401
    except OSError:
        packages = "libpango-1.0-0, libpangoft2-1.0-0, libharfbuzz-subset0"
        return f"Pango is not installed (Debian packages {packages})"
    return None


def render_pdf(context: Mapping[str, Any]) -> bytes:
    """Render the report as PDF, tagged for screen readers, from the variables of page_context.

    The same context gives the same bytes. Raises OSError if Pango is missing.
    """
    import weasyprint

    for name in ("weasyprint", "fontTools"):  # their warnings are of fonts and CSS
        logging.getLogger(name).setLevel(logging.ERROR)
    document = weasyprint.HTML(string=render_html(context), url_fetcher=_fetch, base_url=_FONT)
    options = {"pdf_variant": "pdf/ua-1", "pdf_identifier": b"hullrecon"}
    return bytes(document.write_pdf(dpi=200, **options))


def render_html(context: Mapping[str, Any]) -> str:
    """Render the HTML that the PDF is made of.

    The 3-D view is left out. The SVG pictures get their style rules inside, as those of the page do
    not apply there.
    """
    # rules of the page do not apply inside a picture
    style, _, pictures = read_template("print.css").partition(_PICTURES)
    sections = [section for section in context["sections"] if section[0] != "view"]
    plan, ship = context["plan"], context["ship"]
    more = {
        "sections": sections,
        "number": {name: k for k, (name, _) in enumerate(sections, start=1)},
        "plan": plan and _with_style(plan, pictures),
        "ship": ship and (_with_style(ship[0], pictures), ship[1]),
        "compact": len(context["cards"]) > MAX_CARDS,
        "columns": list(
            dict.fromkeys(name for card in context["cards"] for name, _ in card["rows"])
        ),
    }
    return render_template("print.html", {**context, **more, "style": style, "dict": dict})


def _with_style(svg: str, rules: str) -> str:
    """Insert style rules into an SVG."""
    return re.sub(r"<svg[^>]*>", lambda found: f"{found[0]}<style>{rules}</style>", svg, count=1)


def _fetch(url: str, headers: Mapping[str, str] | None = None) -> object:
    """Fetch a font, or a picture given as a data URI, and nothing from disk or network otherwise.

    Raises ValueError for any other URL.
    """
    import matplotlib
    from weasyprint.urls import URLFetcher, URLFetcherResponse

    if url.startswith("data:"):
        return URLFetcher(allowed_protocols=("data",)).fetch(url, headers)
    if not url.startswith(_FONT):
        raise ValueError(f"the report names {url.split(':')[0]}")
    name = Path(url.removeprefix(_FONT)).name
    own = resources.files("hullrecon.report") / "templates" / "fonts" / name
    font = Path(matplotlib.get_data_path()) / "fonts" / "ttf" / name
    return URLFetcherResponse(url, (font if name.startswith("DejaVu") else own).read_bytes())
