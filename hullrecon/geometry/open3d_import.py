# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Import open3d without what only its views in a browser need."""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any

# What open3d.visualization asks of them as it is imported. They are a second of the second and a
# half that open3d takes.
_OF_VIEWS = {
    "dash": ("html", "dcc", "Dash"),
    "plotly": ("graph_objects",),
    "plotly.graph_objects": (),
}


def import_open3d() -> Any:
    """Import open3d, and neither dash nor plotly unless they are there already.

    Then open3d.visualization.draw_plotly cannot be called in this process.
    """
    absent = [name for name in _OF_VIEWS if name not in sys.modules]
    for name in absent:
        sys.modules[name] = ModuleType(name)
        for attribute in _OF_VIEWS[name]:
            setattr(sys.modules[name], attribute, None)
    try:
        import open3d
    finally:
        for name in absent:
            del sys.modules[name]
    return open3d
