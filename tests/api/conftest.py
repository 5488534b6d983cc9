# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The wall of the evaluation's tests, here as a dive with a short chain."""

from evaluation.conftest import deliver, package, returns, rig, solution

__all__ = ["deliver", "package", "returns", "rig", "solution"]
