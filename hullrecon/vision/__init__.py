# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Features, pair proposal, correspondence, two-view geometry and tracks."""
