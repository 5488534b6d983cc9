# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""navigate: the vehicle's path by dead reckoning, or by stereo cameras without a DVL."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from hullrecon.artifacts.stage import Context, StageSettings
from hullrecon.dive.check.time_overlap import Stream, shifted_streams
from hullrecon.dive.config.mounts import describe_mounts
from hullrecon.dive.images.store import ImageStore
from hullrecon.errors import InputError, StageError
from hullrecon.findings.finding import Finding, sentences
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import from_matrix
from hullrecon.navigation.dead_reckoning.dead_reckon import (
    Navigated,
    NavigationLogs,
    usable_frames,
)
from hullrecon.navigation.dead_reckoning.exposures import CameraTiming, exposures_of
from hullrecon.navigation.dead_reckoning.positions import attach_positions
from hullrecon.navigation.navigate import choose_path, reckon_dive
from hullrecon.navigation.sensors.servo import UNKNOWN_TRAY_RAD, USELESS_ANGLES
from hullrecon.navigation.sigmas import NavigationSigmas, sigmas_from_settings
from hullrecon.navigation.stereo_odometry.pair_motion import CalibrationEffect, StereoMotion
from hullrecon.navigation.stereo_odometry.stereo_path import (
    FEATURES,
    INLIERS,
    Aids,
    Frames,
    stereo_navigate,
)
from hullrecon.navigation.suspects.comparisons.images import Flow
from hullrecon.navigation.suspects.suspects import Judged
from hullrecon.records.sensors import SensorRecords
from hullrecon.records.serialisation import to_arrays
from hullrecon.records.trajectory import Trajectory
from hullrecon.rig import rig_from_settings
from hullrecon.steps.artifacts import IngestArtifact, InputArtifacts
from hullrecon.steps.chain import NoOptions
from hullrecon.steps.image_check import check_images
from hullrecon.steps.keys import READOUT_KEYS
from hullrecon.steps.sensor_check import image_flows, judge_sensors
from hullrecon.steps.stereo_check import MotionLogs, check_rig, delay_finding
from hullrecon.vision.odometry import (
    OdometryFrame,
    StereoOdometer,
    TopImages,
    stereo_odometer,
)
from hullrecon.vision.pairs.stereo_adjustment import DISPARITY
from hullrecon.vision.stereo.delay import Delay

Samples = TypeVar("Samples", bound=Stream)
CLOCK_FEATURES = 1000  # features of an image, for the motions from which time offsets are estimated


@dataclass(frozen=True, kw_only=True)
class ImagePairMotion:
    """Images and visual odometer of a dive, for the motions that navigation asks for."""

    top: ImageStore
    bottom: ImageStore
    odometer: StereoOdometer

    def frame(self, top: int, bottom: int) -> OdometryFrame:
        """Extract the features of a stereo pair, given by the rows of its images."""
        return self.odometer.frame(top, self.top.read(top), self.bottom.read(bottom))

    def between(self, first: OdometryFrame, second: OdometryFrame) -> StereoMotion | None:
        """Measure the motion between two stereo pairs. None if too few features agree."""
        found = self.odometer.motion(first, second)
        if found is None:
            return None
        pose = from_matrix(found.motion.second_from_first)
        evidence = found.calibration
        effect = CalibrationEffect(
            by_error=evidence.by_calibration,
            information=evidence.information,
            gradient=evidence.gradient,
        )
        return StereoMotion(
            pose=pose, covariance=found.motion.covariance, inliers=found.inliers, calibration=effect
        )


def run(context: Context[NoOptions]) -> None:
    """Judge the sensors, compute the path, and write it with its errors and what it was made of.

    Raises InputError where a sensor that the path needs is wrong, StageError where nothing gives a
    path.
    """
    inputs = InputArtifacts(context.inputs)
    ingest = inputs.ingest
    for mount in describe_mounts(inputs.mounts(context.settings)):
        context.warn(mount.sentence)
    judged = _judge_sensors(context)
    delay = _check_rig(context, judged.records)
    sigmas = _sigmas(context, judged)
    has_stereo = all(ingest.image_index(camera) is not None for camera in Camera)
    found, source = choose_path(
        judged.records.dvl,
        judged.records.imu,
        ingest.image_index(Camera.TOP) if has_stereo else None,
        lambda: _by_dvl(context, judged.records, delay, sigmas),
        lambda: _by_stereo(context, judged.records, delay, sigmas),
    )
    facts = {
        "suspects": [one.document() for one in judged.tried],
        "depth_offset_m": judged.depth_offset_m,
        "heading_drift_sigma_rad_s": judged.heading_drift_sigma_rad_s,
        **found.facts,
    }
    # That clocks are off is said with the estimated offsets, among the remarks of the path.
    findings = [one for one in judged.findings if one.code != "sensors-late"]
    if not facts.get("clocks"):
        images = {c.key: ingest.image_index(c) for c in Camera}
        index = {name: one for name, one in images.items() if one is not None}
        findings += shifted_streams({**judged.records.by_name(), **index})
    remarks = [*sentences(findings), *found.remarks]
    _write(context, replace(found, facts=facts, remarks=remarks), source)


