# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Words: contradictions between sensors, mounts and clocks."""

from __future__ import annotations

from hullrecon.findings.logs import Words

WARNINGS: dict[str, Words] = {
    "clocks-apart": "{stream} and {other} do not overlap in time: one of the clocks is off by "
    "{seconds:.1f} s or more",
    "imu-single-reading": "the IMU gave a single reading, which tells no attitude",
    "imu-upside-down": 'imu: gravity pulls upward with imu.frame = "{frame}"; is it "{other}"?',
    "imu-gravity-tilted": "imu: gravity is {degrees:.0f} degrees off the vertical: is "
    "imu.frame right?",
    "velocities-without-attitude": "{percent:.0f} % of the DVL's velocities lie where no attitude "
    "was read: a run cannot use them",
    "imu-without-velocities": "the IMU was read for {seconds:.1f} s under water before the first "
    "or after the last velocity of the DVL: no image tells where the vehicle was then, and a run "
    "leaves that part out",
    "ranges-above-water": "{percent:.0f} % of the DVL's returns would lie above the water: are "
    "dvl.mount and the tray's angle right?",
    "dvl-against-depth": "the DVL's downward speed runs against that of the pressure sensor: is "
    "dvl.mount turned over?",
    "dvl-unlike-depth": "the DVL's downward speed does not follow that of the pressure sensor: are "
    "dvl.mount and its beams right?",
    "camera-dvl-apart": "camera.top looks {degrees:.0f} degrees away from where the DVL looks: is "
    "one of the mounts wrong?",
    "baseline-implausible": "the cameras are {metres:.3f} m apart: is camera.bottom.pose_in_top in "
    "metres?",
    "mounts-disagree": "imu.mount_deg and dvl.mount turn the DVL's axes {degrees:.0f} degrees "
    "apart, and both say how the one DVL sits in the vehicle: is one of them wrong?",
}
