# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Records of each sensor, stacked from its samples: one set of units, NaN for lost values."""
