# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find out for `check` whether the step navigate would find a path, without computing it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import numpy as np

from hullrecon.dive.config.load import LoadedConfig
from hullrecon.dive.config.schema import RIG_KEYS
from hullrecon.dive.images.sink import SampledImages
from hullrecon.dive.ingest.result import IngestResult
from hullrecon.errors import StageError
from hullrecon.findings.finding import Finding
from hullrecon.findings.package import DVL_ALONE
from hullrecon.geometry.frames import Camera
from hullrecon.navigation.dead_reckoning.dead_reckon import (
    NavigationLogs,
    refuse_unreckonable,
    usable_frames,
)
from hullrecon.navigation.navigate import is_by_dvl
from hullrecon.navigation.stereo_odometry.stereo_path import (
    FEATURES,
    INLIERS,
    Frames,
    refuse_unjoined,
    stereo_pairs,
)
from hullrecon.navigation.stereo_odometry.visual_odometry import LOOK_BACK
from hullrecon.records.sensors import SensorRecords
from hullrecon.rig import rig_from_settings
from hullrecon.rows import spread_rows
from hullrecon.steps.stereo_check import image_reader, sampled_only
from hullrecon.typing import Ints
from hullrecon.vision.odometry import OdometryFrame, StereoOdometer, stereo_odometer
from hullrecon.vision.stereo.image_matcher import ReadImage

# Steps between stereo pairs that are measured. Of a dive of more steps, half of which can be
# measured, so many are lost together once in 4000 times
LOOKED_AT = 12


def check_path(
    loaded: LoadedConfig, found: IngestResult, sampled: Mapping[str, SampledImages]
) -> list[Finding]:
    """Report, as an error, that what was logged gives no path, or no two images to match.

    Sensors that are missing altogether are reported elsewhere.

    found: what was read, with the records as the comparison of sensors corrected them.
    """
    try:
        _refuse_pathless(loaded, found, sampled)
    except StageError as error:
        values = {"what": error.what, "where": error.where, "remedy": error.remedy}
        return [Finding("unusable", values)]
    usable = [np.count_nonzero(index.usable) for index in found.images.values()]
    if usable and max(usable) < 2:
        what = "no camera has two images that can be used, and one alone is matched with none"
        return [Finding("unusable", {"what": what, "where": "", "remedy": DVL_ALONE})]
    return []


def _refuse_pathless(
    loaded: LoadedConfig, found: IngestResult, sampled: Mapping[str, SampledImages]
) -> None:
    """Raise StageError for logs from which the step navigate would make no path.

    It goes by stereo pairs where there is no DVL, or where DVL and IMU were heard for too little of
    the dive. A DVL without an IMU is reported elsewhere.
    """
    records, images = found.records, found.images
    stereo = images[Camera.TOP.key] if all(c.key in images for c in Camera) else None
    if records.dvl is None and stereo is not None:
        _refuse_pairs(loaded, found, sampled)
    if records.dvl is None or records.imu is None or not len(records.imu.t_ns):
        return
    if stereo is not None and not is_by_dvl(records.dvl, records.imu, stereo):
        try:
            _refuse_pairs(loaded, found, sampled)
        except StageError:  # then the path is the DVL's part of the dive
            refuse_unreckonable(_logs_of(found, records))
        return
    refuse_unreckonable(_logs_of(found, records))


def _logs_of(found: IngestResult, records: SensorRecords) -> NavigationLogs:
    """Collect the logs that dead reckoning reads. There are DVL and IMU."""
    assert records.dvl is not None
    assert records.imu is not None
    return NavigationLogs(
        dvl=records.dvl,
        imu=records.imu,
        pressure=records.pressure,
        tray=records.tray,
        top=found.images.get(Camera.TOP.key),
        bottom=found.images.get(Camera.BOTTOM.key),
    )


def _refuse_pairs(
    loaded: LoadedConfig, found: IngestResult, sampled: Mapping[str, SampledImages]
) -> None:
    """Raise StageError where there are too few stereo pairs, or where they do not join."""
    index = [found.images[camera.key] for camera in Camera]
    top, bottom = map(usable_frames, index)
    _, pairs = stereo_pairs(Frames(top=top, bottom=bottom))
    models = {camera: found.cameras[camera.key] for camera in Camera if camera.key in found.cameras}
    camera = loaded.config.camera.bottom
    if camera is None or len(models) < len(Camera):
        return
    rig = rig_from_settings({key: loaded.value(key) for key in RIG_KEYS}, models)
    sigma_rad = float(np.radians(max(camera.pose_sigma[3:])))
    odometer = stereo_odometer(rig, FEATURES, INLIERS, sigma_rad)
    kept = [
        sampled_only(one, sampled.get(camera.key)).usable
        for one, camera in zip(index, Camera, strict=True)
    ]
    is_read = kept[0][pairs[:, 0]] & kept[1][pairs[:, 1]]
    steps = 1 + np.flatnonzero(is_read[1:] & is_read[:-1])
    read = image_reader(loaded, found, sampled)
    joined = _joined_steps(odometer, read, pairs, steps[spread_rows(len(steps), LOOKED_AT)])
    lost, looked_at = joined.count(False), len(joined)
    if looked_at and (looked_at == len(pairs) - 1 or lost == looked_at >= LOOKED_AT):
        refuse_unjoined(lost, looked_at)


def _joined_steps(
    odometer: StereoOdometer, read: ReadImage, pairs: Ints, steps: Ints
) -> list[bool]:
    """Measure some steps between neighbouring pairs. Returns whether each could be measured.

    Steps between images that do not decode are left out.

    Parameters
    ----------
    odometer : measures the motion between two pairs
    read : reads an image by camera and row, None where it was not sampled
    pairs : (n, 2) rows of the images of both cameras
    steps : (m,) numbers of pairs to which the steps lead
    """

    @cache
    def frame(number: int) -> OdometryFrame | None:
        """Read a stereo pair, and find its features. None where an image cannot be read."""
        rows = pairs[number].tolist()
        pictures = [read(camera, row) for camera, row in zip(Camera, rows, strict=True)]
        if pictures[0] is None or pictures[1] is None:
            return None
        return odometer.frame(rows[0], pictures[0], pictures[1])

    out = []
    for number in steps.tolist():
        new = frame(number)
        recent = [frame(k) for k in range(number - 1, max(-1, number - 1 - LOOK_BACK), -1)]
        if new is not None and recent[0] is not None:
            out.append(any(odometer.motion(old, new) for old in recent if old is not None))
    return out
