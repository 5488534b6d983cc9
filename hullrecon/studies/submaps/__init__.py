# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Filters, submaps and their joining in the plane, as [Aulinas2011] has them."""
