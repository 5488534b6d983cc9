# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The stereo rig before a bumpy wall of tests/vision."""

from vision.conftest import look, rig, wall

__all__ = ["look", "rig", "wall"]
