# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Patches of the hull that the DVL saw again bound the drift where no image does."""
