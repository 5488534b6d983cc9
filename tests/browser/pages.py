# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What holds of every page."""

from __future__ import annotations

from axe_playwright_python.sync_playwright import Axe

from benchmarks.chromium import Visit

TAGS = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"]


def violations(seen: Visit) -> list[str]:
    """Return what axe finds on a page as it stands now, by WCAG 2.2 AA."""
    found = (
        Axe()
        .run(seen.page, options={"runOnly": {"type": "tag", "values": TAGS}})
        .response["violations"]
    )
    return [f"{v['id']}: {node['html'][:160]}" for v in found for node in v["nodes"]]
