# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One file a question, JSON out. Wall-clock figures belong here and not in tests."""
