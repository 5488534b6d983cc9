# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Logs of Oculus ViewPoint: finding their items, and reading their pings."""
