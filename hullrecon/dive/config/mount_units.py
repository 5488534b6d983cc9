# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tell lever arms that are no metres, angles that are no degrees, and stereo rigs that are none."""

from __future__ import annotations

import math
from collections.abc import Sequence

from hullrecon.errors import InputError

FARTHEST_M = 20.0  # of a sensor from the vehicle's origin: no vehicle at a hull is as long
LEAST_BASELINE_M = 1e-3  # across the optical axis: closer no two cameras can stand
# right angles in radians, and how close to one an angle has to be (three digits) to be in radians
RIGHT_ANGLES_RAD, CLOSE_RAD = (0.5 * math.pi, math.pi, 1.5 * math.pi), 6e-4


def refuse_lever_arm(key: str, numbers: Sequence[float], source: str = "") -> None:
    """Raise InputError for x, y, z of a sensor that lie off any vehicle.

    key: of dive.toml. numbers: x, y, z, m, of the lever arm, with which angles may follow. source:
    who gives them, such as tf_static; "" for dive.toml.
    """
    reach = max(abs(value) for value in numbers[:3])
    if reach > FARTHEST_M:
        by = f" by {source}" if source else ""
        raise InputError(
            f"{key} reaches {reach:g} m{by}, farther than any vehicle: is it in millimetres?",
            where="dive.toml",
            remedy=f"give {key} in metres",
        )


def refuse_one_place(key: str, numbers: Sequence[float], source: str = "") -> None:
    """Raise InputError for a lower camera in the place of the upper one, or straight ahead of it.

    Then both see the same, and no distance follows from what differs. numbers: the lower camera's
    x, y, z in the upper one, m. key, source: as of `refuse_lever_arm`.
    """
    if math.hypot(*numbers[:2]) >= LEAST_BASELINE_M:
        return
    by = f" by {source}" if source else ""
    raise InputError(
        f"{key} puts the lower camera on the optical axis of the upper one{by}: such two see no "
        "distance",
        where="dive.toml",
        remedy=f"give the baseline of the stereo calibration in {key}, x and y across the axis",
    )


def refuse_radians(key: str, numbers: Sequence[float]) -> None:
    """Raise InputError for roll, pitch, yaw of which one is a right angle in radians.

    Most mounts have a right angle, and hardly any has 1.571 degrees. Radians of other angles are
    not noticed. key: of dive.toml. numbers: end with the three angles.
    """
    for angle in numbers[-3:]:
        for right in RIGHT_ANGLES_RAD:
            if abs(abs(angle) - right) < CLOSE_RAD:
                raise InputError(
                    f"{key} has an angle of {angle:g}, which is {math.degrees(right):g} degrees in "
                    "radians",
                    where="dive.toml",
                    remedy=f"give roll, pitch, yaw of {key} in degrees",
                )
