# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stages, workspace, manifests, staleness and lock. Knows nothing of hulls."""
