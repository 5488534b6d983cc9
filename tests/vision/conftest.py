# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A stereo rig before a bumpy wall, with truth: points, what both cameras of each node see of them,
one descriptor a point.
"""

from types import SimpleNamespace

import numpy as np
import pytest
from vision.scene import camera_rig

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import exp, from_rpy
from hullrecon.vision.features.extraction import Features, root_sift

CAMERA = CameraModel(640, 512, 650.0, 652.0, 321.0, 255.0, -0.06, 0.03, 0.001, -0.0005)
LOWER = CameraModel(640, 512, 655.0, 654.0, 318.0, 258.0, -0.05, 0.02, -0.0004, 0.0003)


@pytest.fixture
def rig():
    """Vertical, slightly turned against each other, 0.1 m apart."""
    return camera_rig(CAMERA, LOWER, from_rpy([0.002, 0.1, -0.001], [0.003, -0.002, 0.004]))


@pytest.fixture
def wall():
    """900 points on a wall 1.3 m ahead with 5 cm of relief, in the frame of the first node's top
    camera.
    """
    rng = np.random.default_rng(5)
    points = np.column_stack(
        [
            rng.uniform(-1.2, 2.4, 900),
            rng.uniform(-0.9, 0.9, 900),
            1.3 + 0.05 * rng.standard_normal(900),
        ]
    )
    return SimpleNamespace(
        points=points, descriptors=root_sift(rng.gamma(0.5, 1.0, (900, 128)).astype(np.float32))
    )


def features(camera, first_from_camera, wall, noise_px, rng):
    """Features of the points that the camera sees, in random order, and the points' numbers."""
    pixel = camera.project(
        first_from_camera.inverse().apply(wall.points)
    ) + noise_px * rng.standard_normal((len(wall.points), 2))
    seen = np.flatnonzero(
        (pixel > 4).all(1) & (pixel < [camera.width - 5, camera.height - 5]).all(1)
    )
    seen = rng.permutation(seen)
    table = np.column_stack([pixel[seen], np.full((len(seen), 2), 3.0)]).astype(np.float32)
    return Features(table, wall.descriptors[seen], np.full((len(seen), 3), 90, np.uint8)), seen


@pytest.fixture
def look(rig, wall):
    """look(pose6, noise_px): the node whose top camera stands at exp(pose6) in the first's."""

    def see(pose, noise_px=0.2, seed=1):
        rng = np.random.default_rng(seed)
        first_from_top = exp([pose])
        top, top_id = features(rig.model(Camera.TOP), first_from_top, wall, noise_px, rng)
        bottom, bottom_id = features(
            rig.model(Camera.BOTTOM), first_from_top @ rig.top_from_bottom, wall, noise_px, rng
        )
        return SimpleNamespace(
            pose=first_from_top, top=top, bottom=bottom, top_id=top_id, bottom_id=bottom_id
        )

    return see
