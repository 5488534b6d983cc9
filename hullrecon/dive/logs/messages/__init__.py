# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Messages of ROS 1 and 2 to samples, by types of the log or bundled ones."""
