# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One reader per log format, all behind `protocol.Log`: a module, or a folder per maker."""
