# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Makes docs/images/report.png and report_phone.png, the README's pictures of a report, with a
headless Chromium:

hullrecon run sample_data/demo --runs RUNS
python docs/figures/report_screenshot.py RUNS/demo/deliver/report/index.html
"""

from __future__ import annotations

import argparse
import html
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image
from PIL.PngImagePlugin import PngInfo

IMAGES = Path(__file__).resolve().parents[1] / "images"
# ship, verdict, map and 3-D; on a phone up to the map
SIZES = {"report.png": (1280, 2735), "report_phone.png": (390, 2376)}
COLOURS = 256
# of the text in a picture that says which report it shows: tests/end_to_end/test_readme.py compares
# it
KEY = "Report"


def main() -> int:
    """Write the pictures; return 1 where no browser is installed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("page", type=Path, help="report/index.html of a run")
    page = parser.parse_args().page.resolve()
    browser = (
        shutil.which("chromium")
        or shutil.which("chromium-browser")
        or shutil.which("google-chrome")
    )
    if browser is None:
        print("no Chromium was found", file=sys.stderr)
        return 1
    for name, size in SIZES.items():
        take_picture(browser, page, size, IMAGES / name)
        print(f"{IMAGES / name}: {(IMAGES / name).stat().st_size / 1e3:.0f} kB")
    return 0


def take_picture(browser: str, page: Path, size: tuple[int, int], target: Path) -> None:
    """Write a picture of the top of a page at that window size, with few colours and the words of
    the page's summary.
    """
    with tempfile.TemporaryDirectory() as folder:
        shot = Path(folder) / "shot.png"
        flags = [
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--hide-scrollbars",
            f"--user-data-dir={folder}/profile",
        ]
        flags += ["--no-first-run", "--disable-background-networking", "--virtual-time-budget=5000"]
        command = [
            browser,
            *flags,
            f"--window-size={size[0]},{size[1]}",
            f"--screenshot={shot}",
            page.as_uri(),
        ]
        subprocess.run(command, check=True, capture_output=True)
        with Image.open(shot) as picture:
            write_picture(picture, target, summary_of(page.read_text(encoding="utf-8")))


def write_picture(picture: Image.Image, target: Path, summary: str) -> None:
    """Write a picture with few colours that says which report it shows."""
    words = PngInfo()
    words.add_itxt(KEY, summary)
    target.parent.mkdir(exist_ok=True)
    picture.convert("RGB").quantize(COLOURS, kmeans=4).save(target, optimize=True, pnginfo=words)


def summary_of(page: str) -> str:
    """Return the words of a report's summary, without those of the ship's picture."""
    section = re.split(r'<section id="summary"[^>]*>', page)[1].split("</section>")[0]
    words = re.sub(r"(?s)<svg.*?</svg>|<[^>]*>", " ", section)
    return re.sub(r"\s+", " ", html.unescape(words)).strip()


if __name__ == "__main__":
    sys.exit(main())
