# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Compare the sensors with each other, for `check` and the step navigate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from hullrecon.dive.check.motion_offset import level_of, mend_shifted, motions_apart
from hullrecon.dive.config.load import LoadedConfig
from hullrecon.dive.config.schema import Topics
from hullrecon.dive.images.sink import SampledImages
from hullrecon.dive.ingest.result import IngestResult
from hullrecon.findings.finding import Finding
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.navigation.dead_reckoning.dead_reckon import usable_frames
from hullrecon.navigation.sensors.servo import doubtful_angles, frozen_readings
from hullrecon.navigation.suspects.comparisons.comparison import LEAST_WINDOWS, Sensor
from hullrecon.navigation.suspects.comparisons.images import Flow
from hullrecon.navigation.suspects.depth_steps import depth_steps
from hullrecon.navigation.suspects.faults.axes import Conventions
from hullrecon.navigation.suspects.pairs import judge_pairs
from hullrecon.navigation.suspects.parts import judge_parts
from hullrecon.navigation.suspects.shifted_imu import mend_shifted_imu
from hullrecon.navigation.suspects.suspects import Judged, judge
from hullrecon.records.clock import NS
from hullrecon.records.sensors import ImageIndex, SensorRecords
from hullrecon.rig import Rig, rig_from_settings
from hullrecon.rows import spread_rows
from hullrecon.steps.image_check import check_images
from hullrecon.steps.keys import SENSOR_KEYS, WATER_KEYS
from hullrecon.steps.stereo_check import image_reader, sampled_only
from hullrecon.typing import Ints
from hullrecon.vision.odometry import ReadRow, TopImages

# Pairs of neighbouring images whose motion is compared, features of each, least matches of a pair
PAIRS, FEATURES, INLIERS = 12, 500, 20
# Findings of contradictions that no fault of the whole dive explains
UNEXPLAINED = {"sensors-contradict", "sensors-part"}
NEIGHBOURS_S = 2.0  # longest time between the images of a pair


def judge_sensors(
    settings: Mapping[str, object],
    records: SensorRecords,
    flows: Sequence[Flow],
    cameras: Mapping[Camera, CameraModel],
) -> Judged:
    """Compare the sensors of a dive with each other, and find out which one is wrong.

    Shifted records, frozen readings of the tray and steps in the level of the depths are corrected
    first, then what is left is compared. Where depth and DVL show the same motion at different
    times, only this is returned: no other comparison is valid then.

    Parameters
    ----------
    settings
        Values of SENSOR_KEYS.
    records
        What the sensors logged.
    flows
        Features of pairs of the top camera's images, in ideal coordinates. Empty without usable
        images: the camera is then not compared.
    cameras
        Camera models that the flows were computed with.

    Returns
    -------
    judged
        The records, corrected where a fault was found, the findings, the tried hypotheses, and by
        how much the level of depths may be off.
    """
    rig, topics = rig_from_settings(settings, cameras), _topics_of(settings["topics"])

    # Motions at other times: the records are of two dives, or shifted as a whole.
    level = level_of(records, rig.tray_origin, rig.pressure_origin, rig.tray_from_dvl)
    apart = motions_apart(records, level)
    if apart:
        return Judged(records=records, findings=apart, tried=[])
    records, mended = mend_shifted(records, level)
    records, moved = mend_shifted_imu(records, rig, flows)
    mended += moved

    # Readings that the tray's driver repeats, and steps in the level of the depths.
    records, frozen = leave_out_frozen(records)
    mended += frozen
    stepped = depth_steps(records, rig)
    if stepped is not None:
        records = replace(records, pressure=stepped.mended)
        mended += [stepped.finding(topics.get(Sensor.PRESSURE, ""))]

    # Contradictions of what is left. Angles that are off by less than is stated are none, and
    # useless angles of a tray widen its sigma.
    density, gravity, atmosphere = (_number(settings[key]) for key in WATER_KEYS)
    atmosphere_m = atmosphere / (density * gravity)  # of water
    mount_deg = settings["imu.mount_deg"]
    given = Conventions(
        imu_frame=str(settings["imu.frame"]),
        imu_mount_deg=mount_deg if isinstance(mount_deg, tuple) else None,
        tray_positive=str(settings["tray.positive"]),
        tray_offset_deg=_number(settings["tray.offset_deg"]),
    )
    tray_sigma_rad = float(np.radians(_number(settings["tray.sigma_deg"])))
    if records.tray is not None:
        rig = replace(rig, priors=replace(rig.priors, tray_sigma_rad=tray_sigma_rad))
    judged = judge(records, rig, atmosphere_m, topics, flows, given)
    if not {one.code for one in judged.findings} - UNEXPLAINED:
        part = judge_parts(judged.records, rig, atmosphere_m, flows, given)
        judged = judged if part is None else replace(judged, findings=[part])
    # what no single fault explains, or only a clock does, two faults may explain
    last = judged.findings[-1].code if judged.findings else ""
    if last in UNEXPLAINED | {"sensors-late"}:
        pair = judge_pairs(records, rig, atmosphere_m, topics, flows, given)
        if pair is not None and pair.cost < judged.cost:
            judged = replace(pair, tried=[*judged.tried, *pair.tried])
    still = doubtful_angles(
        judged.records.tray,
        str(settings["tray.joint_unit"]),
        tray_sigma_rad,
    )
    return replace(
        judged,
        findings=[*mended, *judged.findings, *still],
        depth_offset_m=0.0 if stepped is None else stepped.largest_offset_m,
    )


