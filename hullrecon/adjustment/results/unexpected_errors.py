# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Warn of errors of sensors and mounts that are far larger than dive.toml allows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hullrecon.adjustment.exceeded_priors import MANY_OF_ITS_OWN, MANY_SIGMAS, displacement
from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array

LEAST_TOLD = 0.01  # share of the prior's variance that a dive takes away if it tells anything
# sigmas beyond which no chance is, as in navigation/suspects: 78 dives without such a fault had 2.2
# at most, velocities 15 % short 10.9
SURPRISING = 5.0
ALONG = 2  # place of the shift along an instrument's axis
TRAY_AXIS = 0.9  # component of a unit turn along y, the tray's axis
ALIKE = 0.25  # difference of two turns that count as equal, as a share of the greater
# Places among the errors of navigation; the tray's backlash is not judged
SCALE, DRIFT, ROLL, PITCH, DEPTH = range(5)


def navigation_warnings(correction: Array, allowed: Array, covariance: Array) -> list[str]:
    """Warn of each error of navigation beyond what dive.toml allows.

    Scale and drift are estimated as what corrects the sensor (a share of the true velocity), so its
    error has the opposite sign.

    Parameters
    ----------
    correction
        As estimated (6,).
    allowed
        Prior sigmas (6,).
    covariance
        Of the estimate (6, 6).
    """
    sigma = np.sqrt(np.maximum(np.diag(covariance), 0))
    many = (np.abs(correction) > MANY_SIGMAS * allowed) & (
        np.abs(correction) > MANY_OF_ITS_OWN * sigma
    )
    per_hour, degrees = np.degrees(correction[DRIFT]) * 3600, np.degrees(correction)
    out = []
    if many[SCALE]:
        error = -100 * correction[SCALE]
        way = "long" if error > 0 else "short"
        out.append(
            f"The DVL measures distances {abs(error):.1f} ± {100 * sigma[SCALE]:.1f} % too {way}, "
            f"{_times(correction, allowed, SCALE)} dvl.scale_sigma. The error was taken out."
        )
    if many[DRIFT]:
        out.append(
            f"The heading drifts by {-per_hour:.0f} ± {np.degrees(sigma[DRIFT]) * 3600:.0f} "
            f"degrees an hour, {_times(correction, allowed, DRIFT)} "
            "imu.heading_drift_deg_per_hour. The drift was taken out."
        )
    for place, name in ((ROLL, "Roll"), (PITCH, "Pitch")):
        if many[place]:
            out.append(
                f"{name} is off by {degrees[place]:.2f} ± {np.degrees(sigma[place]):.2f} degrees, "
                f"{_times(correction, allowed, place)} imu.bias_sigma_deg. The error was taken out."
            )
    if many[DEPTH]:
        way = "deep" if correction[DEPTH] > 0 else "shallow"
        out.append(
            f"Depths read {abs(correction[DEPTH]):.2f} ± {sigma[DEPTH]:.2f} m too {way}, "
            f"{_times(correction, allowed, DEPTH)} pressure.bias_sigma_m. The error was taken out."
        )
    return out


def scale_warning(correction: Array, allowed: Array, covariance: Array) -> list[str]:
    """Warn of a scale of the DVL that its prior holds, against what the dive alone tells.

    An estimate x whose prior is right has the variance p^2 - P, with sigma p of the prior and
    variance P that is left. What a dive hardly knows moves x little, but no less surely. Arguments
    as of `navigation_warnings`, which warns of what moved far.
    """
    x, prior, left = correction[SCALE], allowed[SCALE] ** 2, covariance[SCALE, SCALE]
    gained = 1 - left / prior
    if not np.isfinite(prior) or gained < LEAST_TOLD or abs(x) > MANY_SIGMAS * np.sqrt(prior):
        return []
    if abs(x) <= SURPRISING * np.sqrt(gained * prior):
        return []
    alone, sigma = -100 * x / gained, 100 * np.sqrt(left / gained)
    return [
        f"All else together says that the DVL measures distances {abs(alone):.0f} ± {sigma:.0f} % "
        f"too {'long' if alone > 0 else 'short'}, which contradicts dvl.scale_sigma. By that sigma "
        f"{100 * abs(x):.1f} % were taken out: the DVL's velocities or that sigma are wrong."
    ]


def length_warning(conflict: float, covariance: Array) -> str:
    """Warn of a DVL whose velocities contradict all else, images of one camera included.

    conflict: share of lengths. covariance (6, 6): of navigation.
    """
    sigma = np.sqrt(covariance[SCALE, SCALE])
    return (
        "The DVL's velocities contradict all else that was measured about lengths, by "
        f"{100 * conflict:.1f} %. That became the sigma of velocities and ranges, and lengths are "
        f"known to {100 * sigma:.2g} % (one sigma)."
    )


class MountFit(NamedTuple):
    """A mount as in dive.toml and as estimated."""

    nominal: Poses | None
    sqrt_information: Array | None  # (6, 6) of its prior; None: held
    found: Poses | None
    covariance: Array  # (6, 6) of (translation in the parent's axes, right-perturbed rotation)


