# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""docs/sources.md is what the catalogue says."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

DOCS = Path(__file__).resolve().parents[2] / "docs"


def test_the_page_is_that_of_the_catalogue(monkeypatch) -> None:
    spec = importlib.util.spec_from_file_location("generate_sources", DOCS / "generate_sources.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, module)
    spec.loader.exec_module(module)
    page = (DOCS / "sources.md").read_text(encoding="utf-8")
    assert page == module.text(), "run python docs/generate_sources.py"
