# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the pose graph and the bundle adjustment share: tables of navigation, variances."""