def _topics_of(topics: object) -> dict[Sensor, str]:
    """Name the topic of each sensor that has one, by the section [topics]."""
    if not isinstance(topics, Topics):
        return {}
    named = {
        Sensor.PRESSURE: topics.pressure,
        Sensor.DVL: topics.dvl,
        Sensor.RATES: topics.imu,
        Sensor.ATTITUDE: topics.imu,
        Sensor.ACCELERATION: topics.imu,
        Sensor.CAMERA: topics.camera_top,
        Sensor.TRAY: topics.joints,
    }
    return {sensor: topic for sensor, topic in named.items() if topic}


def leave_out_frozen(records: SensorRecords) -> tuple[SensorRecords, list[Finding]]:
    """Leave out readings of the tray that its driver repeats, and report how many.

    The tray may have moved meanwhile. Without such readings the records are returned as they are.
    """
    tray = records.tray
    if tray is None:
        return records, []
    frozen = frozen_readings(tray.angle)
    if not frozen.any():
        return records, []
    # first reading of each frozen run and the one after it, alternately
    ends = np.flatnonzero(np.diff(np.concatenate([[0], frozen, [0]])))
    values = {
        "count": int(frozen.sum()),
        "total": len(frozen),
        "longest": int(np.diff(ends)[::2].max()),
    }
    return replace(records, tray=tray.take(~frozen)), [Finding("tray-frozen", values)]


def check_sensors(
    loaded: LoadedConfig, found: IngestResult, sampled: Mapping[str, SampledImages]
) -> tuple[SensorRecords, list[Finding], list[dict[str, object]]]:
    """Check images and sensors for `check`, as `judge_sensors` does.

    The motion of the images is compared with other sensors only if the images are fine.

    Parameters
    ----------
    loaded
        dive.toml.
    found
        Result of ingest.
    sampled
        The images that `check` read.

    Returns
    -------
    records
        What the sensors logged, corrected where a fault was found.
    findings
        Faults of the images and the sensors, empty if there are none.
    tried
        The hypotheses of faults that were tried, for the JSON of `check`.
    """
    settings = {key: loaded.value(key) for key in SENSOR_KEYS}
    model = found.cameras.get(Camera.TOP.key)
    flows: list[Flow] = []
    cameras = {} if model is None else {Camera.TOP: model}
    read = image_reader(loaded, found, sampled)
    logged = {
        camera: sampled_only(found.images[camera.key], sampled.get(camera.key))
        for camera in Camera
        if camera.key in found.images
    }
    index = logged.get(Camera.TOP)
    image_findings = check_images(logged, read)
    if index is not None and cameras and not image_findings:
        rig = rig_from_settings(settings, cameras)
        flows = image_flows(rig, index, lambda row: read(Camera.TOP, row))
        pairs = len(_pairs_of_flows(index))
        if pairs >= LEAST_WINDOWS and not flows:
            image_findings = [Finding("images-unmatched", {"count": pairs}, Camera.TOP.key)]
    judged = judge_sensors(settings, found.records, flows, cameras)
    return (
        judged.records,
        [*image_findings, *judged.findings],
        [one.document() for one in judged.tried],
    )


def image_flows(rig: Rig, index: ImageIndex, read: ReadRow) -> list[Flow]:
    """Match some pairs of neighbouring images of the top camera, spread over the dive.

    How features move between them shows the camera's motion, which other sensors measured too.
    Pairs with too few matches are left out, so there may be none. read: reads an image by its row.
    """
    if rig.tray_from_top is None:
        return []
    t_ns, rows = usable_frames(index)
    images, out = TopImages(rig, read, FEATURES, INLIERS), []
    for k in _pairs_of_flows(index).tolist():
        found = images.flow(int(rows[k]), int(rows[k + 1]))
        if found is not None:
            out.append(Flow(t_ns=(int(t_ns[k]), int(t_ns[k + 1])), first=found[0], second=found[1]))
    return out


def _pairs_of_flows(index: ImageIndex) -> Ints:
    """Choose the usable frames (p,) of which each is matched with the next one."""
    near = np.flatnonzero(np.diff(usable_frames(index)[0]) < NEIGHBOURS_S * NS)
    return near[spread_rows(len(near), PAIRS)]


def _number(value: object) -> float:
    return float(str(value))
