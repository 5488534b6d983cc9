# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The commands, a module for each or for a few that share their options; the table of all is
cli/command_table.py.
"""
