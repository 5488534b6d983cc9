# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What is wrong with a package or a dive, by code and severity, and the words for it."""
