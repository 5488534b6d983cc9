# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A simulated dive package in a folder: dive.toml, logs, calibration, CAD model, truth (see docs/formats.md)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import Poses, roll_pitch_yaw
from hullrecon.synthetic.dive import Dive, simulate_dive
from hullrecon.synthetic.output.mcap_log import TOPICS, write_mcap
from hullrecon.synthetic.output.new_folder import new_folder
from hullrecon.synthetic.output.plain_log import write_plain
from hullrecon.synthetic.output.truth import write_truth
from hullrecon.synthetic.sensors.instruments import DEPTH_SIGMA, RANGE_SIGMA, VELOCITY_SIGMA
from hullrecon.synthetic.sensors.recorder import Track, record, untracked
from hullrecon.synthetic.spec import DiveSpec
from hullrecon.synthetic.vehicle.rig import (
    BEAMS,
    BOTTOM_IN_TOP,
    CAMERA_MOUNT,
    DVL_MOUNT,
    SONAR_ELEVATION_DEG,
    SONAR_MOUNT,
    SONAR_ORIGIN,
    TRAY_ORIGIN,
)
from hullrecon.synthetic.world.hull_shapes import write_stl

# What dive.toml tells of instruments of this class, one sigma; more where more was simulated.
TRAY_SIGMA_DEG = 0.8
HEADING_DRIFT_SIGMA = 1.0  # degrees an hour
DVL_SCALE_SIGMA = 0.005  # assumed by readers where the key is absent


def write_package(folder: Path, spec: DiveSpec, track: Track = untracked) -> Dive:
    """Simulate a dive, write its package and return it, truth and all. The folder may exist but must be empty; it is written
    beside under a temporary name, so that a simulation that fails or is interrupted leaves nothing. track: shows the
    images as they are written.

    Raises StorageError when the folder is not empty or cannot be written."""
    with new_folder(folder) as place:
        dive = simulate_dive(spec)
        write_stl(place / "hull.stl", dive.cad_model)
        (place / "logs").mkdir()
        streams = record(dive, track)
        if spec.form == "mcap":
            write_mcap(place / "logs" / "dive.mcap", streams)
        else:
            write_plain(place / "logs", streams)
        for name, camera in _cameras(dive).items():
            (place / "calibration").mkdir(exist_ok=True)
            (place / "calibration" / f"{name}.yaml").write_text(camera_info(name, camera))
        (place / "truth").mkdir()
        write_truth(place / "truth", dive)
        (place / "dive.toml").write_text(dive_toml(dive))
    return dive


def camera_info(name: str, camera: CameraModel) -> str:
    """The YAML that ROS's camera_calibration writes."""
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


def initial_guess(dive: Dive) -> Poses:
    """T_g_M as the operator would give it: off by the guess's errors at the middle of the survey."""
    spec, random = dive.spec, dive.spec.random("guess")
    sign = random.choice([-1.0, 1.0], 4)
    middle = dive.hull.skin.middle()
    shift = sign[:3] * [spec.guess.along_m, spec.guess.across_m, 0.6 * spec.guess.across_m]
    turn = np.radians(spec.guess.turn_deg) * np.array([0.3, 0.2, sign[3]])
    slip = Poses(Rotation.from_rotvec(turn).as_quat()[None], np.zeros((1, 3)))
    about = Poses(slip.quaternion, middle + shift - slip.apply(middle[None]))
    return dive.motion.T_g_M @ about


def dive_toml(dive: Dive) -> str:
    """dive.toml with nominal mounts and the first guess."""
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
    guess = initial_guess(dive)
    pose = [*guess.translation[0], *np.degrees(roll_pitch_yaw(guess.rotation)[0])]
    sections.append(f"""[hull]
mesh = "hull.stl"
units = "m"
pose = {_row(pose)}
pose_sigma = [1.0, 1.0, 0.3, 1.0, 1.0, 5.0]
frame_spacing = 0.6
""")
    return "\n".join(sections)


def _head(dive: Dive) -> str:
    spec = dive.spec
    carried = ["dvl", "imu", "pressure", "joints", *_cameras(dive), *(["sonar"] if spec.sonar else [])]
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
    scale = abs(spec.errors.dvl_scale_error)
    scale_sigma = f"scale_sigma = {scale}\n" if scale > DVL_SCALE_SIGMA else ""
    beams = "" if spec.form == "mcap" else "beams = [" + ", ".join(_row(b) for b in BEAMS) + "]\n"
    return f"""[tray]
joint = "tray"
origin = {_row(TRAY_ORIGIN)}
sigma_deg = {max(TRAY_SIGMA_DEG, float(np.hypot(spec.errors.backlash_deg, spec.errors.servo_sigma_deg))):.4g}

[imu]
frame = "ned"
sigma_roll_pitch_deg = 0.1
heading_drift_deg_per_hour = {max(HEADING_DRIFT_SIGMA, abs(spec.errors.heading_drift_deg_per_hour))}

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


def _cameras(dive: Dive) -> dict[str, CameraModel]:
    if dive.spec.cameras.carried == "none":
        return {}
    bottom = dive.rig.camera_bottom
    return {"camera_top": dive.rig.camera_top, **({"camera_bottom": bottom} if bottom is not None else {})}


def _row(values: object) -> str:
    return "[" + ", ".join(repr(round(float(v), 9)) for v in np.asarray(values, float)) + "]"
