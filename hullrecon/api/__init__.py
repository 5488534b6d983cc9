# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The commands as functions, for notebooks and scripts: see examples/."""

from hullrecon.api.commands import (
    MethodComparison,
    compare_methods,
    diff,
    draw_figures,
    evaluate,
    export_colmap,
    run_dive,
)
from hullrecon.api.dive_run import DiveRun, open_dive

__all__ = [
    "DiveRun",
    "MethodComparison",
    "compare_methods",
    "diff",
    "draw_figures",
    "evaluate",
    "export_colmap",
    "open_dive",
    "run_dive",
]
