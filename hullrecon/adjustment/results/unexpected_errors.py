# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Warn of errors of sensors and mounts that are far larger than dive.toml allows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hullrecon.adjustment.exceeded_priors import MANY_SIGMAS, displacement, without_prior
from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array

# An error is said to be far off only beyond so many of its own sigmas
MANY_OF_ITS_OWN = 8.0
ALONG = 2  # index of the shift along an instrument's axis
TRAY_AXIS = 0.9  # least component along y of a unit turn that is about the tray's axis
ALIKE = 0.25  # largest difference of two turns that count as equal, as a share of the greater
# Indices among the errors of navigation; the tray's backlash is not judged
SCALE, DRIFT, ROLL, PITCH, DEPTH = range(5)


def navigation_warnings(correction: Array, allowed: Array, covariance: Array) -> list[str]:
    """Warn of each error of navigation beyond what dive.toml allows.

    Scale and drift are estimated as corrections of the sensor, so the sensor's error has the
    opposite sign. The other errors are estimated as such.

    Parameters
    ----------
    correction
        Estimate (6,), in the order of RigPriors.navigation_sigma.
    allowed
        Prior sigmas (6,) that dive.toml states.
    covariance
        Covariance (6, 6) of the estimate, for its sigmas in the sentences.
    """
    sigma = np.sqrt(np.maximum(np.diag(covariance), 0))
    is_far = (np.abs(correction) > MANY_SIGMAS * allowed) & (
        np.abs(correction) > MANY_OF_ITS_OWN * sigma
    )
    per_hour, degrees = np.degrees(correction[DRIFT]) * 3600, np.degrees(correction)
    out = []
    if is_far[SCALE]:
        error = -100 * correction[SCALE]
        way = "long" if error > 0 else "short"
        out.append(
            f"The DVL measures distances {abs(error):.1f} ± {100 * sigma[SCALE]:.1f} % too {way}, "
            f"{_times(correction, allowed, SCALE)} dvl.scale_sigma. The error was taken out."
        )
    if is_far[DRIFT]:
        out.append(
            f"The heading drifts by {-per_hour:.0f} ± {np.degrees(sigma[DRIFT]) * 3600:.0f} "
            f"degrees an hour, {_times(correction, allowed, DRIFT)} "
            "imu.heading_drift_deg_per_hour. The drift was taken out."
        )
    for place, name in ((ROLL, "Roll"), (PITCH, "Pitch")):
        if is_far[place]:
            out.append(
                f"{name} is off by {degrees[place]:.2f} ± {np.degrees(sigma[place]):.2f} degrees, "
                f"{_times(correction, allowed, place)} imu.bias_sigma_deg. The error was taken out."
            )
    if is_far[DEPTH]:
        way = "deep" if correction[DEPTH] > 0 else "shallow"
        out.append(
            f"Depths read {abs(correction[DEPTH]):.2f} ± {sigma[DEPTH]:.2f} m too {way}, "
            f"{_times(correction, allowed, DEPTH)} pressure.bias_sigma_m. The error was taken out."
        )
    return out


def scale_warning(correction: Array, allowed: Array, covariance: Array) -> list[str]:
    """Warn of a scale of the DVL that the dive contradicts though its prior keeps it small.

    An estimate may be small and still be too large for what the dive says of it (`without_prior`).
    `navigation_warnings` warns of large scales. Empty where there is no such scale.

    correction, allowed: (k,) estimated errors of navigation, and their sigmas a priori. covariance:
    (k, k) a posteriori.
    """
    x, prior = float(correction[SCALE]), float(allowed[SCALE])
    found = without_prior(
        correction[SCALE : SCALE + 1] / prior, covariance[[SCALE], [SCALE]] / prior**2
    )
    if not found.contradicts[0] or abs(x) > MANY_SIGMAS * prior:
        return []
    alone, sigma = -100 * prior * float(found.value[0]), 100 * prior * float(found.sigma[0])
    return [
        f"All else together says that the DVL measures distances {abs(alone):.0f} ± {sigma:.0f} % "
        f"too {'long' if alone > 0 else 'short'}, which contradicts dvl.scale_sigma. By that sigma "
        f"{100 * abs(x):.1f} % were taken out: the DVL's velocities or that sigma are wrong."
    ]


