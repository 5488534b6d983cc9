# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Run stages and chains, here, in worker processes or on a cluster."""
