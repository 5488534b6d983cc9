# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Errors of sensors and mounts that came out far larger than dive.toml allows: each in a sentence for the report."""

from __future__ import annotations

import numpy as np

from hullrecon.adjustment.exceeded_priors import MANY_SIGMAS
from hullrecon.estimation.rig_priors import Mount
from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array

LEAST_BETTER = 2.0  # times as well as that the dive must know it
SCALE, DRIFT, ROLL, PITCH, DEPTH = range(5)  # places among the errors of navigation; the tray's backlash is not judged


def navigation_warnings(correction: Array, allowed: Array, covariance: Array) -> list[str]:
    """Return a sentence for each error of navigation beyond what was allowed.

    correction (6,): as estimated; allowed (6,): prior sigmas; covariance (6, 6): of the estimate. Scale and drift are what
    corrects the sensor (a share of the true velocity): its error has the other sign.
    """
    sigma = np.sqrt(np.maximum(np.diag(covariance), 0))
    many = (np.abs(correction) > MANY_SIGMAS * allowed) & (LEAST_BETTER * sigma < allowed)
    per_hour, degrees = np.degrees(correction[DRIFT]) * 3600, np.degrees(correction)
    out = []
    if many[SCALE]:
        error = -100 * correction[SCALE]
        way = "long" if error > 0 else "short"
        out.append(
            f"The DVL measures distances {abs(error):.1f} ± {100 * sigma[SCALE]:.1f} % too {way}, "
            f"{_times(correction, allowed, SCALE)} dvl.scale_sigma: check the speed of sound that it was set to. "
            "The error was taken out."
        )
    if many[DRIFT]:
        out.append(
            f"The heading drifts by {-per_hour:.0f} ± {np.degrees(sigma[DRIFT]) * 3600:.0f} degrees an hour, "
            f"{_times(correction, allowed, DRIFT)} imu.heading_drift_deg_per_hour. The drift was taken out."
        )
    for place, name in ((ROLL, "Roll"), (PITCH, "Pitch")):
        if many[place]:
            out.append(
                f"{name} is off by {degrees[place]:.2f} ± {np.degrees(sigma[place]):.2f} degrees, "
                f"{_times(correction, allowed, place)} imu.bias_sigma_deg: check imu.mount. The error was taken out."
            )
    if many[DEPTH]:
        way = "deep" if correction[DEPTH] > 0 else "shallow"
        out.append(
            f"Depths read {abs(correction[DEPTH]):.2f} ± {sigma[DEPTH]:.2f} m too {way}, {_times(correction, allowed, DEPTH)} "
            "pressure.bias_sigma_m: check the gauge's zero and the draught. The error was taken out."
        )
    return out


def length_warning(conflict: float, covariance: Array) -> str:
    """Return a sentence on the velocities of a DVL that all else contradicts by that share, one camera's images among it.
    covariance (6, 6): of navigation."""
    sigma = np.sqrt(covariance[SCALE, SCALE])
    return (
        f"The DVL's velocities contradict all else that was measured about lengths, by {100 * conflict:.1f} %. That became the "
        f"sigma of velocities and ranges, and lengths are known to {100 * sigma:.2g} % (one sigma). Check the speed of sound "
        "that the DVL was set to, and the camera's calibration under water."
    )


def mount_warning(key: str, mount: Mount | None, found: Poses | None, covariance: Array) -> str | None:
    """Return a sentence where a mount came out far from its place; None where it did not or was held.

    A shift along the instrument's own z is not spoken of: a focal length, or a range, that is off looks the same. key: of
    dive.toml; covariance (6, 6): of (translation in the parent's axes, rotation perturbed on the right).
    """
    if mount is None or mount.sqrt_information is None or found is None:
        return None
    to_child = mount.nominal.rotation.inv().as_matrix()[0]
    shift = to_child @ (found.translation - mount.nominal.translation)[0]
    turn = (mount.nominal.rotation.inv() * found.rotation).as_rotvec()[0]
    axes = np.eye(6)
    axes[:3, :3] = to_child
    sigma = np.sqrt(np.maximum(np.diag(axes @ covariance @ axes.T), 0))
    allowed = np.linalg.norm(np.linalg.inv(mount.sqrt_information), axis=1)
    over = np.where(LEAST_BETTER * sigma < allowed, np.abs(np.r_[shift, turn]) / allowed, 0.0)
    over[2] = 0.0
    if over.max() <= MANY_SIGMAS:
        return None
    shift_sigma, turn_sigma = np.linalg.norm(sigma[:2]), np.degrees(np.linalg.norm(sigma[3:]))
    moved, turned = 1e3 * np.linalg.norm(shift[:2]), np.degrees(np.linalg.norm(turn))
    parts = [f"moved across by {moved:.0f} ± {1e3 * shift_sigma:.0f} mm"] if over[:2].max() > MANY_SIGMAS else []
    parts += [f"turned by {turned:.1f} ± {max(turn_sigma, 0.1):.1f} degrees"] if over[3:].max() > MANY_SIGMAS else []
    return (
        f"The dive fits with {key} {' and '.join(parts)} from where dive.toml has it, {over.max():.0f} times what {key}_sigma "
        "allows. Where it sits was estimated: correct it there."
    )


def _times(correction: Array, allowed: Array, place: int) -> str:
    return f"{abs(correction[place]) / allowed[place]:.0f} times"
