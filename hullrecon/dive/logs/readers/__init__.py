# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One reader a format of log, all behind `protocol.Log`: a module, or a folder of its maker's with
the bytes beside it.
"""
