# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Optical and sonar mosaics on the hull's surface: orthos, textured meshes, 3D Tiles."""
