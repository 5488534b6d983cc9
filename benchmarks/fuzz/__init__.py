# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Damage inputs of every format at random and see that each ends in a typed error, a named loss, or
the same data.
"""
