# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find the sensor that contradicts the others, from what they measured of one motion."""
