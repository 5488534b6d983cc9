# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How uncertain an area on the CAD model is that a sensor saw, for the hull may lie elsewhere than
its pose says.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import Poses
from hullrecon.records.solution import HullPose
from hullrecon.typing import Array


@dataclass(frozen=True, kw_only=True)
class HullError:
    """An error (6,) of the hull pose, as in its covariance, and what becomes of the dive's points
    and poses in M under it.
    """

    hull_pose: HullPose
    error: Array

    def points(self, points: Array) -> Array:
        """Return where points (n, 3) of the dive lie in M if the hull pose is off by the error."""
        center = self.hull_pose.survey_center
        shift = self.hull_pose.global_from_hull.rotation.inv().apply(self.error[:3]).reshape(3)
        return np.asarray(self._turn().apply(points - center - shift) + center)

    def poses(self, poses: Poses) -> Poses:
        """Return poses (n) of the dive in M if the hull pose is off by the error."""
        return Poses((self._turn() * poses.rotation).as_quat(), self.points(poses.translation))

    def _turn(self) -> Rotation:
        return Rotation.from_rotvec(-self.error[3:])


def area_sigma(area_if: Callable[[HullError], float], hull_pose: HullPose) -> float:
    """Return one sigma, m2, of an area that is `area_if(error)` under an error of the hull pose: by
    central differences of one sigma along the axes of the covariance.
    """
    variance, axes = np.linalg.eigh(hull_pose.covariance)
    changes = []
    for error in (axes * np.sqrt(np.maximum(variance, 0.0))).T:
        more, less = (area_if(HullError(hull_pose=hull_pose, error=way * error)) for way in (1, -1))
        changes.append((more - less) / 2)
    return round(float(np.linalg.norm(changes)), 4)
