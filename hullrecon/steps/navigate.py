# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""navigate: the vehicle's path by dead reckoning, or by the stereo cameras where there is no DVL or
it was hardly heard.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

import msgspec
import numpy as np

from hullrecon.artifacts.stage import Context, Stage, StageSettings
from hullrecon.dive.check.contents import Stream
from hullrecon.dive.config.mounts import describe_mounts
from hullrecon.dive.config.schema import Logs
from hullrecon.dive.images.store import ImageStore
from hullrecon.dive.package_files import named_images
from hullrecon.errors import InputError, StageError
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import from_matrix
from hullrecon.navigation.clocks.synchronise import synchronise
from hullrecon.navigation.dead_reckoning.dead_reckon import (
    Navigated,
    NavigationLogs,
    dead_reckon,
    usable_frames,
)
from hullrecon.navigation.dead_reckoning.image_walk import ImageWalk
from hullrecon.navigation.dead_reckoning.positions import attach_positions
from hullrecon.navigation.options import NavigateOptions
from hullrecon.navigation.sigmas import SIGMA_KEYS, sigmas_from_settings
from hullrecon.navigation.stereo_odometry.pair_motion import CalibrationEffect, StereoMotion
from hullrecon.navigation.stereo_odometry.stereo_path import Aids, Frames, stereo_navigate
from hullrecon.records.serialisation import to_arrays
from hullrecon.records.trajectory import Trajectory
from hullrecon.rig import RIG_KEYS, rig_from_settings
from hullrecon.steps.artifacts import IngestArtifact, InputArtifacts
from hullrecon.steps.stereo_check import find_rig_problem
from hullrecon.vision.odometry import (
    OdometryFrame,
    StereoOdometer,
    continuity,
    image_motion,
    stereo_odometer,
)
from hullrecon.vision.pairs.stereo_adjustment import DISPARITY

Samples = TypeVar("Samples", bound=Stream)
CLOCK_FEATURES = 1000  # of an image whose motion tells the clocks
# of the images: where the DVL reaches fewer of a stereo rig's, its path would leave out most of the
# dive
LEAST_HEARD = 0.5


@dataclass(frozen=True, kw_only=True)
class ImagePairMotion:
    """The images of a dive and vision's odometer, as navigation asks for the motion between two
    pairs.
    """

    top: ImageStore
    bottom: ImageStore
    odometer: StereoOdometer

    def frame(self, top: int, bottom: int) -> OdometryFrame:
        """Return the features of the images in those rows."""
        return self.odometer.frame(top, self.top.read(top), self.bottom.read(bottom))

    def between(self, first: OdometryFrame, second: OdometryFrame) -> StereoMotion | None:
        """Return the motion from the first pair to the second; None where too few features agree on
        one.
        """
        found = self.odometer.motion(first, second)
        if found is None:
            return None
        pose = from_matrix(found.motion.second_from_first)
        seen = found.calibration
        effect = CalibrationEffect(
            by_error=seen.by_calibration, information=seen.information, gradient=seen.gradient
        )
        return StereoMotion(
            pose=pose, covariance=found.motion.covariance, inliers=found.inliers, calibration=effect
        )


def external(settings: StageSettings, package: Path) -> list[Path]:
    """Return the images that tables of the package name, relative to it; they are read again for
    visual odometry.
    """
    return named_images(package, settings.read("logs", Logs).files)


def run(context: Context[NavigateOptions]) -> None:
    """Leave trajectory, error model, odometry, attitude, returns and navigation.json."""
    ingest = InputArtifacts(context.inputs).ingest
    for mount in describe_mounts(InputArtifacts(context.inputs).mounts(context.settings)):
        context.warn(mount.sentence)
    _refuse_wrong_rig(context)
    has_stereo = all(ingest.image_index(camera) is not None for camera in Camera)
    if ingest.dvl is None and not has_stereo:
        raise StageError(
            "nothing measures how the vehicle moved",
            where="no DVL and no stereo cameras were logged",
            remedy="name the DVL's topic in [topics], or both cameras with their calibration",
        )
    if ingest.dvl is None:
        _write(context, _by_stereo(context, "no DVL"), "stereo")
    elif has_stereo and (share := _share_heard(ingest, context.parameters.reach_s)) < LEAST_HEARD:
        _write(
            context,
            *_by_stereo_or_dvl(
                context, f"DVL and IMU were heard together for {100 * share:.0f} % of the images"
            ),
        )
    else:
        _write(context, _by_dvl(context), "dvl")


