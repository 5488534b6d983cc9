# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""dive.toml and calibration files of a simulated dive.

Mounts are nominal, sigmas are those of the instruments, and the initial hull pose has an error.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import Poses
from hullrecon.geometry.rotations import roll_pitch_yaw
from hullrecon.synthetic.dive import Dive
from hullrecon.synthetic.instruments import (
    DEPTH_SIGMA,
    LEAST_POSITION_SIGMA_M,
    RANGE_SIGMA,
    VELOCITY_SIGMA,
)
from hullrecon.synthetic.logs import TOPICS
from hullrecon.synthetic.options import DiveSpec
from hullrecon.synthetic.vehicle import (
    BEAMS,
    BOTTOM_IN_TOP,
    CAMERA_MOUNT,
    DVL_MOUNT,
    SONAR_ELEVATION_DEG,
    SONAR_MOUNT,
    SONAR_ORIGIN,
    TRANSPONDER,
    TRAY_ORIGIN,
)

# Sigmas that dive.toml gives for instruments of this class. Larger ones if larger errors are
# simulated.
TRAY_SIGMA_DEG = 0.8
HEADING_DRIFT_SIGMA = 1.0  # degrees an hour
DVL_SCALE_SIGMA = 0.005  # assumed by readers where the key is absent


def initial_guess(dive: Dive) -> Poses:
    """Compute the hull pose that dive.toml gives: the true one with the errors of `spec.guess`.

    Signs are drawn at random. The errors are those of the hull at the middle of the survey.
    """
    spec, random = dive.spec, dive.spec.random("guess")
    sign = random.choice([-1.0, 1.0], 4)
    middle = dive.hull.skin.middle
    shift = sign[:3] * [spec.guess.along_m, spec.guess.across_m, 0.6 * spec.guess.across_m]
    turn = np.radians(spec.guess.turn_deg) * np.array([0.3, 0.2, sign[3]])
    rotation = Poses(Rotation.from_rotvec(turn).as_quat()[None], np.zeros((1, 3)))
    # The hull turns about the survey's middle, which itself moves by the shift
    error = Poses(rotation.quaternion, middle + shift - rotation.apply(middle[None]))
    return dive.motion.global_from_hull @ error


def dive_toml(dive: Dive) -> str:
    """Write the text of dive.toml."""
    spec = dive.spec
    sections = [_head(dive), _vehicle(spec)]
    if spec.cameras.carried != "none":
        sections.append(_camera_sections(spec))
    if spec.sonar:
        sections.append(f"""[sonar]
joint = "sonar_tray"
origin = {_row(SONAR_ORIGIN)}
mount = {_row(SONAR_MOUNT)}
elevation_deg = {SONAR_ELEVATION_DEG}
""")
    if spec.positions.every_s is not None:
        sections.append(f"""[position]
origin = {_row(TRANSPONDER)}
frame = "enu"
sigma_m = {max(LEAST_POSITION_SIGMA_M, spec.positions.sigma_m)}
""")
    guess = initial_guess(dive)
    pose = [*guess.translation[0], *np.degrees(roll_pitch_yaw(guess.rotation)[0])]
    sections.append(f"""[hull]
mesh = "hull.stl"
units = "m"
pose = {_row(pose)}
pose_sigma = [1.0, 1.0, 0.3, 1.0, 1.0, 5.0]
length_overall = {spec.ship.length_m}
frame_spacing = 0.6
""")
    return "\n".join(sections)


def _head(dive: Dive) -> str:
    """Write the sections of the dive, its logs and topics."""
    spec = dive.spec
    carried = [
        "dvl",
        "imu",
        "pressure",
        "joints",
        *cameras_of(dive),
        *(["sonar"] if spec.sonar else []),
    ]
    carried += ["position"] if spec.positions.every_s is not None else []
    topics = "\n".join(f'{name} = "{TOPICS[name][0]}"' for name in carried)
    files = '["logs/dive.mcap"]' if spec.form == "mcap" else '["logs"]'
    return f"""[dive]
name = "{spec.name}"
vessel = "Simulated {spec.ship.length_m:.0f} m vessel"
date = 2026-05-04T09:30:00Z

[logs]
files = {files}

[topics]
{topics}
"""


def _vehicle(spec: DiveSpec) -> str:
    """Write the sections of tray, IMU, pressure sensor and DVL."""
    scale, drift = abs(spec.errors.dvl_scale_error), abs(spec.errors.heading_drift_deg_per_hour)
    servo_deg = float(np.hypot(spec.errors.backlash_deg, spec.errors.servo_sigma_deg))
    scale_sigma = f"scale_sigma = {scale}\n" if scale > DVL_SCALE_SIGMA else ""
    beams = "" if spec.form == "mcap" else "beams = [" + ", ".join(_row(b) for b in BEAMS) + "]\n"
    return f"""[tray]
joint = "tray"
origin = {_row(TRAY_ORIGIN)}
sigma_deg = {max(TRAY_SIGMA_DEG, servo_deg):.4g}

[imu]
frame = "ned"
sigma_roll_pitch_deg = 0.1
heading_drift_deg_per_hour = {max(HEADING_DRIFT_SIGMA, drift)}

[pressure]
origin = [0.0, 0.0, 0.0]
density = 1025.0
gravity = 9.81
atmosphere = 101325.0
sigma_m = {DEPTH_SIGMA}

[dvl]
mount = {_row(DVL_MOUNT)}
sigma_velocity = {VELOCITY_SIGMA}
sigma_range = {RANGE_SIGMA}
{scale_sigma}{beams}"""


def _camera_sections(spec: DiveSpec) -> str:
    """Write the sections of the cameras that are carried."""
    top = f"""[camera.top]
calibration = "calibration/camera_top.yaml"
mount = {_row(CAMERA_MOUNT)}
mount_sigma = [0.01, 0.01, 0.01, 0.5, 0.5, 0.5]
time_offset = 0.0
sigma_px = 1.0
"""
    bottom = f"""
[camera.bottom]
calibration = "calibration/camera_bottom.yaml"
pose_in_top = {_row(BOTTOM_IN_TOP)}
"""
    return top + (bottom if spec.cameras.carried == "stereo" else "")


def _row(values: object) -> str:
    return "[" + ", ".join(repr(round(float(v), 9)) for v in np.asarray(values, float)) + "]"


def cameras_of(dive: Dive) -> dict[str, CameraModel]:
    """List the cameras that the dive carries, by name."""
    if dive.spec.cameras.carried == "none":
        return {}
    cameras = {"camera_top": dive.rig.camera_top}
    if dive.rig.camera_bottom is not None:
        cameras["camera_bottom"] = dive.rig.camera_bottom
    return cameras


def camera_info(name: str, camera: CameraModel) -> str:
    """Write the YAML that ROS's camera_calibration writes."""
    k = ", ".join(f"{v:.9g}" for v in camera.matrix().ravel())
    p = ", ".join(f"{v:.9g}" for v in np.hstack([camera.matrix(), np.zeros((3, 1))]).ravel())
    d = ", ".join(f"{v:.9g}" for v in camera.distortion())
    return f"""image_width: {camera.width}
image_height: {camera.height}
camera_name: {name}
camera_matrix:
  rows: 3
  cols: 3
  data: [{k}]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [{d}]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [{p}]
"""
