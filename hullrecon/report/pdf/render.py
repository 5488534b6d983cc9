# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Render report.pdf: the page's content on paper, with page numbers, by WeasyPrint; nothing is read
but templates and fonts.
"""

from __future__ import annotations

import io
import logging
import re
from collections.abc import Mapping, Sequence
from contextlib import redirect_stdout
from importlib import resources
from pathlib import Path
from typing import TypedDict, cast

from hullrecon.report.content.page import read_template, render_template

PDF = "report/report.pdf"  # in deliver/
_FONT = "font:"  # scheme of the fonts named in print.css
MAX_CARDS = 40  # of more objects there is a photo with a line; all numbers stand in the annex
_PICTURES = "/* Pictures */"  # before the rules of plan and ship in print.css


class _Card(TypedDict):
    rows: Sequence[tuple[str, str]]


class _Shown(TypedDict):
    """What is looked into of the page's variables; the template takes the others as they are."""

    sections: Sequence[tuple[str, str]]
    cards: Sequence[_Card]
    plan: str | None
    ship: tuple[str, str] | None


def why_no_pdf() -> str | None:
    """Return why this machine cannot make a PDF, in a sentence; None where it can."""
    try:
        # where a library is missing, WeasyPrint prints how to install it
        with redirect_stdout(io.StringIO()):
            import weasyprint  # noqa: F401
    except OSError:
        return "Pango is not installed (Debian packages libpango-1.0-0, libpangoft2-1.0-0, libharfbuzz-subset0)"
    return None


def render_pdf(context: Mapping[str, object]) -> bytes:
    """Return the report as PDF, tagged for screen readers; context: the variables of page_context.
    Same context, same bytes.

    Raises OSError where Pango is missing.
    """
    import weasyprint

    for name in ("weasyprint", "fontTools"):  # they speak of fonts and CSS, not of the dive
        logging.getLogger(name).setLevel(logging.ERROR)
    document = weasyprint.HTML(string=render_html(context), url_fetcher=_fetch, base_url=_FONT)
    return bytes(
        document.write_pdf(
            pdf_variant="pdf/ua-1", pdf_identifier=b"hullrecon", dpi=200, optimize_images=True
        )
    )


def render_html(context: Mapping[str, object]) -> str:
    """Return what is laid out on the pages."""
    shown = cast(_Shown, context)
    # rules of the page do not reach into a picture
    style, _, pictures = read_template("print.css").partition(_PICTURES)
    sections = [section for section in shown["sections"] if section[0] != "view"]
    plan, ship = shown["plan"], shown["ship"]
    more = {
        "sections": sections,
        "number": {name: k for k, (name, _) in enumerate(sections, start=1)},
        "plan": plan and _with_style(plan, pictures),
        "ship": ship and (_with_style(ship[0], pictures), ship[1]),
        "compact": len(shown["cards"]) > MAX_CARDS,
        "columns": list(dict.fromkeys(name for card in shown["cards"] for name, _ in card["rows"])),
    }
    return render_template("print.html", {**context, **more, "style": style, "dict": dict})


def _with_style(svg: str, rules: str) -> str:
    """Return a picture with rules of its own."""
    return re.sub(r"<svg[^>]*>", lambda found: f"{found[0]}<style>{rules}</style>", svg, count=1)


def _fetch(url: str, headers: Mapping[str, str] | None = None) -> object:
    """Return a font, or a picture of a data URI. Raises ValueError for anything else: nothing comes
    from disk or network.
    """
    import matplotlib
    from weasyprint.urls import URLFetcher, URLFetcherResponse

    if url.startswith("data:"):
        return URLFetcher(allowed_protocols=("data",)).fetch(url, headers)
    if not url.startswith(_FONT):
        raise ValueError(f"the report names {url.split(':')[0]}")
    name = Path(url.removeprefix(_FONT)).name
    if name.startswith("DejaVu"):
        return URLFetcherResponse(
            url, (Path(matplotlib.get_data_path()) / "fonts" / "ttf" / name).read_bytes()
        )
    return URLFetcherResponse(
        url, (resources.files("hullrecon.report") / "templates" / "fonts" / name).read_bytes()
    )
