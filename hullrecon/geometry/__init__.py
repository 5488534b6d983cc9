# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Rigid motions, cameras, sonar fans, meshes, the hull chart."""
