# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stands for WeasyPrint where Pango is not installed: runs then write no PDF, which takes long."""

raise OSError("cannot load library 'libpango-1.0-0'")
