# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What two sensors measured of one motion, as residuals: a module for each pair of sensors."""
