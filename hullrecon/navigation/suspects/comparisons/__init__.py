# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Residuals of one motion that two sensors measured: a module for each pair of sensors."""
