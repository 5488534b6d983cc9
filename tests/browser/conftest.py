# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The report's page of the demo, and the same with 500 objects, in a headless Chromium."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from end_to_end.shell import SAMPLE
from playwright.sync_api import Browser

from benchmarks.chromium import NoBrowserError, Visit, browser, find_browser, visit
from benchmarks.page import crowded_report
from hullrecon.report.figures import map_pictures

OBJECTS = 500


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    """A browser for one module: its event loop would be in the way of others."""
    try:
        find_browser()
    except NoBrowserError as error:
        if os.environ.get("HULLRECON_BROWSER") == "required":
            raise
        pytest.skip(str(error))
    with browser() as started:
        yield started


@pytest.fixture(scope="session")
def report(demo_run: Path) -> Path:
    return demo_run / "deliver" / "report" / "index.html"


@pytest.fixture(scope="session")
def crowded(demo_run: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return crowded_report(demo_run, SAMPLE, tmp_path_factory.mktemp("crowded"), OBJECTS)


@pytest.fixture(scope="session")
def tiled(demo_run: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The demo's page as if its mosaics were too large for it, with tiles beside it."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(map_pictures, "MOST_PIXELS", 1e5)
        return crowded_report(demo_run, SAMPLE, tmp_path_factory.mktemp("tiled"), 1)


@pytest.fixture
def page(chromium: Browser, report: Path) -> Iterator[Visit]:
    """The demo's page, opened at 1280 pixels. Whatever a test does with it, its console stays
    empty.
    """
    with visit(chromium, report) as seen:
        yield seen
        assert seen.messages == []
