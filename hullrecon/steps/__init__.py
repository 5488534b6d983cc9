# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The chain, one file per step. Each reads artifacts, calls the library and writes an artifact."""
