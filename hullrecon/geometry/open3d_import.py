# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Import open3d without the packages that only its views in a browser need."""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any

# These packages, with the attributes that open3d.visualization takes from them when it is imported.
# Without them the import takes half a second instead of one and a half.
_OF_VIEWS = {
    "dash": ("html", "dcc", "Dash"),
    "plotly": ("graph_objects",),
    "plotly.graph_objects": (),
}


def import_open3d() -> Any:
    """Import open3d without dash and plotly, unless these are imported already.

    Empty modules stand in for them during the import. open3d.visualization.draw_plotly cannot be
    called in this process then.
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
