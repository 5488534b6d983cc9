# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The page opens from disk without a network and answers to clicks, keys and small screens."""

from __future__ import annotations

import json
import math
from itertools import combinations
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from browser.conftest import OBJECTS
from browser.pages import violations
from browser.pictures import picture_at_rest, share_changed
from playwright.sync_api import Browser, Locator

from benchmarks.chromium import NARROW, WIDE, Visit, visit

pytestmark = pytest.mark.slow
HEAVIEST = 60_000_000
DATA = '<script type="application/json" id="report-data">'


def weight(seen: Visit) -> int:
    """Return the bytes of all that the page took from disk."""
    files = {urlsplit(url).path for url in seen.requests if url.startswith("file:")}
    return sum(Path(name).stat().st_size for name in files)


def scroll_through(seen: Visit) -> None:
    """Show every part of the page once."""
    height = seen.page.evaluate("document.documentElement.scrollHeight")
    for y in range(0, height, 700):
        seen.page.evaluate(f"scrollTo(0, {y})")
        seen.page.wait_for_timeout(30)
    seen.show_scene()


@pytest.mark.parametrize("size", [WIDE, NARROW], ids=["wide", "narrow"])
def test_the_page_opens_offline_and_axe_finds_no_violation(
    chromium: Browser, report: Path, size: tuple[int, int]
) -> None:
    with visit(chromium, report, size) as seen:
        scroll_through(seen)
        assert {url.split(":")[0] for url in seen.requests} <= {"file", "data", "blob"}
        assert {urlsplit(url).path for url in seen.requests if url.startswith("file:")} == {
            str(report)
        }
        assert weight(seen) <= HEAVIEST
        wider = seen.page.evaluate("document.documentElement.scrollWidth - innerWidth")
        assert wider <= 0, f"the page is {wider} px wider than its screen"
        seen.page.evaluate(
            "document.querySelectorAll('details').forEach((one) => { one.open = true })"
        )
        found = violations(seen)
        assert not found, "\n".join(found)
        assert seen.messages == []


def test_each_layer_of_the_map_changes_its_pixels(page: Visit) -> None:
    panel, shown = page.page.locator("#map-panel"), page.page.locator("#map")
    shown.scroll_into_view_if_needed()
    controls = panel.locator("input[type=radio]:not(:checked), input[type=checkbox]")
    names = [
        controls.nth(k).evaluate("one => one.labels[0].textContent.trim()")
        for k in range(controls.count())
    ]
    assert len(names) >= 6
    before = picture_at_rest(shown)
    for name in names:
        panel.get_by_label(name, exact=True).click()
        after = picture_at_rest(shown)
        assert share_changed(before, after) > 0.0005, name
        before = after


def come_closer(seen: Visit) -> Locator:
    """Zoom the map in, and return it once it is at rest."""
    shown = seen.page.locator("#map")
    shown.scroll_into_view_if_needed()
    for _ in range(6):
        seen.page.locator(".leaflet-control-zoom-in").click()
        picture_at_rest(shown)
    return shown


HIDE_TILES = "document.querySelectorAll('.map-tile').forEach((one) => (one.style.display = 'none'))"


def test_a_mosaic_sharpens_when_one_comes_closer(
    chromium: Browser, tiled: Path, tmp_path: Path
) -> None:
    with visit(chromium, tiled) as seen:
        shown = come_closer(seen)
        for tile in shown.locator(".map-tile").all():
            assert tile.evaluate("one => one.decode().then(() => one.naturalWidth)") > 0
        sharp = picture_at_rest(shown)
        seen.page.evaluate(HIDE_TILES)
        blurred = picture_at_rest(shown)
        assert share_changed(sharp, blurred) > 0.05
        assert seen.messages == []
    # handed on without its folder, the page shows what it holds itself
    alone = tmp_path / "index.html"
    alone.write_bytes(tiled.read_bytes())
    with visit(chromium, alone) as seen:
        shown = come_closer(seen)
        seen.page.wait_for_function("document.querySelectorAll('.map-tile').length === 0")
        assert share_changed(picture_at_rest(shown), blurred) < 0.001


def test_a_click_on_an_object_of_the_map_opens_its_card(page: Visit) -> None:
    number = page.page.locator("#map .map-number", has_text="1").first
    number.scroll_into_view_if_needed()
    assert not page.page.locator("#card").is_visible()
    number.click()
    card = page.page.locator("#card")
    assert card.is_visible()
    assert card.locator("h3").inner_text().startswith("1 ·")
    page.page.keyboard.press("Escape")
    assert not card.is_visible()


