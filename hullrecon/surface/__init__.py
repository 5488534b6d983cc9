# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The hull's surface from DVL returns, or from landmarks without a DVL."""
