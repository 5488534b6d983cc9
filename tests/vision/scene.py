# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Rigs of cameras without a vehicle, and a walk through nodes by stereo odometry."""

import numpy as np

from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import identity
from hullrecon.rig import Rig
from hullrecon.vision.odometry import StereoOdometer
from hullrecon.vision.options import FeatureOptions, MatchOptions


def camera_rig(
    top, bottom=None, top_from_bottom=None, tray_origin=(0.0, 0.0, 0.0), tray_from_top=None
):
    """A rig of one camera or two."""
    models = {Camera.TOP: top} | ({} if bottom is None else {Camera.BOTTOM: bottom})
    return Rig(
        tray_origin=np.array(tray_origin),
        pressure_origin=np.zeros(3),
        tray_from_dvl=identity(),
        tray_from_top=tray_from_top or identity(),
        top_from_bottom=top_from_bottom,
        camera_models=models,
    )


def follow_nodes(rig, nodes, read):
    """The measured motion from each node to the next, None where there is none; read: a node's
    features by its number.
    """
    odometer = StereoOdometer(
        rig=rig, feature_options=FeatureOptions(), match_options=MatchOptions()
    )
    out, before = [], None
    for node in nodes:
        here = odometer.frame_of_features(node, read(node))
        if before is not None:
            out.append(odometer.motion(before, here))
        before = here
    return out
