# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The 3-D view: every control changes pixels, an object's number opens its card, and a browser
without WebGL gets a picture.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from browser.pictures import Picture, picture_at_rest, share_changed
from playwright.sync_api import Browser, Locator
from scipy import ndimage

from benchmarks.chromium import NARROW, Visit, visit

pytestmark = pytest.mark.slow
NUMBER = (200, 84, 27)  # the colour of objects
NO_WEBGL = """
const real = HTMLCanvasElement.prototype.getContext
HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
  return kind.startsWith('webgl') ? null : real.call(this, kind, ...more)
}"""


@pytest.fixture
def scene(page: Visit) -> Locator:
    shown = page.show_scene()
    assert shown.get_attribute("data-state") == "shown", shown.get_attribute("data-reason")
    return shown.locator("canvas")


def test_the_hull_is_seen_in_colour_and_layers_can_be_taken_away(
    page: Visit, scene: Locator
) -> None:
    before = picture_at_rest(scene)
    assert (np.ptp(before, axis=2) > 40).mean() > 0.05
    boxes = page.page.locator(".scene-panel input[type=checkbox]")
    names = [boxes.nth(k).get_attribute("id") for k in range(boxes.count())]
    assert names == ["scene-found", "scene-cad", "scene-ship", "scene-objects", "scene-path"]
    for name in names:
        page.page.locator(f"#{name}").click()
        after = picture_at_rest(scene)
        assert share_changed(before, after) > 0.0005, name
        before = after


def test_each_picture_can_be_laid_on_the_hull(page: Visit, scene: Locator) -> None:
    choices = page.page.locator("#scene-picture option").evaluate_all(
        "all => all.map((one) => one.value)"
    )
    assert {"optical", "sonar", "form", "plain"} <= set(choices)
    seen: list[Picture] = []
    for choice in choices:
        page.page.select_option("#scene-picture", choice)
        page.page.wait_for_timeout(400)
        now = picture_at_rest(scene)
        assert all(share_changed(now, other) > 0.005 for other in seen), choice
        seen.append(now)


def test_the_slider_goes_from_cad_model_to_hull_as_found(page: Visit, scene: Locator) -> None:
    page.page.select_option("#scene-picture", "plain")
    found = picture_at_rest(scene)
    page.page.locator("#scene-factor").fill("20")
    assert "×20" in page.page.locator(".scene-panel").inner_text()
    relief = picture_at_rest(scene)
    page.page.locator("#scene-shape").fill("0")
    assert page.page.locator("#scene-shape").get_attribute("aria-valuetext") == "CAD model"
    cad_model = picture_at_rest(scene)
    assert share_changed(found, relief) > 0.01
    assert share_changed(cad_model, relief) > 0.01
    assert share_changed(cad_model, found) > 0.001
    page.page.locator("#scene-factor").fill("1")
    # on the CAD model there is nothing to exaggerate
    assert share_changed(cad_model, picture_at_rest(scene)) == 0


def test_wheel_and_keys_move_the_view_a_button_resets_it(page: Visit, scene: Locator) -> None:
    home = picture_at_rest(scene)
    scene.hover()
    page.page.mouse.wheel(0, -400)
    nearer = picture_at_rest(scene)
    assert share_changed(home, nearer) > 0.02
    scene.focus()
    for key in ("ArrowLeft", "ArrowUp", "-"):
        before = picture_at_rest(scene)
        page.page.keyboard.press(key)
        assert share_changed(before, picture_at_rest(scene)) > 0.005, key
    page.page.locator(".scene-panel button").click()
    assert share_changed(home, picture_at_rest(scene)) < 0.001


def test_a_click_on_a_number_opens_the_card_of_the_object(page: Visit, scene: Locator) -> None:
    page.page.locator("#scene-picture").select_option("plain")
    shown = picture_at_rest(scene)
    parts, _ = ndimage.label(np.abs(shown - NUMBER).max(axis=2) < 12)
    sizes = np.bincount(parts.ravel())
    sizes[0] = 0
    y, x = ndimage.center_of_mass(parts == sizes.argmax())
    scene.click(position={"x": float(x), "y": float(y)})
    card = page.page.locator("#card")
    assert card.is_visible()
    assert "Height above the hull" in card.inner_text()


def test_the_scale_bar_is_round_and_grows_when_closer(page: Visit, scene: Locator) -> None:
    bar = page.page.locator(".scene-bar")
    picture_at_rest(scene)
    first = bar.inner_text().strip()
    assert first.split()[0].rstrip("0").rstrip(".") in {"1", "2", "5"}
    for _ in range(8):
        scene.press("+")
    picture_at_rest(scene)
    assert bar.inner_text().strip() != first


def test_a_browser_without_webgl_shows_a_sentence_and_a_picture(
    chromium: Browser, report: Path
) -> None:
    with visit(chromium, report, script=NO_WEBGL) as seen:
        scene = seen.show_scene()
        assert scene.get_attribute("data-state") == "none"
        assert scene.get_by_text("no WebGL").is_visible()
        assert scene.locator("svg.ship").is_visible()
        assert scene.locator("canvas").count() == 0
        assert seen.messages == []


def test_a_small_screen_has_the_panel_below_the_view(chromium: Browser, report: Path) -> None:
    with visit(chromium, report, NARROW) as seen:
        scene = seen.show_scene()
        outer = scene.bounding_box()
        button = scene.locator(".scene-panel button").bounding_box()
        assert outer is not None
        assert button is not None
        assert button["y"] + button["height"] <= outer["y"] + outer["height"]
        assert (
            scene.locator(".scene-panel").evaluate("one => one.scrollHeight - one.clientHeight")
            <= 0
        )


def optical_close_up(seen: Visit) -> Picture:
    """Lay the camera mosaic on the hull, come close, and return the view."""
    canvas = seen.show_scene().locator("canvas")
    seen.page.select_option("#scene-picture", "optical")
    for _ in range(12):
        canvas.press("+")
    seen.page.wait_for_timeout(1000)  # until the view has rested and its tiles are there
    return picture_at_rest(canvas)


def test_a_mosaic_on_the_hull_sharpens_when_one_comes_closer(
    chromium: Browser, tiled: Path, tmp_path: Path
) -> None:
    with visit(chromium, tiled) as seen:
        sharp = optical_close_up(seen)
        assert seen.page.locator("#scene canvas").get_attribute("data-level") == "0"
        assert seen.messages == []
    # handed on without its folder, the page shows what it holds itself
    alone = tmp_path / "index.html"
    alone.write_bytes(tiled.read_bytes())
    with visit(chromium, alone) as seen:
        blurred = optical_close_up(seen)
        assert seen.page.locator("#scene canvas").get_attribute("data-level") == "-1"
    assert share_changed(sharp, blurred) > 0.05
