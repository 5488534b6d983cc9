# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Records that steps exchange: frozen structs of arrays, written as .npz by field name."""
