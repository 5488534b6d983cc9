# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Which points of two sets are the same: nearest neighbour, joint compatibility, at random."""
