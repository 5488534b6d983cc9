# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The shell commands: read arguments, call the library, print. No mathematics."""
