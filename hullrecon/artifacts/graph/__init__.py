# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What a step declares, what decides its result, and whether its artifact is up to date."""
