# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""List what a run needs, what absent sensors mean, and what is left to fill in.

`init`, `check` and `run` print it.
"""

from __future__ import annotations

from collections.abc import Sequence, Set
from pathlib import Path

from hullrecon.dive.config.load import LoadedConfig
from hullrecon.dive.config.schema import DEFAULT_MOUNTS
from hullrecon.dive.logs.messages.samples import TYPES
from hullrecon.findings.finding import Finding
from hullrecon.findings.package import MEANING
from hullrecon.geometry.frames import Camera

CAMERAS = frozenset(camera.key for camera in Camera)
ON_TRAY = CAMERAS | {"dvl"}
SENSORS = {  # by key, the sensors for which it is needed
    "tray.origin": ON_TRAY,
    "pressure.origin": {"pressure"},
    "dvl.mount": {"dvl"},
    "camera.top.mount": {"camera_top"},
    "camera.bottom.pose_in_top": {"camera_bottom"},
    "sonar.origin": {"sonar"},
    "sonar.mount": {"sonar"},
    "position.origin": {"position"},
}
EXPECTED = ("dvl", "imu", "pressure", "joints", "camera_top", "camera_bottom", "sonar")


def needs(sensors: Set[str], unread_dvls: Sequence[str] = ()) -> list[Finding]:
    """List what is missing to measure the vehicle's motion by DVL and IMU or by stereo images.

    Empty where one of the two is there. sensors: those that were logged. unread_dvls: topics of
    DVLs whose types are not read.
    """
    if "dvl" in sensors:
        return [] if "imu" in sensors else [Finding("needs-attitude")]
    lacking = CAMERAS - sensors
    values = {"imu": "imu" in sensors, "unread_dvls": list(unread_dvls)}
    if len(lacking) == 1:
        return [Finding("needs-second-camera", {"camera": next(iter(lacking)), **values})]
    return [Finding("needs-sensors", values)] if lacking else []


def missing(sensors: Set[str], hull: bool | None = None) -> list[Finding]:
    """List the absent sensors with what their absence means for a run.

    sensors: that were logged. hull: whether there is a CAD model, None where not known yet.
    """
    absent = [name for name in EXPECTED if name not in sensors]
    if "camera_top" in absent and "camera_bottom" in absent:
        absent.remove("camera_bottom")
    if hull is False:
        absent.append("hull")
    values = {"dvl": "dvl" in sensors, "stereo": sensors >= CAMERAS}
    return [Finding("sensor-absent", {"sensor": name, **values}) for name in absent]


def to_fill_in(
    loaded: LoadedConfig, sensors: Set[str], logged: Set[str] | None = None
) -> list[Finding]:
    """List the keys that the logged sensors need and dive.toml leaves to a default.

    Parameters
    ----------
    loaded : the configuration
    sensors : those that were logged
    logged : keys that the log's tf_static fills in, None where tf_static was not read
    """
    out = []
    for key in MEANING:
        value = loaded.value(key)
        is_needed = bool(sensors & SENSORS.get(key, sensors))
        if value is None or not is_needed or key in loaded.given | (logged or set()):
            continue
        default = DEFAULT_MOUNTS.get(key, value)
        shown = list(default) if isinstance(default, tuple) else default
        by_log = logged is None and key in DEFAULT_MOUNTS
        out.append(Finding("key-open", {"key": key, "default": shown, "log_first": by_log}))
    return out + [
        Finding("calibration-open", {"key": f"{c.section}.calibration", "camera": c.key})
        for c in Camera
        if c.key in sensors and loaded.value(c.section) is None
    ]


def configured_sensors(loaded: LoadedConfig) -> set[str]:
    """List the sensors that a run will read, by dive.toml and the names of tables alone."""
    topics = loaded.config.topics
    named = {name for name in topics.__struct_fields__ if getattr(topics, name)}
    folders = [loaded.package / name for name in loaded.config.logs.files]
    return named | {
        name for name in TYPES for folder in folders if _is_file(folder / f"{name}.csv")
    }


def _is_file(path: Path) -> bool:
    """Tell whether a path is a file. A name that no file can have is refused by its reader."""
    try:
        return path.is_file()
    except OSError:
        return False
