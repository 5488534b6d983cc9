# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The installed Chromium, driven by playwright-core: its wheel brings the driver, the browser comes
from the system.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, BrowserContext, Locator, Page, sync_playwright

NAMES = ("chromium", "google-chrome-stable", "google-chrome", "chromium-browser")
FLAGS = (
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--force-color-profile=srgb",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
)
WIDE, NARROW = (1280, 900), (390, 844)
PATIENCE_MS = 120_000


class NoBrowserError(RuntimeError):
    """There is no Chromium on this machine."""


def find_browser() -> str:
    """Return the path of a Chromium or Chrome. On Ubuntu `chromium` is a stub that starts a snap,
    which is no use without snapd: Chrome serves there. Raises NoBrowserError.
    """
    for name in NAMES:
        path = shutil.which(name)
        if path is not None and not _is_snap_stub(Path(path)):
            return path
    raise NoBrowserError(
        "no Chromium was found: apt-get install chromium (Debian), or Google Chrome where "
        "chromium is a snap (Ubuntu)"
    )


def _is_snap_stub(path: Path) -> bool:
    target = path.resolve()
    if target.name == "snap":
        return True
    with target.open("rb") as file:
        head = file.read(4096)
    return head.startswith(b"#!") and b"/snap/" in head


@contextmanager
def browser() -> Iterator[Browser]:
    """Start a browser without a window."""
    path = find_browser()
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=path, args=list(FLAGS))
        try:
            yield chromium
        finally:
            chromium.close()


class Visit:
    """A page opened from disk with the network off, and what it said on its console."""

    def __init__(self, context: BrowserContext, page: Page, report: Path) -> None:
        self.page, self.report = page, report
        self.messages: list[str] = []
        self.requests: list[str] = []
        page.on("console", lambda message: self.messages.append(f"{message.type}: {message.text}"))
        page.on("pageerror", lambda error: self.messages.append(f"error: {error}"))
        page.on("request", lambda request: self.requests.append(request.url))
        page.on("crash", lambda _: self.messages.append("error: the page crashed"))
        page.set_default_timeout(PATIENCE_MS)
        context.set_offline(True)
        page.goto(report.as_uri(), wait_until="load")

    def show_scene(self) -> Locator:
        """Scroll to the 3-D view and wait until it is there or has given up."""
        scene = self.page.locator("#scene")
        scene.scroll_into_view_if_needed()
        self.page.wait_for_selector("#scene[data-state]")
        return scene


@contextmanager
def visit(
    chromium: Browser, report: Path, size: tuple[int, int] = WIDE, script: str = ""
) -> Iterator[Visit]:
    """Open a report in a context of its own. script: runs before those of the page."""
    context = chromium.new_context(
        viewport={"width": size[0], "height": size[1]}, reduced_motion="reduce"
    )
    if script:
        context.add_init_script(script)
    try:
        yield Visit(context, context.new_page(), report)
    finally:
        context.close()
