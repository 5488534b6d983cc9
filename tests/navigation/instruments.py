# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The vehicle of the tests: where its instruments sit, and how well they are known."""

import numpy as np

from hullrecon.geometry.poses import from_mount
from hullrecon.navigation.sigmas import NavigationSigmas
from hullrecon.rig import Rig

RIG = Rig(
    tray_origin=np.array([0.45, 0.0, 0.1]),
    pressure_origin=np.array([-0.3, 0.1, 0.05]),
    tray_from_dvl=from_mount([0.02, -0.01, 0.08, 0.5, 89.0, 1.0]),
    tray_from_top=from_mount([0.05, 0.0, -0.02, 90.0, 0.0, 90.0]),
)
SIGMAS = NavigationSigmas(
    mount=np.array([0.01, 0.01, 0.01, 0.0087, 0.0087, 0.0087]),
    scale=0.005,
    heading_drift_rad_s=5e-6,
    tilt_bias_rad=0.0035,
    depth_bias_m=0.1,
    tray_rad=0.014,
    tilt_rad=0.00175,
    depth_m=0.02,
    range_m=0.01,
)
