# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What a run found, in a few lines at its end."""

from __future__ import annotations

import json
from pathlib import Path


def delivery_lines(deliver: Path) -> list[str]:
    """Return the findings of the report and the paths of report and deliverables; none when nothing is delivered."""
    if not deliver.is_dir():
        return []
    report = deliver / "report" / "index.html"
    places = [f"report: {report}"] if report.is_file() else []
    return [*_findings(deliver / "summary.json"), *places, f"deliverables: {deliver}"]


def _findings(summary: Path) -> list[str]:
    """Return the sentences at the head of the report; none when the summary is missing or of another form."""
    try:
        lines = json.loads(summary.read_text(encoding="utf-8"))["summary"]
    except (OSError, ValueError, KeyError, TypeError):
        return []
    return [str(line) for line in lines] if isinstance(lines, list) else []
