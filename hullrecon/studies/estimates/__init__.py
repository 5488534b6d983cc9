# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Estimates small enough to be followed by hand, and what they leave uncertain."""
