# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Reproduce the sources: the published variants of the method and the published figures."""

from hullrecon.studies.registry import STUDIES
from hullrecon.studies.run import (
    compare_methods,
    draw_figures,
    failure_of,
    run_and_keep,
    run_studies,
)
from hullrecon.studies.study import StudyResult

__all__ = [
    "STUDIES",
    "StudyResult",
    "compare_methods",
    "draw_figures",
    "failure_of",
    "run_and_keep",
    "run_studies",
]
