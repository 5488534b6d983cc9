# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the page's script is given."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from hullrecon.report.content.page import render_page
from hullrecon.report.content.page_context import page_context
from hullrecon.report.content.page_data import script_json
from hullrecon.report.survey import Survey

WEB = Path(__file__).resolve().parents[2] / "hullrecon" / "report" / "web"
TEMPLATES = WEB.parent / "templates"


def data_of(survey: Survey) -> dict[str, object]:
    """The document as a browser finds it."""
    text = render_page(page_context(survey, [], {}, {}))
    (found,) = re.findall(r'(?s)<script type="application/json" id="report-data">(.*?)</script>', text)
    return json.loads(found)


def test_no_text_ends_the_script_that_it_stands_in() -> None:
    text = script_json({"vessel": "</script><b>\u2028", "sum": 1})
    assert "<" not in text
    assert "\u2028" not in text
    assert json.loads(text)["vessel"] == "</script><b>\u2028"
    with pytest.raises(ValueError, match="Out of range"):
        script_json({"height": float("nan")})


def test_the_page_holds_its_data_once(survey: Survey, bare: Survey) -> None:
    assert data_of(survey)["frame"] == "M"
    assert data_of(bare)["frame"] == "g"


def test_what_is_bundled_comes_with_its_licence_and_loads_nothing() -> None:
    versions = json.loads((WEB / "package.json").read_text())["devDependencies"]
    for name in ("report.js", "report.css"):
        text = (TEMPLATES / name).read_text()
        assert f"Leaflet {versions['leaflet']}" in text, "built from another version: make web"
        assert f"three.js {versions['three']}" in text
        assert "Redistributions in binary form must reproduce the above copyright" in text
        assert "</script" not in text.lower()
        assert not re.search(r"@import|url\((?!data:|#)|sourceMappingURL", text)


def test_the_lock_names_exact_versions_and_no_registry() -> None:
    package = json.loads((WEB / "package.json").read_text())
    assert all(re.fullmatch(r"\d+\.\d+\.\d+", version) for version in package["devDependencies"].values())
    lock = (WEB / "package-lock.json").read_text()
    assert "registry" not in lock
    assert '"resolved"' not in lock
