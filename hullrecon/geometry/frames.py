# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The closed lists of coordinate frames and of cameras (docs/concepts.md), and global axes."""

from __future__ import annotations

from enum import StrEnum

import numpy as np

# From east, north, up to north, east, down
NED_FROM_ENU = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])


class Frame(StrEnum):
    """Coordinate frames by the letter that deliverables and formulas use."""

    GLOBAL = "g"
    VEHICLE = "v"
    TRAY = "s"
    DVL = "d"
    CAMERA_TOP = "ct"
    CAMERA_BOTTOM = "cb"
    SONAR = "o"
    HULL = "M"


class Camera(StrEnum):
    """The cameras of a rig, in the order of the columns of a record's `image` (n, 2)."""

    TOP = "top"
    BOTTOM = "bottom"

    @property
    def column(self) -> int:
        """The camera's column in `Trajectory.image`: 0 top, 1 bottom."""
        return tuple(Camera).index(self)

    @property
    def key(self) -> str:
        """Name of the camera's topic, files and folders: `camera_top`."""
        return f"camera_{self.value}"

    @property
    def section(self) -> str:
        """The camera's table in dive.toml: `camera.top`."""
        return f"camera.{self.value}"
