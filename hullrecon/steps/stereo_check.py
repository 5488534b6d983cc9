# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stereo calibration and stamps checked on some images, for `check` and the step navigate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from hullrecon.dive.config.load import LoadedConfig
from hullrecon.dive.config.schema import RIG_KEYS
from hullrecon.dive.images.encoded import decode
from hullrecon.dive.images.sink import SampledImages
from hullrecon.dive.ingest.result import IngestResult
from hullrecon.findings.finding import Finding
from hullrecon.geometry.frames import Camera
from hullrecon.navigation.dead_reckoning.dead_reckon import usable_frames
from hullrecon.navigation.dead_reckoning.nodes import pair_frames
from hullrecon.navigation.sensors.tray_motion import tray_motion
from hullrecon.records.sensors import DvlPings, ImageIndex, ImuSamples, JointSamples
from hullrecon.rig import Rig, rig_from_settings
from hullrecon.typing import Pixels
from hullrecon.vision.stereo.baseline_check import check_baseline, compare_distances
from hullrecon.vision.stereo.delay import Delay
from hullrecon.vision.stereo.image_matcher import ReadImage, StereoFrames
from hullrecon.vision.stereo.rig_check import RigCheck, check_stereo_rig


@dataclass(frozen=True, kw_only=True)
class MotionLogs:
    """What measures the motion of the rig. None: not logged."""

    dvl: DvlPings | None
    imu: ImuSamples | None
    tray: JointSamples | None


def check_rig(
    rig: Rig,
    index: Mapping[Camera, ImageIndex],
    read: ReadImage,
    sigma_rad: float,
    logs: MotionLogs,
) -> RigCheck | None:
    """Check stereo calibration, stamps and baseline on some images.

    The result holds the problem, if any, and the delay of the bottom camera, if any. The baseline
    is checked only with a DVL, which measures in metres what the cameras measure in baselines.

    Parameters
    ----------
    rig
        The cameras as calibrated.
    index
        Stamps of each camera's images, and which of them decode.
    read
        Reads an image by camera and row.
    sigma_rad
        Sigma of the bottom camera's rotation relative to the top one, as configured.
    logs
        DVL and IMU, which tell how the rig moved while one camera was late. The tray's angle turns
        both.

    Returns
    -------
    check
        None without two cameras or where too few images have enough in common.
    """
    if len(index) < len(Camera) or len(rig.cameras) < len(Camera):
        return None
    top, bottom = (usable_frames(index[camera]) for camera in Camera)
    frames = StereoFrames(pair=pair_frames(top[0], bottom[0]), top=top, bottom=bottom)
    # without DVL and IMU no delay of one camera can be found
    dvl, imu, motion = logs.dvl, logs.imu, None
    if dvl is not None and imu is not None and len(dvl.t_ns) and len(imu.t_ns):
        motion = partial(tray_motion, dvl, imu, logs.tray, rig)
    found = check_stereo_rig(rig, frames, read, sigma_rad, motion)
    if found is None or found.problem or dvl is None or not len(dvl.t_ns):
        return found
    problem = check_baseline(found, dvl, rig, lambda: compare_distances(rig, frames, read, dvl))
    return replace(found, problem=problem)


def delay_finding(delay: Delay, time_offset_s: float) -> Finding:
    """Build the finding that the bottom camera is exposed after its stamps.

    It names the value of camera.bottom.time_offset that would state the delay: the configured one,
    time_offset_s, plus the delay.
    """
    values = {
        "after_stamp_ms": 1e3 * delay.early_s,
        "sigma_ms": 1e3 * delay.sigma_s,
        "offset_s": time_offset_s + delay.early_s,
    }
    return Finding("bottom-camera-delayed", values, "camera.bottom")


def check_sampled_rig(
    loaded: LoadedConfig, found: IngestResult, sampled: Mapping[str, SampledImages]
) -> list[Finding]:
    """Check the stereo rig on the images that `check` sampled.

    Findings are a contradiction of its calibration, or the bottom camera's delay. There are none
    without two cameras, or where too few of these images have enough in common.
    """
    bottom = loaded.config.camera.bottom
    if bottom is None or any(camera.key not in found.images for camera in Camera):
        return []
    index = {camera: found.images[camera.key] for camera in Camera}
    read = image_reader(loaded, found, sampled)
    models = {camera: found.cameras[camera.key] for camera in Camera if camera.key in found.cameras}
    rig = rig_from_settings({key: loaded.value(key) for key in RIG_KEYS}, models)
    sigma_rad = float(np.radians(max(bottom.pose_sigma[3:])))
    logs = MotionLogs(dvl=found.records.dvl, imu=found.records.imu, tray=found.records.tray)
    checked = check_rig(rig, index, read, sigma_rad, logs)
    findings = []
    if checked is not None and checked.problem is not None:
        findings.append(Finding("stereo-rig", {"problem": checked.problem.sentence}))
    if checked is not None and checked.delay is not None:
        findings.append(delay_finding(checked.delay, bottom.time_offset))
    return findings


def image_reader(
    loaded: LoadedConfig, found: IngestResult, sampled: Mapping[str, SampledImages]
) -> ReadImage:
    """Make a function that reads the images that `check` sampled, by camera and row.

    It returns None for an image in a log that was not sampled, or that does not decode. Images that
    are plain files are all read.
    """

    def encoded(camera: Camera, row: int) -> bytes | None:
        """Read the bytes of an image, from its file or as sampled. None if it was not kept."""
        index = found.images[camera.key]
        if index.file[row]:
            return (loaded.package / str(index.file[row])).read_bytes()
        if camera.key not in sampled:
            return None
        return sampled[camera.key].image_at(int(index.offset[row]))

    def read(camera: Camera, row: int) -> Pixels | None:
        data = encoded(camera, row)
        return None if data is None else decode(data, int(found.images[camera.key].bits))

    return read


def sampled_only(index: ImageIndex, sampled: SampledImages | None) -> ImageIndex:
    """Mark images of a log that were not sampled as unusable. Those in files of their own are kept.

    Of a long log few were sampled: pairs that are chosen among all would hardly be among them.
    """
    kept = np.array(
        [
            bool(file) or (sampled is not None and sampled.image_at(int(offset)) is not None)
            for file, offset in zip(index.file, index.offset, strict=True)
        ],
        bool,
    )
    return replace(index, usable=index.usable & kept)
