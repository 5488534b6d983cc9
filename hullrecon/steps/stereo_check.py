# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stereo calibration and stamps checked on some images, for `check` and the step navigate."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hullrecon.dive.config.load import LoadedConfig
from hullrecon.dive.images.encoded import decode
from hullrecon.dive.images.sink import SampledImages
from hullrecon.dive.ingest import IngestResult
from hullrecon.findings.finding import Finding
from hullrecon.geometry.frames import Camera
from hullrecon.navigation.dead_reckoning.dead_reckon import usable_frames
from hullrecon.navigation.dead_reckoning.nodes import pair_frames
from hullrecon.records.sensors import DvlPings, ImageIndex
from hullrecon.rig import RIG_KEYS, Rig, rig_from_settings
from hullrecon.typing import Pixels
from hullrecon.vision.stereo.rig_check import (
    ReadImage,
    RigProblem,
    StereoFrames,
    check_baseline,
    check_stereo_rig,
    compare_ways,
)


def find_rig_problem(
    rig: Rig,
    index: Mapping[Camera, ImageIndex],
    read: ReadImage,
    sigma_rad: float,
    dvl: DvlPings | None,
) -> RigProblem | None:
    """Check calibration, stamps and baseline on some images.

    Parameters
    ----------
    rig
        The vehicle's sensors.
    index
        The images of each camera.
    read
        Reads an image by camera and row.
    sigma_rad
        Of the bottom camera's rotation.
    dvl
        For the baseline, None without a DVL.

    Returns
    -------
    problem
        None if all fits, or without two cameras.
    """
    if len(index) < len(Camera) or len(rig.cameras) < len(Camera):
        return None
    top, bottom = (usable_frames(index[camera]) for camera in Camera)
    frames = StereoFrames(pair=pair_frames(top[0], bottom[0]), top=top, bottom=bottom)
    found = check_stereo_rig(rig, frames, read, sigma_rad)
    if found is None:
        return None
    if found.problem or dvl is None or not len(dvl.t_ns):
        return found.problem
    return check_baseline(found, dvl, rig, lambda: compare_ways(rig, frames, read, dvl))


def describe_rig_problem(
    loaded: LoadedConfig, found: IngestResult, sampled: Mapping[str, SampledImages]
) -> list[Finding]:
    """Check the stereo rig on the images that `check` sampled."""
    bottom = loaded.config.camera.bottom
    if bottom is None or any(camera.key not in found.images for camera in Camera):
        return []
    index = {camera: found.images[camera.key] for camera in Camera}

    def encoded(camera: Camera, row: int) -> bytes | None:
        if index[camera].file[row]:
            return (loaded.package / str(index[camera].file[row])).read_bytes()
        if camera.key not in sampled:
            return None
        return sampled[camera.key].image_at(int(index[camera].offset[row]))

    def read(camera: Camera, row: int) -> Pixels | None:
        data = encoded(camera, row)
        return None if data is None else decode(data, int(index[camera].bits))

    models = {camera: found.cameras[camera.key] for camera in Camera if camera.key in found.cameras}
    rig = rig_from_settings({key: loaded.value(key) for key in RIG_KEYS}, models)
    sigma_rad = float(np.radians(max(bottom.pose_sigma[3:])))
    problem = find_rig_problem(rig, index, read, sigma_rad, found.records.dvl)
    if problem is None:
        return []
    return [Finding("stereo-rig", {"problem": problem.sentence})]
