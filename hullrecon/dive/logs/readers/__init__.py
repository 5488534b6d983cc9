# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One reader a file, each for one format of log, all behind `protocol.Log`."""
