# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Words: contradictions between sensors, mounts and clocks.

Functions here take the values of a finding by name and return its sentence, or a part of it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from hullrecon.findings.logs import Words, duration, names

FAULTS = {  # by sensor and fault (of navigation/suspects): what is wrong, as a statement
    ("pressure", "unit"): "the readings are in {value}, not in {unit}",
    ("pressure", "gauge"): "the readings are in {value}, and the pressure above the air's",
    ("pressure", "sign"): "the readings grow upwards, not with depth",
    ("pressure", "scale"): "the depths have to be multiplied by {value}",
    ("pressure", "constant"): "the readings stand still: they are not the water's pressure",
    ("DVL", "unit"): "the velocities are in {value}, not in m/s",
    ("DVL", "scale"): "the velocities have to be multiplied by {value}",
    ("DVL", "mount"): "it sits turned by about {value} degrees about the tray's z axis, beside "
    "what dvl.mount says",
    ("DVL", "turn"): "it is turned about its axis: its velocities have to be turned by "
    "about {value} degrees",
    ("DVL", "offset"): "the velocities are off by a constant, about {value} m/s along x, y, z",
    ("DVL", "ranges"): "its ranges have to be multiplied by {value}",
    ("DVL", "beams"): "its ranges are those of beams {value}, in another order than its beams have",
    ("DVL", "axes"): "the axes of the velocity are {value} of those that its convention has",
    ("DVL", "along"): "the velocities are those along beams 1, 2 and 3, {value} the instrument",
    ("DVL", "mirrored"): "velocities and beams are of left-handed axes, {value} the other way",
    ("DVL", "repeated"): "velocities that repeat one value were taken without bottom lock",
    ("IMU's rates", "unit"): "the angular velocities are in {value}, not in rad/s",
    ("IMU's rates", "scale"): "the angular velocities have to be multiplied by {value}",
    ("IMU's rates", "bias"): "the angular velocities are off by {value} degrees a second about x, "
    "y, z",
    ("IMU's rates", "axes"): "the angular velocities are about {value} of the orientation's axes",
    ("IMU's orientation", "order"): "the quaternion is {value}",
    ("IMU's orientation", "frame"): "imu.frame does not fit: {value} are of the other frame",
    (
        "IMU's orientation",
        "mount",
    ): "the IMU sits turned by about {value} degrees about the vehicle's z "
    "axis, beside what imu.mount_deg says",
    (
        "IMU's orientation",
        "body",
    ): "the IMU sits turned by roll, pitch, yaw of {value} degrees in the vehicle, beside what "
    "imu.mount_deg says",
    ("IMU's orientation", "axes"): "the orientation is of other axes than imu.frame says: {value}",
    ("IMU's orientation", "mirrored"): "orientation, rates and accelerations are of left-handed "
    "axes, {value} the other way",
    ("IMU's orientation", "negated"): "orientation, rates and accelerations have {value} with the "
    "other sign",
    ("IMU's orientation", "heading"): "its heading swings by {value} degrees (root mean square) "
    "about that of the rates, as a compass does near a ship's steel",
    ("IMU's orientation", "angle"): "it turns by {value} the angle that the vehicle does",
    ("IMU's orientation", "sign"): "the orientation has its {value} with the other sign",
    ("IMU's acceleration", "axes"): "the accelerations are along {value} of the orientation's axes",
    ("IMU's acceleration", "global"): "the accelerations are along the global axes",
    ("IMU's acceleration", "sign"): "the accelerations are those of gravity, with the other sign",
    ("camera", "medium"): "its focal lengths are {value} times too short, as those of a "
    "calibration made in air are under water",
    ("camera", "port"): "its rays are those in the air behind a flat port, and its focal lengths "
    "about {value} times too short: the calibration was made in air",
    ("camera", "size"): "its calibration is of pictures {value} times as large as those logged",
    ("camera", "focal"): "its focal lengths have to be multiplied by {value}",
    ("camera", "distortion"): "its distortion is not its calibration's: the images fit with k1 "
    "changed by about {value}",
    ("camera", "picture"): "its pictures are turned or mirrored: x and y of its calibration are "
    "{value} of the pictures",
    ("tray's angle", "unit"): "the angle is in {value}, not in {unit}",
    ("tray's angle", "zero"): "the angle's zero is off by {value} degrees",
    ("tray's angle", "reversed"): "the angle grows the other way, and its zero is off by {value} "
    "degrees",
    ("tray's angle", "sign"): "the angle grows the other way",
}
# The unit that was expected, by the one that was found. For a pressure it is Pa.
UNITS = {"cm": "m", "mm": "m", "ft": "m", "deg": "rad", "rad": "deg", "turns": "rad"}
# What a found unit may be in its place, as motion does not tell the two apart
NEAR_UNITS = {
    ("pressure", "bar"): ' (or in kgf/cm2, 2 % less: then give pressure.unit = "kgf/cm2")'
}
# What to do about a sensor that is wrong in no way that is known
LEFT_AWAY = {"pressure": "leave topics.pressure away, or name the topic of the water's pressure"}
DONE = {
    "constant": "they are left out",
    "repeated": "they are left out",
    "heading": "the heading of the rates was taken, and their drift counts in the sigmas",
    "order": "it was put right",
    "angle": "it was put right",
    "sign": "it was put right",
}
# By what was compared, how two sensors contradict each other. `first` and `second` are what either
# of them measured, in SI units
EVIDENCE = {
    "level": "half of the depths are above the water, up to {first:.1f} m",
    "turn": "within a second the rates turn by up to {first_deg:.3g} degrees, the orientation by "
    "{second_deg:.3g}",
    "heading": "within seconds the rates turn by up to {first_deg:.3g} degrees, the orientation by "
    "{second_deg:.3g}, and they part about the vertical alone, as where a compass swings near a "
    "ship's steel",
    "gravity": "gravity does not pull along the vertical of the orientation",
    "flow": "between two images the hull moves by up to {first_deg:.3g} degrees by the images, by "
    "{second_deg:.3g} by the DVL's velocity and ranges",
    "view": "where the vehicle moves on, the features of two images show it turning otherwise than "
    "the orientation",
    "push": "within a second the DVL's velocity changes by up to {first:.3g} m/s, the integral of "
    "the IMU's acceleration by {second:.3g} m/s, or in another direction",
    "range": "the hull in the DVL's ranges comes nearer where its velocity leads away from it",
    "hull": "the hull in the DVL's ranges turns the other way than the orientation",
    "depth": "in 3 s the depth by pressure changes by up to {first:.3g} m, the way of the DVL by "
    "{second:.3g} m",
}


