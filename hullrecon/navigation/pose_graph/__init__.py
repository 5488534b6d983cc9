# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The vehicle's path from navigation and the relative poses that images measured."""