def mount_warnings(mounts: Mapping[str, MountFit], distance_m: float) -> list[str]:
    """Warn of each mount estimated far from its nominal pose, and of mounts turned alike.

    Parameters
    ----------
    mounts
        By key of dive.toml.
    distance_m
        From the cameras to the hull.
    """
    found = [
        _Displacement.of(key, fit.nominal, fit.sqrt_information, fit.found, fit.covariance)
        for key, fit in mounts.items()
        if fit.nominal is not None and fit.sqrt_information is not None and fit.found is not None
    ]
    sentences = [mount.sentence() for mount in found if mount.is_far()]
    nearer = [mount.along_sentence(distance_m) for mount in found if mount.is_along()]
    return [*sentences, *nearer, *_turned_alike(found)]


@dataclass(frozen=True, kw_only=True)
class _Displacement:
    """The displacement of a mount from its pose in dive.toml."""

    key: str
    by: Array  # (6,) translation m and rotation rad in the child's axes
    sigma: Array  # (6,) of that
    allowed: Array  # (6,) prior sigmas
    in_parent: Array  # (3,) rotation in the parent's axes

    @staticmethod
    def of(key: str, nominal: Poses, rows: Array, found: Poses, covariance: Array) -> _Displacement:
        by, to_child = displacement(nominal, found)
        return _Displacement(
            key=key,
            by=by,
            sigma=np.sqrt(np.maximum(np.diag(to_child @ covariance @ to_child.T), 0)),
            allowed=np.linalg.norm(np.linalg.inv(rows), axis=1),
            in_parent=nominal.rotation.apply(by[3:])[0],
        )

    def times_allowed(self) -> Array:
        """Divide the displacement (6,) by what dive.toml allows.

        Zero where the dive does not determine it.
        """
        return np.where(
            np.abs(self.by) > MANY_OF_ITS_OWN * self.sigma, np.abs(self.by) / self.allowed, 0.0
        )

    def is_far(self) -> bool:
        """Tell whether it was found moved across the instrument's axis, or turned."""
        return bool(np.delete(self.times_allowed(), ALONG).max() > MANY_SIGMAS)

    def is_along(self) -> bool:
        return bool(self.times_allowed()[ALONG] > MANY_SIGMAS)

    def is_turned(self) -> bool:
        return bool(self.times_allowed()[3:].max() > MANY_SIGMAS)

    def sentence(self) -> str:
        """Tell by how much the mount was found moved or turned, with sigmas."""
        over = np.delete(self.times_allowed(), ALONG)
        moved, turned = 1e3 * np.linalg.norm(self.by[:2]), np.degrees(np.linalg.norm(self.by[3:]))
        moved_sigma, turned_sigma = (
            1e3 * np.linalg.norm(self.sigma[:2]),
            np.degrees(np.linalg.norm(self.sigma[3:])),
        )
        parts = (
            [f"moved across by {moved:.0f} ± {moved_sigma:.0f} mm"]
            if over[:2].max() > MANY_SIGMAS
            else []
        )
        parts += (
            [f"turned by {turned:.1f} ± {max(turned_sigma, 0.1):.1f} degrees"]
            if self.is_turned()
            else []
        )
        return (
            f"The dive fits with {self.key} {' and '.join(parts)} from where dive.toml has it, "
            f"{over.max():.0f} times what {self.key}_sigma allows. Where it sits was estimated."
        )

    def along_sentence(self, distance_m: float) -> str:
        """Tell by how much a camera was found nearer to the hull or farther from it."""
        along = self.by[ALONG]
        share = 100 * abs(along) / distance_m
        way, long = ("nearer to", "short") if along > 0 else ("farther from", "long")
        return (
            f"The dive fits with {self.key} moved along the camera's axis by "
            f"{1e3 * abs(along):.0f} ± {1e3 * self.sigma[ALONG]:.0f} mm, {way} the hull, "
            f"{self.times_allowed()[ALONG]:.0f} times what {self.key}_sigma allows. A focal length "
            f"whose calibration is {share:.0f} % too {long} looks the same, and so do ranges of "
            "the DVL that are off by as much: one of the three is wrong, and lengths with it."
        )


def _turned_alike(found: list[_Displacement]) -> list[str]:
    """Warn where all mounts, two or more, are turned alike in their parent's axes.

    A wrong attitude looks like that.
    """
    if len(found) < 2 or not any(mount.is_turned() for mount in found):
        return []
    turns = np.array([mount.in_parent for mount in found])
    mean = turns.mean(axis=0)
    size = float(np.linalg.norm(mean))
    if np.linalg.norm(turns - mean, axis=1).max() > ALIKE / 2 * size:
        return []
    tray = ", or the zero of the tray's angles" if abs(mean[1]) > TRAY_AXIS * size else ""
    keys = " and ".join(mount.key for mount in found)
    return [
        f"{keys} are turned the same way, by {np.degrees(size):.1f} degrees: it may be the IMU "
        f"that is turned instead (imu.mount_deg){tray}."
    ]


def _times(correction: Array, allowed: Array, place: int) -> str:
    return f"{abs(correction[place]) / allowed[place]:.0f} times"