def _evidence(kind: object, first: float, second: float) -> str:
    """Word what was compared, a key of EVIDENCE, and what either sensor measured, in SI units."""
    return EVIDENCE[str(kind)].format(
        first=first,
        second=second,
        first_deg=math.degrees(first),
        second_deg=math.degrees(second),
    )


def _fault(sensor: str, fault: str, value: str) -> str:
    """Word a sensor's fault, a key of FAULTS. value: the unit, factor or axes that explain it."""
    said = FAULTS[sensor, fault].format(value=value, unit=UNITS.get(value, "Pa"))
    return f"{said}{NEAR_UNITS.get((sensor, value), '')}"


def _wrong(
    sensor: str,
    fault: str,
    value: str,
    kind: str,
    first: float,
    second: float,
    misfit: float,
    remedy: str = "",
) -> str:
    """Name the fault that a sensor was found to have, with what shows it and what to do."""
    said = f"{sensor}: {_fault(sensor, fault, value)} ({_evidence(kind, first, second)})"
    return f"{said}: {remedy}" if remedy else said


def _mended(
    sensor: str, fault: str, value: str, kind: str, first: float, second: float, misfit: float
) -> str:
    """Say what was wrong with a sensor and was put right. Arguments as of `_wrong`."""
    said = _wrong(sensor, fault, value, kind, first, second, misfit)
    return f"{said}; {DONE.get(fault, 'they were put right')}"


def _wrong_in_part(
    sensor: str,
    fault: str,
    value: str,
    kind: str,
    first: float,
    second: float,
    misfit: float,
    time: str,
    from_on: bool,
) -> str:
    """Name a fault that a sensor has from a time on or up to it, and how to leave that part out."""
    since = f"from about {time} on" if from_on else f"until about {time}"
    limit = "dive.to" if from_on else "dive.from"
    return (
        f"{sensor}: {since}, and in that part alone, {_fault(sensor, fault, value)} "
        f"({_evidence(kind, first, second)}): was its driver started anew? {limit} = {time} leaves "
        "this part out"
    )


def _contradict(
    sensors: Sequence[str], kind: str, first: float, second: float, misfit: float
) -> str:
    """Say that one sensor contradicts the others, or that several contradict each other."""
    evidence = _evidence(kind, first, second)
    if len(sensors) == 1:
        said = (
            f"{sensors[0]}: it contradicts the sensors that it is compared with, and no other "
            f"unit, sign or axis explains it: {evidence}"
        )
        return f"{said}; {LEFT_AWAY[sensors[0]]}" if sensors[0] in LEFT_AWAY else said
    by_rates = (
        '. If so, give imu.heading = "rates"; `hullrecon check` then tells the '
        "imu.heading_drift_deg_per_hour of the rates"
    )
    return (
        f"{' and '.join(sensors)} contradict each other, and which of them is wrong is not known: "
        f"{evidence}{by_rates if kind == 'heading' else ''}"
    )


