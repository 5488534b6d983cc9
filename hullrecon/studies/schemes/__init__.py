# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Three ways to put submaps together, step by step [Aulinas2011 2.2, Figs 2.3 to 2.5]."""
