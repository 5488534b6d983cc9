# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Choose between dead reckoning and stereo odometry, and reckon a dive from its logs."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

import msgspec
import numpy as np

from hullrecon.errors import StageError
from hullrecon.navigation.clocks.comparisons.comparison import ClockedSensor
from hullrecon.navigation.clocks.synchronise import MeasureMotion, synchronise
from hullrecon.navigation.dead_reckoning.dead_reckon import (
    REACH_S,
    Navigated,
    NavigationLogs,
    dead_reckon,
    usable_frames,
    usable_logs,
)
from hullrecon.navigation.dead_reckoning.error_propagation import DVL_LATE, PRESSURE_LATE
from hullrecon.navigation.dead_reckoning.image_walk import GoesOn, ImageWalk
from hullrecon.navigation.sigmas import NavigationSigmas
from hullrecon.records.sensors import DvlPings, ImageIndex, ImuSamples
from hullrecon.rig import Rig

# sigma of a clock, and shift of the path by it; where both are exceeded it is reported
UNSURE_S, UNSURE_M = 0.08, 0.01
# Share of a stereo rig's images that DVL and IMU have to reach. With fewer, the DVL's path would
# leave out most of the dive
LEAST_REACHED = 0.5


def choose_path(
    dvl: DvlPings | None,
    imu: ImuSamples | None,
    stereo: ImageIndex | None,
    by_dvl: Callable[[], Navigated],
    by_stereo: Callable[[], Navigated],
) -> tuple[Navigated, str]:
    """Navigate by DVL and IMU, or by the stereo cameras where DVL or IMU are missing for long.

    Parameters
    ----------
    dvl, imu
        None where not logged.
    stereo
        Images of the upper of two cameras, None where there are not two.
    by_dvl, by_stereo
        Compute the path either way. Only the chosen one is called.

    Returns
    -------
    tuple
        The path, and what gave it: "dvl" or "stereo".

    Raises
    ------
    StageError
        Where neither a DVL nor two cameras were logged, or none of them gives a path.
    """
    if dvl is None and stereo is None:
        raise StageError(
            "nothing measures how the vehicle moved",
            where="no DVL and no stereo cameras were logged",
            remedy="name the DVL's topic in [topics], or both cameras with their calibration",
        )
    if dvl is None:
        return _with_remark(by_stereo(), f"no DVL: {BY_STEREO}"), "stereo"
    if stereo is None or is_by_dvl(dvl, imu, stereo):
        return by_dvl(), "dvl"
    share = _share_reached(dvl, imu, stereo)
    reached = f"DVL and IMU were heard together for {100 * share:.0f} % of the images"
    try:
        return _with_remark(
            by_stereo(), f"{reached}, and the DVL is left out: {BY_STEREO}"
        ), "stereo"
    except StageError as error:
        remark = (
            f"{reached}, and the stereo pairs alone give no path ({error}): the path is the DVL's "
            "part of the dive"
        )
        return _with_remark(by_dvl(), remark), "dvl"


BY_STEREO = "the path is stereo visual odometry; its scale is that of the rig's baseline"


def is_by_dvl(dvl: DvlPings, imu: ImuSamples | None, stereo: ImageIndex) -> bool:
    """Tell whether DVL and IMU were heard together long enough for the path to be the DVL's."""
    return _share_reached(dvl, imu, stereo) >= LEAST_REACHED


def _with_remark(found: Navigated, remark: str) -> Navigated:
    return replace(found, remarks=[remark, *found.remarks])


def _share_reached(dvl: DvlPings, imu: ImuSamples | None, stereo: ImageIndex) -> float:
    """Compute the share of the images between the DVL's first velocity and its last.

    With a small share a path by the DVL would leave out most of the dive. Only velocities within
    the IMU's record count, and images up to REACH_S beyond them. It is 1 without a usable image.
    """
    if not stereo.usable.any():
        return 1.0
    velocity_ns = dvl.t_ns[np.isfinite(dvl.velocity).all(axis=1)]
    if imu is not None and len(imu.t_ns):
        velocity_ns = velocity_ns[(velocity_ns >= imu.t_ns.min()) & (velocity_ns <= imu.t_ns.max())]
    if not len(velocity_ns):
        return 0.0
    t_ns, reach_ns = stereo.t_ns[stereo.usable], REACH_S * 1e9
    return float(
        ((t_ns >= velocity_ns.min() - reach_ns) & (t_ns <= velocity_ns.max() + reach_ns)).mean()
    )


def reckon_dive(
    logs: NavigationLogs,
    rig: Rig,
    sigmas: NavigationSigmas,
    measure: MeasureMotion | None = None,
    goes_on: GoesOn | None = None,
    progress: Callable[[range], Iterable[int]] = iter,
) -> Navigated:
    """Correct the clocks of a dive's sensors, and reckon its path.

    Where clocks were not compared well, their remaining offsets widen the path's sigmas.

    Parameters
    ----------
    logs, rig, sigmas
        What the sensors measured, where they sit, and how well both are known.
    measure
        Measures the motion between two images of the upper camera. None without a camera.
    goes_on
        Tells whether two images overlap, so that the path goes on there. None without a camera.
    progress
        Shows how many images were followed.
    """
    clocks = synchronise(usable_logs(logs), rig, sigmas.tilt_rad, measure)
    walk = None
    if goes_on is not None:
        walk = ImageWalk(frames=usable_frames(clocks.logs.top), goes_on=goes_on, progress=progress)
    dvl_s, pressure_s = (
        clocks.late_sigma_s.get(s, 0.0) for s in (ClockedSensor.DVL, ClockedSensor.PRESSURE)
    )
    if clocks.logs.pressure is None:  # no depth follows its clock
        pressure_s = 0.0
    sigmas = replace(sigmas, dvl_late_s=dvl_s, pressure_late_s=pressure_s)
    found = dead_reckon(clocks.logs, rig, sigmas, walk, clocks.readings)
    return replace(
        found,
        remarks=[*clocks.remarks, *_describe_unsure(found, sigmas), *found.remarks],
        facts={"clocks": msgspec.to_builtins(clocks.offsets), **found.facts},
    )


def _describe_unsure(found: Navigated, sigmas: NavigationSigmas) -> list[str]:
    """Describe clocks whose uncertainty moves the path noticeably (UNSURE_S and UNSURE_M)."""
    out = []
    for sensor, late_sigma_s, column in (
        (ClockedSensor.DVL, sigmas.dvl_late_s, DVL_LATE),
        (ClockedSensor.PRESSURE, sigmas.pressure_late_s, PRESSURE_LATE),
    ):
        shift_by_delay = found.error_model.by_error[:, :3, column]  # m per s
        shift_m = late_sigma_s * float(np.linalg.norm(shift_by_delay, axis=1).max())
        if late_sigma_s >= UNSURE_S and shift_m >= UNSURE_M:
            out.append(
                f"{sensor}: that its clock agrees with the IMU's is known to {late_sigma_s:.2f} s "
                f"(one sigma), which moves the path by up to {1000 * shift_m:.0f} mm; the path's "
                "sigmas hold it"
            )
    return out
