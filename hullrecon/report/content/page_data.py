# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the page's script is given, as JSON in the page: places on the map; pictures stay in the HTML, named by their id.

Members: `map` (None without a chart), `objects`, and `scene` (None where nothing is shown in 3-D), which report/web/src/map.js,
cards.js and scene.js read.
"""

from __future__ import annotations

import json
from collections.abc import Mapping

from hullrecon.report.survey import Survey

PageData = Mapping[str, object]


def page_data(survey: Survey) -> PageData:
    """Return the document of #report-data."""
    return {"frame": str(survey.track.frame), "map": None, "objects": [], "scene": None}


def script_json(data: PageData) -> str:
    """Return JSON that cannot end the script element it stands in. Raises ValueError for a NaN."""
    text = json.dumps(data, allow_nan=False, ensure_ascii=False, separators=(",", ":"), sort_keys=True)
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