def _judge_sensors(context: Context[NoOptions]) -> Judged:
    """Compare the sensors with each other, and correct those whose fault is found.

    Raises InputError where a sensor is wrong that the path needs, or the camera's images are
    frozen.
    """
    ingest, settings = _ingest_and_settings(context)
    records = SensorRecords(
        dvl=_unless_empty(ingest.dvl),
        imu=_unless_empty(ingest.imu),
        pressure=_unless_empty(ingest.pressure),
        tray=_unless_empty(ingest.tray),
    )
    index, flows = ingest.image_index(Camera.TOP), list[Flow]()
    findings: list[Finding] = []
    if index is not None and Camera.TOP in ingest.camera_models:
        images = ingest.images(Camera.TOP, context.source)
        findings = check_images({Camera.TOP: index}, lambda _, row: images.read(row))
        if not findings:
            rig = rig_from_settings(settings, ingest.camera_models)
            flows = image_flows(rig, index, images.read)
    # Blank images are no error here: the DVL gives a path, and the step features refuses them.
    for finding in findings:
        if finding.code == "images-frozen":
            raise InputError(finding.sentence)
    judged = judge_sensors(settings, records, flows, ingest.camera_models)
    for finding in judged.findings:
        if finding.severity == "error":
            raise InputError(finding.sentence)
    return judged


def _ingest_and_settings(context: Context[NoOptions]) -> tuple[IngestArtifact, StageSettings]:
    """Read the artifact of ingest, and the settings with the mounts that the log gives."""
    inputs = InputArtifacts(context.inputs)
    return inputs.ingest, inputs.mounted(context.settings)


def _check_rig(context: Context[NoOptions], records: SensorRecords) -> Delay | None:
    """Check the stereo rig on a few pairs. Returns the delay of the bottom camera, if any.

    A delay is warned of and then taken into account. None also without two cameras, or where too
    few pairs have enough in common. Raises InputError if the pairs contradict the calibration or
    the stamps.
    """
    ingest, settings = _ingest_and_settings(context)
    index = {
        camera: found for camera in Camera if (found := ingest.image_index(camera)) is not None
    }
    rig = rig_from_settings(settings, ingest.camera_models)
    if len(index) < len(Camera):
        return None
    images = {camera: ingest.images(camera, context.source) for camera in Camera}
    sigma_rad = float(np.radians(np.max(settings.read("camera.bottom.pose_sigma", tuple)[3:])))
    logs = MotionLogs(dvl=records.dvl, imu=records.imu, tray=records.tray)
    checked = check_rig(rig, index, lambda camera, row: images[camera].read(row), sigma_rad, logs)
    if checked is None:
        return None
    if checked.problem is not None:
        raise InputError(checked.problem.what, where="camera.bottom", remedy=checked.problem.remedy)
    if checked.delay is not None:
        offset_s = settings.read("camera.bottom.time_offset", float)
        context.warn(delay_finding(checked.delay, offset_s).sentence)
    return checked.delay


def _sigmas(context: Context[NoOptions], judged: Judged) -> NavigationSigmas:
    """Collect the sigmas of navigation by dive.toml, widened by what was found wrong.

    They are wide for a tray whose logged angle was found useless, for depths whose level stepped,
    and for a heading that was taken from the rates.

    judged: what the comparison of the sensors found.
    """
    sigmas = sigmas_from_settings(_ingest_and_settings(context)[1])
    depth_m = float(np.hypot(sigmas.depth_bias_m, judged.depth_offset_m))
    drift_rad_s = float(np.hypot(sigmas.heading_drift_rad_s, judged.heading_drift_sigma_rad_s))
    sigmas = replace(sigmas, depth_bias_m=depth_m, heading_drift_rad_s=drift_rad_s)
    useless = any(finding.code in USELESS_ANGLES for finding in judged.findings)
    return replace(sigmas, tray_unknown_rad=UNKNOWN_TRAY_RAD) if useless else sigmas


