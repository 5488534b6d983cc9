# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Places recognised by how they look, where the path does not know where to search for them."""
