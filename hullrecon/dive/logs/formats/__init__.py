# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The bytes of log formats (others are in `readers/<maker>/`); lengths are checked before use."""
