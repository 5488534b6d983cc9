# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Residuals of one motion that two sensors measured, as a function of their clock offsets."""
