# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Clocks that do not agree: found in what the sensors measured of one motion, and put right."""
