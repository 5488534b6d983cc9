# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What steps hand to each other: frozen structs of arrays, written as .npz by field name."""