def _share_heard(ingest: IngestArtifact, reach_s: float) -> float:
    """Return the share of the upper camera's images that lie where the DVL's velocities reach while
    the IMU runs.
    """
    dvl, imu, index = ingest.dvl, ingest.imu, ingest.image_index(Camera.TOP)
    if dvl is None or index is None or not index.usable.any():
        return 1.0
    heard_ns = dvl.t_ns[np.isfinite(dvl.velocity).all(axis=1)]
    if imu is not None and len(imu.t_ns):
        heard_ns = heard_ns[(heard_ns >= imu.t_ns.min()) & (heard_ns <= imu.t_ns.max())]
    if not len(heard_ns):
        return 0.0
    t_ns, reach_ns = index.t_ns[index.usable], reach_s * 1e9
    return float(((t_ns >= heard_ns.min() - reach_ns) & (t_ns <= heard_ns.max() + reach_ns)).mean())


def _by_stereo_or_dvl(context: Context[NavigateOptions], heard: str) -> tuple[Navigated, str]:
    """Return the path of the stereo cameras and what gave it; the DVL's part of the dive where they
    give none.
    """
    try:
        return _by_stereo(context, f"{heard}, and the DVL is left out"), "stereo"
    except StageError as error:
        found = _by_dvl(context)
        remark = f"{heard}, and the stereo pairs alone give no path ({error}): the path is the DVL's part of the dive"
        return replace(found, remarks=[remark, *found.remarks]), "dvl"


def _ingest_and_settings(context: Context[NavigateOptions]) -> tuple[IngestArtifact, StageSettings]:
    """Return what ingest left, and the settings with the mounts that the log gives."""
    inputs = InputArtifacts(context.inputs)
    return inputs.ingest, inputs.mounted(context.settings)


def _refuse_wrong_rig(context: Context[NavigateOptions]) -> None:
    """Raise InputError where a few pairs of images contradict the calibration or the stamps, before
    hours are spent on them.
    """
    ingest, settings = _ingest_and_settings(context)
    index = {
        camera: found for camera in Camera if (found := ingest.image_index(camera)) is not None
    }
    rig = rig_from_settings(settings, ingest.camera_models)
    if len(index) < len(Camera):
        return
    images = {camera: ingest.images(camera, context.source) for camera in Camera}
    sigma_rad = float(np.radians(np.max(settings.read("camera.bottom.pose_sigma", tuple)[3:])))
    problem = find_rig_problem(
        rig, index, lambda camera, row: images[camera].read(row), sigma_rad, ingest.dvl
    )
    if problem is not None:
        raise InputError(problem.what, where="camera.bottom", remedy=problem.remedy)