def _unit_open(readings: Sequence[Sequence[object]]) -> str:
    """Ask for the unit of a pressure where several fit: fault, unit, least and greatest depth."""
    depths = ", or as well ".join(
        f"in {unit}{' above the air' if fault == 'gauge' else ''} ({low:.1f} to {high:.1f} m deep)"
        for fault, unit, low, high in readings
    )
    return (
        f"the depths lie above the water, so that the readings are in another unit: {depths}; give "
        "pressure.unit, and pressure.atmosphere = 0 for pressures above the air's"
    )


def _beside(others: Sequence[str], seconds: float, after: bool) -> str:
    """Say that a stream lies wholly before or after others. seconds: the gap between."""
    side = "after" if after else "before"
    return f"it was read {duration(seconds)} {side} {names(others)}, and never at the same time"


def _shifted(seconds: float, shared_s: float, length_s: float, key: str) -> str:
    """Say that a log is shifted in time as a whole.

    seconds: later than the others, negative if earlier. shared_s: of its length_s within theirs.
    key: of dive.toml, which would correct its clock.
    """
    side = "after" if seconds > 0 else "before"
    return (
        f"it begins and ends {abs(seconds):.1f} s {side} all others, which begin and end together, "
        f"and shares {shared_s:.1f} s of its {length_s:.1f} s with them: is its clock off ({key})?"
    )


LEAPS = {18: "GPS time is 18 s ahead of UTC", 37: "TAI is 37 s ahead of UTC"}


def _moved(seconds: float, compared: str = "depth and DVL") -> str:
    """Say that stamps, late by `seconds`, were put right. compared: what shows one motion then."""
    side = "late" if seconds > 0 else "early"
    leap = next((f" ({words})" for s, words in LEAPS.items() if abs(abs(seconds) - s) < 0.5), "")
    return (
        f"its stamps are {abs(seconds):.1f} s {side}{leap}: so its log begins and ends beside the "
        f"others, and {compared} show one motion; they were put right"
    )


def _apart(
    others: Sequence[str],
    seconds: float,
    after: bool,
    key: str,
    unset: bool,
    given_s: float,
    hours: float | None,
    offset_s: float | None,
    by_motion: bool,
) -> str:
    """Describe the gap between a sensor's stamps and those of the others, and how to close it.

    Parameters
    ----------
    others, seconds, after : the others' names, and how long after (or before) them it was read
    key : of dive.toml that corrects the sensor's stamps
    unset : its clock counts from 1970
    given_s : what dive.toml has added to the stamps already
    hours, offset_s, by_motion : time zone, or None; what to add to the logged stamps, or None; and
        whether the vehicle's motion tells it
    """
    ends = f"begins {duration(seconds)} after {names(others)} end"
    if not after:
        ends = f"ends {duration(seconds)} before {names(others)} begin"
    clock = " (it counts from 1970: it was never set)" if unset else ""
    text = f"it {ends}, so that one of the clocks is wrong{clock}"
    if offset_s is None:
        check = " (`hullrecon check` finds it where depth and DVL show one motion)"
        return (
            f"{text}: give {key}, the seconds to add to its stamps, to within a minute"
            f"{check if key in ('dvl.time_offset', 'pressure.time_offset') else ''}"
        )
    zone = f"{hours:+g} h, as of a time zone" if hours is not None else ""
    motion = "by depth and DVL, which then show one motion" if by_motion else ""
    ends = "" if zone or motion else "it then begins and ends with the others"
    why = "; ".join(part for part in (zone, motion, ends) if part)
    return f"{text}: {'set' if by_motion else 'try'} {key} = {offset_s:.2f} ({why})"


def _motions_apart(seconds: float) -> str:
    """Say that depth and DVL show one motion at two times. seconds: to add to the DVL's stamps."""
    return (
        f"depth and DVL show one motion, {duration(abs(seconds))} apart: one of the clocks is "
        f"wrong; set dvl.time_offset = {seconds:.2f} if it is the DVL's, or "
        f"pressure.time_offset = {-seconds:.2f} if it is the pressure sensor's"
    )


def _in_other_unit(others: Sequence[str], factor: int, larger: bool) -> str:
    """Say that stamps are a power of ten larger or smaller than others'."""
    size = "larger" if larger else "smaller"
    return (
        f"its stamps are {factor} times {size} than those of {names(others)}: they are in "
        "another unit of time than its format has; write them in that unit"
    )


def _late(sensor: str, seconds: float) -> str:
    return (
        f"{sensor}: its readings fit the other sensors' with stamps that are {abs(seconds):g} s "
        f"{'earlier' if seconds > 0 else 'later'}: is a clock off?"
    )


