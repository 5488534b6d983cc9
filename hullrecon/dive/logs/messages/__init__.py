# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Messages of ROS 1 and 2 to samples: types from the log or bundled, and one small function a
message type.
"""