def _by_dvl(context: Context[NavigateOptions]) -> Navigated:
    ingest, settings = _ingest_and_settings(context)
    dvl, imu = _unless_empty(ingest.dvl), _unless_empty(ingest.imu)
    if dvl is None:
        raise StageError(
            "the DVL's log is empty",
            where="navigate",
            remedy="check the topic and the span of the log",
        )
    if imu is None:
        what = "the DVL's velocities have no heading: no IMU was logged"
        raise StageError(what, where="navigate", remedy="name the IMU's topic in [topics]")
    logs = NavigationLogs(
        dvl=dvl,
        imu=imu,
        pressure=_unless_empty(ingest.pressure),
        tray=_unless_empty(ingest.tray),
        top=_unless_empty(ingest.image_index(Camera.TOP)),
        bottom=_unless_empty(ingest.image_index(Camera.BOTTOM)),
    )
    rig, sigmas, options = (
        rig_from_settings(settings, ingest.camera_models),
        sigmas_from_settings(settings),
        context.parameters,
    )
    read = (
        ingest.images(Camera.TOP, context.source).read
        if logs.top is not None and Camera.TOP in rig.cameras
        else None
    )
    measure = (
        None if read is None else image_motion(rig, read, CLOCK_FEATURES, options.stereo_inliers)
    )
    clocks = synchronise(logs, rig, sigmas.tilt_rad, options.longest_gap_s, measure)
    walk = None
    if read is not None:
        walk = ImageWalk(
            frames=usable_frames(clocks.logs.top),
            goes_on=continuity(rig, read, options.stereo_features, options.stereo_inliers),
            progress=lambda frames: context.progress(frames, "images followed"),
        )
    found = dead_reckon(clocks.logs, rig, sigmas, options, walk)
    return replace(
        found,
        remarks=[*clocks.remarks, *found.remarks],
        facts={"clocks": msgspec.to_builtins(clocks.errors), **found.facts},
    )


def _by_stereo(context: Context[NavigateOptions], why: str) -> Navigated:
    (ingest, settings), options = _ingest_and_settings(context), context.parameters
    rig = rig_from_settings(settings, ingest.camera_models)
    rig_sigma = np.array(settings.read("camera.bottom.pose_sigma", tuple), float) * [
        1,
        1,
        1,
        *np.radians([1, 1, 1]),
    ]
    odometer = stereo_odometer(
        rig, options.stereo_features, options.stereo_inliers, float(rig_sigma[3:].max())
    )
    top, bottom = (ingest.images(camera, context.source) for camera in Camera)
    aids = Aids(
        imu=_unless_empty(ingest.imu),
        pressure=_unless_empty(ingest.pressure),
        tray=_unless_empty(ingest.tray),
    )

    def progress(pairs: Sequence[int]) -> Iterable[int]:
        return context.progress(pairs, "stereo pairs")

    found = stereo_navigate(
        Frames(top=usable_frames(top.index), bottom=usable_frames(bottom.index)),
        aids,
        ImagePairMotion(top=top, bottom=bottom, odometer=odometer),
        rig,
        sigmas_from_settings(settings),
        options,
        np.concatenate([rig_sigma, np.full(DISPARITY, np.nan)]),
        progress,
    )
    remark = f"{why}: the path is stereo visual odometry; its scale is that of the rig's baseline"
    return replace(found, remarks=[remark, *found.remarks])


def _unless_empty(samples: Samples | None) -> Samples | None:
    """Return a stream with at least one sample, or None."""
    return None if samples is None or not len(samples.t_ns) else samples


def _write(context: Context[NavigateOptions], found: Navigated, source: str) -> None:
    for name in ("trajectory", "error_model", "odometry", "attitude"):
        context.out.arrays(f"{name}.npz", to_arrays(getattr(found, name)))
    if len(found.returns.t_ns):
        context.out.arrays("returns.npz", to_arrays(found.returns))
    positions, sentences = _write_positions(context, found.trajectory)
    facts = {"source": source, "nodes": len(found.trajectory.t_ns), **found.facts, **positions}
    context.out.json("navigation.json", {**facts, "remarks": found.remarks + sentences})
    for sentence in found.remarks + sentences:
        context.warn(sentence)


def _write_positions(
    context: Context[NavigateOptions], trajectory: Trajectory
) -> tuple[dict[str, object], list[str]]:
    """Write the positions from outside where there are some that tell something, and return their
    numbers and sentences.
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


STAGE = Stage(
    name="navigate",
    summary="compute the dead-reckoned trajectory",
    inputs=("ingest",),
    parameters=NavigateOptions,
    version=21,
    run=run,
    uses=(*RIG_KEYS, *SIGMA_KEYS, "camera.bottom.pose_sigma", "position.origin", "logs"),
    external=external,
)
