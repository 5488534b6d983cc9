# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The bytes of log formats. Lengths are checked before use.

Formats of one maker are in `readers/<maker>/`.
"""
