# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Underwater hull inspection: from a vehicle's logs and the ship's CAD model to the hull as found.

In a notebook: `hullrecon.run_dive`, `evaluate`, `diff`, `compare_methods`, `draw_figures`,
`export_colmap` (hullrecon.api; examples/). They are loaded when they are first used, so that
importing the package costs nothing.
"""

import importlib

__version__ = "0.1.0"
_API = (
    "compare_methods",
    "diff",
    "draw_figures",
    "evaluate",
    "export_colmap",
    "open_dive",
    "run_dive",
)
__all__ = ["__version__", *_API]


def __getattr__(name: str) -> object:
    """Return a function of hullrecon.api. Raises AttributeError for another name."""
    if name not in _API:
        raise AttributeError(f"module 'hullrecon' has no attribute {name!r}")
    return getattr(importlib.import_module("hullrecon.api"), name)