def _depth_steps(by_m: Sequence[float], first: str, offset_m: float) -> str:
    """Say that steps of the depth were taken off, the first at `first`. offset_m: of heights."""
    steps = ", ".join(f"{step:+.2f}" for step in by_m)
    return (
        f"pressure: the depth steps by {steps} m at once ({first}), where the DVL saw no such "
        "motion; it was taken off. Which of the levels is right is not known: heights are known to "
        f"{offset_m:.2f} m (one sigma)"
    )


def _drifting(sensors: Sequence[str], per_cent: float) -> str:
    return (
        f"{' or '.join(sensors)}: its readings fit the other sensors' with a clock that runs "
        f"{abs(per_cent):.1f} % {'slower' if per_cent > 0 else 'faster'}: the stamps do not count "
        "seconds"
    )


ERRORS: dict[str, Words] = {
    "clocks-apart": _apart,
    "stamps-in-other-unit": _in_other_unit,
    "motions-apart": _motions_apart,
    "sensor-wrong": _wrong,
    "sensor-wrong-in-part": _wrong_in_part,
    "sensors-contradict": _contradict,
    "pressure-unit-open": _unit_open,
    "images-blank": "none of {count} images, spread over the dive, shows a feature: they are "
    "black, white or out of focus. A dive with a DVL is mapped by that alone, without "
    "[camera.top] and [camera.bottom] in dive.toml",
    "images-frozen": "{count} images, spread over the dive, are one picture to the last bit: "
    "the camera or its driver stood still. A dive with a DVL is mapped by that alone, without "
    "[camera.top] and [camera.bottom] in dive.toml",
}
WARNINGS: dict[str, Words] = {
    "sensor-mended": _mended,
    "sensors-late": _late,
    "sensors-drift": _drifting,
    "sensors-part": _contradict,
    "depth-steps": _depth_steps,
    "images-blank-some": "{blank} of {count} images, spread over the dive, show no feature: they "
    "are black, white or out of focus, and tell nothing",
    "images-unmatched": "none of {count} pairs of neighbouring images, spread over the dive, could "
    "be matched: they have too little in common, and a run ends where no other images have more",
    "images-frozen-some": "{same} of {count} images, spread over the dive, are one picture to "
    "the last bit: the camera or its driver stood still meanwhile",
    "read-beside": _beside,
    "stream-shifted": _shifted,
    "stream-moved": _moved,
    "tray-still": "the tray's angle is {angle_deg:.3g} degrees in all {count} readings: was it "
    'read? tray.joint = "" says that nothing turns, until then each angle is known to 10 degrees '
    "(one sigma)",
    "tray-frozen": "tray: {count} of {total} angles repeat the one before to the last digit, "
    "{longest} in a row, and the others have noise: they were not read, and are left out",
    "tray-little": "the tray's angle turns by {span_deg:.2g} degrees in the whole dive, less than "
    'tray.sigma_deg ({sigma_deg:.2g}): is it in radians (tray.joint_unit = "rad")? Until then each '
    "angle is known to 10 degrees (one sigma)",
    "imu-single-reading": "the IMU gave a single reading, which tells no attitude",
    "imu-upside-down": 'imu: gravity pulls upward with imu.frame = "{frame}": it is "{other}", or '
    "the accelerations are those of gravity, with the other sign",
    "imu-gravity-tilted": "imu: gravity is {degrees:.0f} degrees off the vertical of the "
    "orientation",
    "velocities-without-attitude": "{percent:.0f} % of the DVL's velocities lie where no attitude "
    "was read: a run cannot use them",
    "imu-without-velocities": "the IMU was read for {seconds:.1f} s under water before the first "
    "or after the last velocity of the DVL: no image tells where the vehicle was then, and a run "
    "leaves that part out",
    "ranges-above-water": "by depth, attitude, the tray's angle and dvl.mount {percent:.0f} % of "
    "the DVL's returns lie above the water",
    "camera-dvl-apart": "camera.top looks {degrees:.0f} degrees away from where the DVL looks, by "
    "their mounts",
    "baseline-implausible": "the cameras are {metres:.3f} m apart: is camera.bottom.pose_in_top in "
    "metres?",
    "bottom-camera-delayed": lambda after_stamp_ms, sigma_ms, offset_s: (
        f"its images were exposed {abs(after_stamp_ms):.1f} ms "
        f"{'after' if after_stamp_ms > 0 else 'before'} "
        f"those of the top camera with the same stamps (sigma {sigma_ms:.1f} ms): on every course "
        "they lie across the epipolar lines by as much as the vehicle moves in that time. A run "
        f"reckons with it, and camera.bottom.time_offset = {offset_s:.4f} states it, as long as it "
        "is not the top camera whose stamps are off"
    ),
    "mounts-disagree": "imu.mount_deg and dvl.mount turn the DVL's axes {degrees:.0f} degrees "
    "apart, and both say how the one DVL sits in the vehicle: is one of them wrong?",
}
