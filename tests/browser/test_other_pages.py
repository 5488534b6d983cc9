# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The pages beside the report, of a fleet and of a change: offline, on a phone, by keyboard, and by
axe.
"""

from __future__ import annotations

from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
import pytest
from api.test_fleet_index import fleet_dive, result
from browser.pages import violations
from playwright.sync_api import Browser
from report.change.conftest import MOVE, hull_change, object_change

from benchmarks.chromium import NARROW, WIDE, visit
from hullrecon.api.fleet.index_page import FleetIndex
from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.report.change.files import comparison_files

pytestmark = pytest.mark.slow
SIZES = pytest.mark.parametrize("size", [WIDE, NARROW], ids=["wide", "narrow"])
LONG = (
    "a dive with a name as long as people give them, "
    "2026-05-04 port side between the bilge keel and the waterline"
)


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The page of three dives, one of them failed, and that of a change with rows of each kind."""
    folder = tmp_path_factory.mktemp("pages")
    for name in ("april", "may"):
        result(folder, name)
    dives = [fleet_dive("april"), fleet_dive("may", "to do", "the package changed")]
    dives.append(
        fleet_dive(
            "june-with-a-long-name-that-does-not-break",
            "failed",
            f"step adjust: too few matches; {LONG}",
        )
    )
    FleetIndex(folder).write(dives)
    objects = [
        object_change("gone", 4, None, 33.4, 0.14, 0.001),
        object_change("grown", 1, 1, 30.6, 0.11, 0.141),
        object_change("not seen again", 7, None, 33.9, 0.08, np.nan, change=np.nan),
        object_change("unchanged", 2, 3, 31.8, 0.12, 0.121),
    ]
    change = folder / "change.html"
    outside = OutsideMap(x_sign=-1, y_sign=1, frame="M")
    files = comparison_files(hull_change(objects, [MOVE]), outside, 1_780_000_000_000_000_000)
    change.write_bytes(files["change.html"])
    return {"fleet": folder / "index.html", "change": change}


@SIZES
@pytest.mark.parametrize("name", ["fleet", "change"])
def test_the_page_is_accessible_and_needs_nothing_else(
    chromium: Browser, pages: dict[str, Path], name: str, size: tuple[int, int]
) -> None:
    with visit(chromium, pages[name], size) as seen:
        assert violations(seen) == []
        assert {urlsplit(url).path for url in seen.requests if url.startswith("file:")} == {
            str(pages[name])
        }
        assert {url.split(":")[0] for url in seen.requests} <= {"file", "data"}
        assert seen.messages == []
        wider = seen.page.evaluate("document.documentElement.scrollWidth - innerWidth")
        assert wider <= 0, f"the page is {wider} px wider than its screen"


@SIZES
@pytest.mark.parametrize("name", ["fleet", "change"])
def test_the_keyboard_reaches_links_and_scrolling_parts(
    chromium: Browser, pages: dict[str, Path], name: str, size: tuple[int, int]
) -> None:
    with visit(chromium, pages[name], size) as seen:
        wanted = seen.page.evaluate("""() => {
          const focusable = 'a[href], button, input, summary, [tabindex="0"]'
          const all = [...document.querySelectorAll(focusable)]
          all.forEach((one, k) => { one.dataset.stop = k })
          const scrolls = (one) =>
            one.scrollWidth > one.clientWidth + 1 && getComputedStyle(one).overflowX !== 'visible'
          const mute = [...document.querySelectorAll('main *')].filter(
            (one) => scrolls(one) && one.dataset.stop === undefined)
          return { stops: all.length, mute: mute.map((one) => one.outerHTML.slice(0, 80)) }
        }""")
        assert wanted["mute"] == []
        reached, unmarked = set(), []
        for _ in range(wanted["stops"] + 2):
            seen.page.keyboard.press("Tab")
            stop = seen.page.evaluate("document.activeElement.dataset.stop ?? null")
            if stop is None:
                break
            reached.add(stop)
            style = seen.page.evaluate("""() => {
              const style = getComputedStyle(document.activeElement)
              return [style.outlineStyle, parseFloat(style.outlineWidth)]
            }""")
            if style[0] == "none" or style[1] < 1:
                unmarked.append(seen.page.evaluate("document.activeElement.outerHTML.slice(0, 80)"))
        assert len(reached) == wanted["stops"] > 0
        assert unmarked == []
