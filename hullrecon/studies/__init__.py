# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0

"""Reproduce the sources: the published variants of the method and the published figures."""

from hullrecon.studies.run import MethodComparison, compare_methods, draw_figures

__all__ = ["MethodComparison", "compare_methods", "draw_figures"]
