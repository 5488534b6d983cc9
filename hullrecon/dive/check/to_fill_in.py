# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""List what no log holds and dive.toml leaves open: lever arms, mounts, calibrations. `init`,
`check` and `run` print it.
"""

from __future__ import annotations

from collections.abc import Set
from pathlib import Path

from hullrecon.dive.config.load import LoadedConfig
from hullrecon.dive.config.mounts import DEFAULTS
from hullrecon.dive.logs.messages.samples import TYPES
from hullrecon.geometry.frames import Camera

IN_VEHICLE = "x, y, z in m in the vehicle's frame (x forward, y starboard, z down)"
MOUNT = "x, y, z in m, roll, pitch, yaw in degrees"
ON_TRAY = frozenset(("dvl", *(camera.key for camera in Camera)))
SENSORS = {  # those that a key is needed for
    "tray.origin": ON_TRAY,
    "pressure.origin": {"pressure"},
    "dvl.mount": {"dvl"},
    "camera.top.mount": {"camera_top"},
    "camera.bottom.pose_in_top": {"camera_bottom"},
    "sonar.origin": {"sonar"},
    "sonar.mount": {"sonar"},
    "position.origin": {"position"},
}
MEANING = {
    "tray.origin": f"where the tray turns, {IN_VEHICLE}",
    "pressure.origin": f"the pressure sensor, {IN_VEHICLE}",
    "dvl.mount": f"the DVL on the tray, {MOUNT}",
    "camera.top.mount": f"the camera on the tray, {MOUNT}",
    "camera.bottom.pose_in_top": f"the lower camera in the upper one's frame, from the stereo calibration, {MOUNT}",
    "sonar.origin": f"where the sonar's servo turns, {IN_VEHICLE}",
    "sonar.mount": f"the sonar on its servo, {MOUNT}",
    "position.origin": f"transponder of USBL or antenna of GPS, {IN_VEHICLE}",
    "hull.pose": f"first guess of the CAD model in the global frame, {MOUNT}",
}


def to_fill_in(
    loaded: LoadedConfig, sensors: Set[str], logged: Set[str] | None = None
) -> list[str]:
    """Return a sentence for each key that the logged sensors need and dive.toml leaves to a
    default, with that default.

    logged: keys that the log's tf_static fills in; None where it was not looked for.
    """
    out = []
    for key, meaning in MEANING.items():
        value = loaded.value(key)
        if (
            value is not None
            and sensors & SENSORS.get(key, sensors)
            and key not in loaded.given | (logged or set())
        ):
            default = DEFAULTS.get(key, value)
            shown = (
                ", ".join(f"{v:g}" for v in default) if isinstance(default, tuple) else str(default)
            )
            until = (
                "what the log's tf_static says, else " if logged is None and key in DEFAULTS else ""
            )
            out.append(f"to fill in: {key}: {meaning}; until then {until}[{shown}] is used")
    return out + [
        f"to fill in: {c.section}.calibration: the camera_info YAML of {c.key}, or [{c.section}] alone where the log has its "
        "CameraInfo; until then its images are not used"
        for c in Camera
        if c.key in sensors and loaded.value(c.section) is None
    ]


def configured_sensors(loaded: LoadedConfig) -> set[str]:
    """Return the sensors that a run will read by dive.toml and the names of tables, without opening
    a log.
    """
    topics = loaded.config.topics
    named = {name for name in topics.__struct_fields__ if getattr(topics, name)}
    folders = [loaded.package / name for name in loaded.config.logs.files]
    return named | {
        name for name in TYPES for folder in folders if _is_file(folder / f"{name}.csv")
    }


def _is_file(path: Path) -> bool:
    """Return whether a file lies there; a name that no file can have is refused, in words, when the
    log is opened.
    """
    try:
        return path.is_file()
    except OSError:
        return False