def length_warning(conflict: float, covariance: Array) -> str:
    """Warn of a DVL whose velocities contradict all other measurements about lengths.

    conflict: share of a length by which they differ. covariance (6, 6): of navigation's errors.
    """
    sigma = np.sqrt(covariance[SCALE, SCALE])
    return (
        "The DVL's velocities contradict all else that was measured about lengths, by "
        f"{100 * conflict:.1f} %. That became the sigma of velocities and ranges, and lengths are "
        f"known to {100 * sigma:.2g} % (one sigma)."
    )


class MountFit(NamedTuple):
    """A mount as in dive.toml and as estimated."""

    nominal: Poses | None  # as in dive.toml
    sqrt_information: Array | None  # (6, 6) of its prior; None: held
    found: Poses | None  # as estimated
    covariance: Array  # (6, 6) of (translation in the parent's axes, right-perturbed rotation)


def mount_warnings(mounts: Mapping[str, MountFit], distance_m: float) -> list[str]:
    """Warn of each mount estimated far from its nominal pose, and of mounts turned alike.

    Mounts that were held, or that the vehicle does not have, are skipped.

    Parameters
    ----------
    mounts
        Each mount as stated and as found, by its key in dive.toml.
    distance_m
        Median distance from the cameras to the hull. It turns a shift along the camera's axis into
        the error of the focal length that would look the same.
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
    sigma: Array  # (6,) of the estimate
    allowed: Array  # (6,) prior sigmas that dive.toml states
    in_parent: Array  # (3,) rotation in the parent's axes

    @staticmethod
    def of(key: str, nominal: Poses, rows: Array, found: Poses, covariance: Array) -> _Displacement:
        """Compute the displacement of a mount.

        Parameters
        ----------
        key
            Key of the mount in dive.toml, which the warning names.
        nominal, found
            Poses parent_from_child, as in dive.toml and as estimated.
        rows
            Square root (6, 6) of the prior's information.
        covariance
            (6, 6) of the estimate, its translation in the parent's axes.
        """
        by, to_child = displacement(nominal, found)
        return _Displacement(
            key=key,
            by=by,
            sigma=np.sqrt(np.maximum(np.diag(to_child @ covariance @ to_child.T), 0)),
            allowed=np.linalg.norm(np.linalg.inv(rows), axis=1),
            in_parent=nominal.rotation.apply(by[3:])[0],
        )

    def times_allowed(self) -> Array:
        """Divide the displacement (6,) by the prior sigmas.

        Zero where it is not significant, below MANY_OF_ITS_OWN of its own sigmas.
        """
        return np.where(
            np.abs(self.by) > MANY_OF_ITS_OWN * self.sigma, np.abs(self.by) / self.allowed, 0.0
        )

    def is_far(self) -> bool:
        """Tell whether the mount was found moved across the instrument's axis, or turned."""
        return bool(np.delete(self.times_allowed(), ALONG).max() > MANY_SIGMAS)

    def is_along(self) -> bool:
        """Tell whether the mount was found moved along the instrument's axis."""
        return bool(self.times_allowed()[ALONG] > MANY_SIGMAS)

    def is_turned(self) -> bool:
        """Tell whether the mount was found turned."""
        return bool(self.times_allowed()[3:].max() > MANY_SIGMAS)

    def sentence(self) -> str:
        """Write the warning of a mount that was found moved across the axis, or turned."""
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
        """Write the warning of a camera that was found moved along its axis.

        distance_m: from the camera to the hull.
        """
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
    """Warn where two or more mounts are all turned alike in their parent's axes.

    A wrong orientation of the IMU, or a wrong zero of the tray's angles, looks like that.
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
