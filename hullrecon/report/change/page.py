# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""change.html: what changed, on one self-contained page."""

from __future__ import annotations

import base64

from hullrecon.records.change import HullChange
from hullrecon.report.change.chapter import change_chapter
from hullrecon.report.content.page import render_template


def change_page(change: HullChange, png: bytes) -> str:
    """Return the HTML; png: the map, which is held in it."""
    picture = "data:image/png;base64," + base64.b64encode(png).decode()
    return render_template("change.html", {"change": change_chapter(change), "change_map": picture})
