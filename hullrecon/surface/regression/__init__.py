# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Offsets from a base surface, from observations to a field with its sigma."""
