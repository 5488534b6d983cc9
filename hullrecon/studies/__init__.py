# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Reproduce the sources: the published variants of the method and the published figures."""
