# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What no log can tell and dive.toml does not say yet: lever arms, mounts, calibrations. `init` and `check` say it alike."""

from __future__ import annotations

from collections.abc import Set

from hullrecon.dive.config.load import LoadedConfig

IN_VEHICLE = "x, y, z in m in the vehicle's frame (x forward, y starboard, z down)"
MOUNT = "x, y, z in m, roll, pitch, yaw in degrees"
CAMERAS = {"camera_top": "camera.top", "camera_bottom": "camera.bottom"}
ON_TRAY = frozenset(("dvl", "camera_top", "camera_bottom"))
SENSORS = {  # those that a key is needed for
    "tray.origin": ON_TRAY,
    "pressure.origin": {"pressure"},
    "dvl.mount": {"dvl"},
    "camera.top.mount": {"camera_top"},
    "camera.bottom.pose_in_top": {"camera_bottom"},
    "sonar.origin": {"sonar"},
    "sonar.mount": {"sonar"},
}
MEANING = {
    "tray.origin": f"where the tray turns, {IN_VEHICLE}",
    "pressure.origin": f"the pressure sensor, {IN_VEHICLE}",
    "dvl.mount": f"the DVL on the tray, {MOUNT}",
    "camera.top.mount": f"the camera on the tray, {MOUNT}",
    "camera.bottom.pose_in_top": f"the lower camera in the upper one's frame, from the stereo calibration, {MOUNT}",
    "sonar.origin": f"where the sonar's servo turns, {IN_VEHICLE}",
    "sonar.mount": f"the sonar on its servo, {MOUNT}",
    "hull.pose": f"first guess of the CAD model in the global frame, {MOUNT}",
}


def to_fill_in(loaded: LoadedConfig, sensors: Set[str]) -> list[str]:
    """Return a sentence for each key that the logged sensors need and dive.toml leaves to a default, with that default."""
    out = []
    for key, meaning in MEANING.items():
        present = loaded.value(key) is not None and bool(sensors & SENSORS.get(key, sensors))
        if present and key not in loaded.given:
            value = ", ".join(f"{v:g}" for v in loaded.value(key))
            out.append(f"to fill in: {key}: {meaning}; until then [{value}] is used")
    return out + [
        f"to fill in: {section}.calibration: the camera_info YAML of {name}; until then its images are not used"
        for name, section in CAMERAS.items()
        if name in sensors and loaded.value(section) is None
    ]
