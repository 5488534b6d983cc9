# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Everything in deliver/: the page and PDF, tables, point clouds, plots, schemas."""
