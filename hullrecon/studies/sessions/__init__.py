# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Many sessions before one hull in one graph, and graphs that forget nodes [Ozog2016 2.4]."""