@pytest.mark.parametrize("size", [WIDE, NARROW], ids=["wide", "narrow"])
def test_numbers_of_neighbouring_objects_stand_apart(
    chromium: Browser, report: Path, tmp_path: Path, size: tuple[int, int]
) -> None:
    """All objects within 3 cm of the first: each number keeps 24 pixels to itself (WCAG 2.5.8)."""
    beside = tmp_path / "index.html"
    beside.write_text(with_objects_side_by_side(report.read_text(), step_m=0.01))
    with visit(chromium, beside, size) as seen:
        numbers = seen.page.locator("#map .map-number")
        boxes = [numbers.nth(k).bounding_box() for k in range(numbers.count())]
        assert len(boxes) >= 4
        middles = [
            (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2) for box in boxes if box
        ]
        assert min(math.dist(a, b) for a, b in combinations(middles, 2)) >= 24
        assert not violations(seen)
        assert seen.messages == []


def with_objects_side_by_side(page: str, step_m: float) -> str:
    """Return the page with its objects moved beside the first on the map, a step between each and
    the next.
    """
    head, start, rest = page.partition(DATA)
    text, end, tail = rest.partition("</script>")
    data = json.loads(text)
    x, y = data["objects"][0]["at"]
    for number, found in enumerate(data["objects"]):
        found["at"] = [x + number * step_m, y]
    return head + start + json.dumps(data).replace("<", "\\u003c") + end + tail


def test_a_click_in_the_table_opens_the_card(page: Visit) -> None:
    page.page.locator("#row-2 a[data-action=card]").click()
    assert page.page.locator("#card h3").inner_text().startswith("2 ·")


def test_five_hundred_objects_sort_moving_each_row_once(chromium: Browser, crowded: Path) -> None:
    """How long it takes is measured by benchmarks.page; here is counted what it costs."""
    with visit(chromium, crowded) as seen:
        assert seen.page.locator("#object-table tbody tr").count() == OBJECTS
        for direction in ("ascending", "descending"):
            moved = seen.page.evaluate("""async () => {
              let added = 0
              const body = document.querySelector('#object-table tbody')
              const watch = new MutationObserver((records) => {
                for (const one of records) added += one.addedNodes.length })
              watch.observe(body, { childList: true, subtree: true })
              const headings = [...document.querySelectorAll('#object-table thead button')]
              headings.find((one) => one.textContent.trim() === 'Height').click()
              await new Promise((done) => setTimeout(done))
              watch.disconnect()
              return added
            }""")
            assert moved == OBJECTS
            column = seen.page.evaluate("""() => {
              const headings = [...document.querySelectorAll('#object-table thead th')]
              const heading = headings.find((one) => one.ariaSort)
              const index = heading.cellIndex
              const rows = [...document.querySelectorAll('#object-table tbody tr')]
              const values = rows.map((row) => Number(row.cells[index].dataset.value))
              return [heading.ariaSort, heading.textContent.trim(), values]
            }""")
            assert column[:2] == [direction, "Height"]
            assert column[2] == sorted(column[2], reverse=direction == "descending")
            assert len(set(column[2])) == OBJECTS
        assert seen.messages == []
        assert weight(seen) <= HEAVIEST


def test_without_javascript_the_page_has_objects_and_plan(chromium: Browser, report: Path) -> None:
    context = chromium.new_context(java_script_enabled=False)
    try:
        page = context.new_page()
        page.goto(report.as_uri())
        assert (
            page.locator("article.card").count()
            == page.locator("#object-table tbody tr").count()
            > 0
        )
        assert page.locator("#plan svg.plan").is_visible()
        assert not page.locator("#map").is_visible()
    finally:
        context.close()


def test_the_keyboard_sorts_opens_a_card_and_returns(
    page: Visit,
) -> None:
    table, focused = (
        page.page.locator("#object-table"),
        "document.activeElement.closest('tr')?.id ?? ''",
    )
    heading = table.locator("thead button", has_text="Height").first
    heading.focus()
    for direction in ("ascending", "descending"):
        page.page.keyboard.press("Enter")
        assert (
            table.locator("thead th", has_text="Height").first.get_attribute("aria-sort")
            == direction
        )
    table.locator("#row-2 a[data-action=card]").focus()
    page.page.keyboard.press("Enter")
    assert page.page.locator("#card h3").inner_text().startswith("2 ·")
    page.page.keyboard.press("Escape")
    assert not page.page.locator("#card").is_visible()
    assert page.page.evaluate(focused) == "row-2"


def test_the_map_moves_and_zooms_by_button_and_keyboard(page: Visit) -> None:
    shown = page.page.locator("#map")
    shown.scroll_into_view_if_needed()
    before = picture_at_rest(shown)
    page.page.locator("#map .leaflet-control-zoom-in").click()
    zoomed = picture_at_rest(shown)
    assert share_changed(before, zoomed) > 0.05
    shown.focus()
    for key in ("+", "ArrowRight"):
        before = zoomed
        page.page.keyboard.press(key)
        zoomed = picture_at_rest(shown)
        assert share_changed(before, zoomed) > 0.02, key
