# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The cameras of a rig as pair matching asks for them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses
from hullrecon.rig import SensorRig
from hullrecon.typing import Array


@dataclass(frozen=True)
class CameraRig:
    """One camera (mono) or two of a SensorRig."""

    rig: SensorRig

    @property
    def top_from_bottom(self) -> Poses | None:
        """Return T_ct_cb, one pose; None for a mono rig."""
        return self.rig.top_from_bottom if Camera.BOTTOM in self.rig.cameras else None

    @property
    def stereo(self) -> bool:
        """Return whether there is a bottom camera with a pose and a calibration."""
        return self.top_from_bottom is not None

    @property
    def baseline_m(self) -> float:
        """Return the distance of the cameras; 1 for a mono rig, whose points have no length."""
        pose = self.top_from_bottom
        return 1.0 if pose is None else float(np.linalg.norm(pose.translation[0]))

    def model(self, camera: Camera) -> CameraModel:
        """Return a camera's calibration. Raises ValueError for a bottom camera that is not there."""
        if camera is Camera.BOTTOM and not self.stereo:
            raise ValueError("this rig has no bottom camera")
        return self.rig.camera_models[camera]

    def focal_px(self, camera: Camera) -> float:
        """Return how many pixels a unit of ideal coordinates is, the mean of both axes."""
        model = self.model(camera)
        return 0.5 * (model.fx + model.fy)

    def from_top(self, camera: Camera) -> Array:
        """Return the motion (4, 4) of points of the top camera into that camera; the identity for a
        mono rig.
        """
        pose = self.top_from_bottom
        if camera is Camera.TOP or pose is None:
            return np.eye(4)
        return np.asarray(pose.inverse().matrix()[0])
