# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""From images to tracks: features, stereo, pairs to compare, links between images, places."""
