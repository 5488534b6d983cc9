# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The path before adjustment: clocks, faulty sensors, dead reckoning, odometry, pose graph."""
