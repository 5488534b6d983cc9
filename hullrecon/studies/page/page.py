# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Write index.html for a folder of studies: self-contained, pictures inside."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from importlib import resources
from pathlib import Path

from hullrecon.artifacts.disk import write_file
from hullrecon.studies.registry import STUDIES
from hullrecon.studies.results import KeptStudy, read_results

PAGE = "index.html"


def write_page(out: Path) -> Path:
    """Write the page of all studies whose results the folder holds."""
    kept = read_results(out, [study.id for study in STUDIES])
    page = out / PAGE
    write_file(page, render_page(kept, out).encode())
    return page


def render_page(kept: Mapping[str, KeptStudy], out: Path) -> str:
    """Render the page of finished and failed studies, with the pictures of the folder."""
    return _render(
        {
            "studies": list(kept.values()),
            "finished": sum(not study.failure for study in kept.values()),
            "seconds": sum(study.seconds for study in kept.values()),
            "known": len(STUDIES),
            "picture": lambda study, name: _data_uri(out / study / f"{name}.png"),
            "number": show_number,
        }
    )


def show_number(value: float | None) -> str:
    """Show a number with four digits, a dash for none."""
    if value is None:
        return "–"
    return f"{value:,.0f}" if abs(value) >= 1e4 else f"{value:.4g}"


def _data_uri(picture: Path) -> str:
    """Read a picture as an address that holds its bytes, "" where it is gone."""
    if not picture.is_file():
        return ""
    return "data:image/png;base64," + base64.b64encode(picture.read_bytes()).decode()


def _render(variables: Mapping[str, object]) -> str:
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    def read(name: str) -> str:
        file = resources.files("hullrecon.studies.page") / name
        return file.read_text(encoding="utf-8")

    environment = Environment(
        loader=FunctionLoader(read),
        autoescape=lambda file: file is not None and file.endswith(".html"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template("page.html").render(variables)
