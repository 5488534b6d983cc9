# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read orientations whose fourth number was not logged: parts of quaternions, and angles.

Some drivers log the vector part of a quaternion alone. Others write roll, pitch and yaw in place of
x, y and z. With both w is one number in all messages. Which of them it is shows in the turns: the
orientation has to turn as the rates do.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.dive.logs.turns import scale_between, turns_within_seconds
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding
from hullrecon.typing import Array, Ints

LEAST_READINGS = 50  # with one w; fewer may be of a vehicle that stands still
# Length of a quaternion that is off 1 by as much as the rounding of w to three digits allows
ROUNDED = 1e-3
# The turns of two forms differ by a factor of 2 or more, and those of rates and orientation by
# little: the border is halfway
NEAR_FACTOR = 2**0.5


def complete_quaternions(
    t_ns: Ints, quaternion: Array, rates: Array, notes: list[Finding]
) -> Array:
    """Complete quaternions (n, 4) of which only x, y, z were logged. All others stay unchanged.

    Parameters
    ----------
    t_ns : (n,) stamps in order
    quaternion : (n, 4) x, y, z, w as logged
    rates : (n, 3) rad/s about the same axes, NaN where not logged
    notes : what x, y and z were taken for is added

    Raises
    ------
    InputError
        w was not logged, and the rates do not tell what x, y and z are.
    """
    vector, w = quaternion[:, :3], quaternion[:, 3]
    known = np.isfinite(vector).all(axis=1)
    is_constant = len(np.unique(w[known])) == 1 and len(np.unique(vector[known], axis=0)) > 1
    if known.sum() < LEAST_READINGS or not is_constant:
        return quaternion
    if np.abs(np.linalg.norm(quaternion[known], axis=1) - 1).max() < ROUNDED:
        return quaternion
    fitting = {
        form: rotation.as_quat()
        for form, read in FORMS.items()
        if (rotation := read(vector[known])) is not None
        and _turns_as_rates(t_ns[known], rotation, rates[known])
    }
    values = {"w": float(w[known][0]), "count": int(known.sum())}
    if len(fitting) != 1:
        raise InputError(
            f"the w of its quaternions is {values['w']:g} in all {values['count']} messages, so "
            "that x, y and z alone were logged, and the rates do not tell whether these are the "
            "rest of quaternions or angles",
            where="imu",
            remedy="log an IMU that gives orientation as a quaternion x, y, z, w",
        )
    ((form, completed),) = fitting.items()
    notes.append(Finding("quaternions-completed", {**values, "form": form}, "imu"))
    out = np.full_like(quaternion, np.nan)
    out[known] = completed
    return out


def _from_vector_part(vector: Array) -> Rotation | None:
    """Complete the vector parts x, y, z (n, 3) of unit quaternions by w >= 0.

    None where one is longer than 1.
    """
    squares = (vector**2).sum(axis=1)
    if squares.max() > 1 + ROUNDED:
        return None
    w = np.sqrt(np.maximum(1 - squares, 0.0))
    return Rotation.from_quat(np.column_stack([vector, w]))


def _from_angles(vector: Array) -> Rotation:
    return Rotation.from_euler("ZYX", vector[:, ::-1])


def _from_degrees(vector: Array) -> Rotation:
    return _from_angles(np.radians(vector))


# By what x, y and z are: from those (n, 3) to orientations, None where they cannot be that
FORMS: Mapping[str, Callable[[Array], Rotation | None]] = {
    "the rest of unit quaternions": _from_vector_part,
    "roll, pitch and yaw in radians": _from_angles,
    "roll, pitch and yaw in degrees": _from_degrees,
}


def _turns_as_rates(t_ns: Ints, rotation: Rotation, rates: Array) -> bool:
    """Tell whether orientations (n) turn as the rates (n, 3) do, to less than NEAR_FACTOR."""
    by_rates, turned, _ = turns_within_seconds(t_ns, rotation, rates)
    factor = scale_between(by_rates, turned)
    return factor is not None and 1 / NEAR_FACTOR < factor < NEAR_FACTOR