def _by_dvl(
    context: Context[NoOptions],
    records: SensorRecords,
    delay: Delay | None,
    sigmas: NavigationSigmas,
) -> Navigated:
    """Compute the path by dead reckoning with DVL and IMU.

    The images are used to compare clocks, and to find out whether the vehicle stayed at the hull
    while the DVL was silent.

    Raises StageError without DVL or IMU.
    """
    ingest, settings = _ingest_and_settings(context)
    dvl, imu = records.dvl, records.imu
    if dvl is None:
        raise StageError("the DVL's log is empty", where="navigate")
    if imu is None:
        what = "the DVL's velocities have no heading: no IMU was logged"
        raise StageError(what, where="navigate", remedy="name the IMU's topic in [topics]")
    logs = NavigationLogs(
        dvl=dvl,
        imu=imu,
        pressure=records.pressure,
        tray=records.tray,
        top=_unless_empty(ingest.image_index(Camera.TOP)),
        bottom=_unless_empty(ingest.image_index(Camera.BOTTOM)),
        timing=_camera_timing(settings, delay),
    )
    rig = rig_from_settings(settings, ingest.camera_models)
    measure, overlap = None, None
    if logs.top is not None and Camera.TOP in rig.cameras:
        read = ingest.images(Camera.TOP, context.source).read
        measure = TopImages(rig, read, CLOCK_FEATURES, INLIERS).motion
        overlap = TopImages(rig, read, FEATURES, INLIERS).overlap

    def progress(frames: range) -> Iterable[int]:
        return context.progress(frames, "images followed")

    return reckon_dive(logs, rig, sigmas, measure, overlap, progress)


def _camera_timing(settings: StageSettings, delay: Delay | None) -> CameraTiming:
    """Collect the readout times of both cameras, and the delay of the bottom one."""
    top, bottom = (settings.read_optional(key, float) or 0.0 for key in READOUT_KEYS)
    after_stamp_s = 0.0 if delay is None else delay.early_s
    return CameraTiming(readout_s=(top, bottom), bottom_after_stamp_s=after_stamp_s)


def _by_stereo(
    context: Context[NoOptions],
    records: SensorRecords,
    delay: Delay | None,
    sigmas: NavigationSigmas,
) -> Navigated:
    """Compute the path by stereo odometry, with IMU, pressure and tray as far as logged.

    delay: of the bottom camera, from which the exposures of the images follow. Raises StageError
    where the stereo pairs give no path.
    """
    ingest, settings = _ingest_and_settings(context)
    rig = rig_from_settings(settings, ingest.camera_models)
    rig_sigma = np.array(settings.read("camera.bottom.pose_sigma", tuple), float)  # m, degrees
    rig_sigma *= [1, 1, 1, *np.radians([1, 1, 1])]
    odometer = stereo_odometer(rig, FEATURES, INLIERS, float(rig_sigma[3:].max()))
    top, bottom = (ingest.images(camera, context.source) for camera in Camera)
    aids = Aids(imu=records.imu, pressure=records.pressure, tray=records.tray)

    def progress(pairs: Sequence[int]) -> Iterable[int]:
        return context.progress(pairs, "stereo pairs")

    found = stereo_navigate(
        Frames(top=usable_frames(top.index), bottom=usable_frames(bottom.index)),
        aids,
        ImagePairMotion(top=top, bottom=bottom, odometer=odometer),
        rig,
        sigmas,
        np.concatenate([rig_sigma, np.full(DISPARITY, np.nan)]),
        progress,
    )
    exposures = exposures_of(
        found.trajectory,
        found.returns,
        (top.index, bottom.index),
        _camera_timing(settings, delay),
        found.trajectory.track().path_at,
        rig,
    )
    return replace(found, trajectory=replace(found.trajectory, exposures=exposures))


def _unless_empty(samples: Samples | None) -> Samples | None:
    """Turn a stream without samples into None."""
    return None if samples is None or not len(samples.t_ns) else samples


def _write(context: Context[NoOptions], found: Navigated, source: str) -> None:
    """Write the step's files, and warn of its remarks. source: "dvl" or "stereo".

    Returns are written only if there are any, as a dive may have had no DVL.
    """
    for name in ("trajectory", "error_model", "odometry", "attitude"):
        context.out.arrays(f"{name}.npz", to_arrays(getattr(found, name)))
    if len(found.returns.t_ns):
        context.out.arrays("returns.npz", to_arrays(found.returns))
    positions, sentences = _write_position_fixes(context, found.trajectory)
    facts = {"source": source, "nodes": len(found.trajectory.t_ns), **found.facts, **positions}
    context.out.json("navigation.json", {**facts, "remarks": found.remarks + sentences})
    for sentence in found.remarks + sentences:
        context.warn(sentence)


def _write_position_fixes(
    context: Context[NoOptions], trajectory: Trajectory
) -> tuple[dict[str, object], list[str]]:
    """Tie position fixes (USBL, GNSS) to nodes and write those that inform the path.

    Fixes that tell nothing of the path are not written, and a remark says why. Returns figures for
    navigation.json, by "positions", and remarks. Both are empty without fixes.
    """
    inputs = InputArtifacts(context.inputs)
    fixes = inputs.ingest.position
    if fixes is None:
        return {}, []
    lever = np.array(inputs.mounted(context.settings).read("position.origin", tuple), float)
    attached = attach_positions(fixes, trajectory, lever)
    if attached.ties is not None:
        context.out.arrays("positions.npz", to_arrays(attached.ties))
    return {"positions": attached.facts()}, attached.sentences()
