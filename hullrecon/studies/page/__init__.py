# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The page of `hullrecon study run`: what the sources print and ours, side by side."""
