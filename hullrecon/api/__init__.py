# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The commands as functions, for notebooks and scripts: `hullrecon.run` and others (examples/)."""
