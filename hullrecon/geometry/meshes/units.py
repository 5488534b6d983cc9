# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Units of length in which a mesh may be written."""

from __future__ import annotations

SHORTEST_M, LONGEST_M = 5.0, 500.0  # lengths that a ship's hull may have
METRES_PER_UNIT = {"m": 1.0, "mm": 0.001, "cm": 0.01, "ft": 0.3048, "in": 0.0254}
UNIT_NAMES = {"m": "metres", "mm": "millimetres", "cm": "centimetres", "ft": "feet", "in": "inches"}
