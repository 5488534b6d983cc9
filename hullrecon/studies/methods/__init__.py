# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The three methods of [Ozog2016 ch. 4] side by side: solves, table and figures."""
