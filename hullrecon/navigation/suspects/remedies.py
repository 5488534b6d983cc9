# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Name the key of dive.toml that corrects a sensor's fault, where there is one."""

from __future__ import annotations

from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import Poses
from hullrecon.geometry.rotations import mount_angles_deg
from hullrecon.navigation.suspects.comparisons.comparison import Sensor
from hullrecon.navigation.suspects.faults.axes import Conventions, is_mirrored, signed_axes

# the other of two conventions
OTHER = {"ned": "enu", "enu": "ned", "up": "down", "down": "up"}
# between axes forward, port, up and axes forward, starboard, down
OTHER_SIDE = Rotation.from_euler("x", 180, degrees=True)


def find_remedy(
    sensor: Sensor, fault: str, value: str, given: Conventions, tray_from_dvl: Poses
) -> str:
    """Name the keys of dive.toml, with their values, that correct a fault.

    Parameters
    ----------
    sensor, fault, value
        Those of the Hypothesis that explains a contradiction.
    given, tray_from_dvl
        Conventions and mount of the DVL that dive.toml gives now.

    Returns
    -------
    str
        Part of a sentence, "" where no key corrects the fault.
    """
    if sensor is Sensor.DVL and fault in ("axes", "turn", "mount"):
        return _mount_of_turned_dvl(fault, value, tray_from_dvl)
    if (sensor, fault) == (Sensor.TRAY, "sign"):
        unit = f' and tray.joint_unit = "{value}"' if value else ""
        return f'give tray.positive = "{OTHER[given.tray_positive]}"{unit}'
    if (sensor, fault) == (Sensor.TRAY, "reversed"):
        offset_deg = float(value) - given.tray_offset_deg
        positive = f'tray.positive = "{OTHER[given.tray_positive]}"'
        return f"give {positive} and tray.offset_deg = {offset_deg:g}"
    if sensor is not Sensor.ATTITUDE:
        return ""
    vehicle_from_imu = given.vehicle_from_imu
    frame = f'give imu.frame = "{OTHER[given.imu_frame]}"'
    # As `imu_samples` (streams/imu.py) applies frame and mount, one after the other
    if (fault, value) == ("frame", "all axes"):
        mount = OTHER_SIDE * vehicle_from_imu * OTHER_SIDE
        return frame if given.imu_mount_deg is None else f"{frame} and {_mount_key(mount)}"
    if (fault, value) == ("frame", "global axes"):
        return f"{frame} and {_mount_key(vehicle_from_imu * OTHER_SIDE)}"
    if (fault, value) == ("frame", "vehicle's axes"):
        return f"give {_mount_key(OTHER_SIDE * vehicle_from_imu)}"
    if fault == "mount":
        turn = Rotation.from_euler("z", float(value), degrees=True)
        return (
            f"give {_mount_key(turn * vehicle_from_imu)}, or correct dvl.mount where that is wrong"
        )
    if fault == "angle":
        return "log the quaternion of the angle itself"
    if fault == "body":
        angles_deg = [float(angle) for angle in value.split(", ")]
        turn = Rotation.from_euler("ZYX", angles_deg[::-1], degrees=True)
        return f"give {_mount_key(turn * vehicle_from_imu)}"
    return ""


def _mount_of_turned_dvl(fault: str, value: str, tray_from_dvl: Poses) -> str:
    """Name dvl.mount for a DVL whose velocities are right once they are turned.

    fault, value: a turn about the DVL's axis or about the tray's z, deg, or its axes, as in
    `signed_axes`.
    """
    position = tray_from_dvl.translation[0].tolist()
    if fault in ("turn", "mount"):
        turn = Rotation.from_euler("z", float(value), degrees=True)
    elif is_mirrored(axes := dict(signed_axes())[value]):
        return ""  # no mount gives them
    else:
        turn = Rotation.from_matrix(axes)
    given = tray_from_dvl.rotation[0]
    angles_deg = mount_angles_deg(turn * given if fault == "mount" else given * turn)
    shown = ", ".join(f"{number:g}" for number in [*position, *angles_deg])
    mount = f"give dvl.mount = [{shown}]"
    return mount if fault == "mount" else f"where the whole DVL sits so, {mount}"


def _mount_key(vehicle_from_imu: Rotation) -> str:
    """Write a mount as imu.mount_deg of dive.toml: roll, pitch and yaw, deg."""
    shown = ", ".join(f"{angle:g}" for angle in mount_angles_deg(vehicle_from_imu))
    return f"imu.mount_deg = [{shown}]"
