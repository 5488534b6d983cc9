# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Words: measurements of a dive that contradict each other, and which suspects explain it.

Functions here take the values of a finding by name and return its sentence, or a part of it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import degrees

from hullrecon.findings.logs import Words

WATER = 1.333  # refractive index of fresh water, salt water has 1.34 [Hecht2017]
# share by which a ratio of focal lengths may differ from WATER: wrong ones also bend the path,
# which changes the estimate
NEAR = 0.1


def _scaled(found: float | None) -> str:
    """Describe velocities whose truth is 1 + found times what was measured."""
    share = 1 / (1 + (found or 0.0)) - 1 if (found or 0.0) > -1 else float("inf")
    return f"with the DVL's velocities {100 * abs(share):.0f} % too {_long(share)}"


def _deeper(found: float | None) -> str:
    """Describe depths whose truth is `found` times what was measured."""
    share = 1 / (found or 1.0) - 1
    if share < -1:
        return "with the depths of the pressure sensor counted upwards"
    return (
        f"with the depths of the pressure sensor {100 * abs(share):.0f} % too "
        f"{'deep' if share > 0 else 'shallow'}"
    )


def _turned(key: str) -> Callable[[float | None], str]:
    """Make the function that words by how much a mount is turned, rad. key: of dive.toml."""
    return lambda found: f"with {key} turned by {degrees(found or 0.0):.1f} degrees"


def _long(share: float) -> str:
    return "long" if share > 0 else "short"


def _baseline(found: float | None) -> str:
    """Word how much longer the baseline is than calibrated, as a share."""
    share = found or 0.0
    return (
        f"with the baseline {100 * abs(share):.0f} % {'longer' if share > 0 else 'shorter'} than "
        "camera.bottom.pose_in_top says"
    )


def _focal_ratio(whose: str) -> Callable[[float | None], str]:
    """Make the function that words a ratio of focal lengths, and the medium it is typical of.

    whose: words before "focal lengths", such as "the top camera's ".
    """

    def say(found: float | None) -> str:
        ratio = found or 0.0
        said = f"with {whose}focal lengths {ratio:.2f} times the calibration's"
        if abs(ratio / WATER - 1) < NEAR:
            return f"{said}, as where the camera was calibrated in air"
        if abs(ratio * WATER - 1) < NEAR:
            return f"{said}, as where a calibration in water was converted from air to water again"
        return said

    return say


def _center_shift(whose: str) -> Callable[[float | None], str]:
    """Make the function that words the shift, px, of a principal point. whose: camera it is of."""
    return lambda found: (
        f"with {whose} principal point {found or 0.0:.0f} px from where the calibration has it"
    )


def _readout(whose: str) -> Callable[[float | None], str]:
    """Make the function that words a readout time, s. whose: words after "image"."""
    return lambda found: (
        f"with the rows of an image{whose} exposed one after another, "
        f"{1e3 * (found or 0.0):.0f} ms from the first to the last"
    )


def _distortion(found_px: float | None) -> str:
    apart = "" if found_px is None else f", {found_px:.1f} px (rms) off it"
    return f"with another distortion than the calibration's{apart}"


def _dvl_clock(found_s: float | None) -> str:
    """Word by how much the DVL's stamps are late beside the images'."""
    late_s = found_s or 0.0
    return (
        f"with the DVL's stamps {abs(late_s):.2f} s {'late' if late_s > 0 else 'early'} beside the "
        f"images' (dvl.time_offset = {-late_s:.2f}, or camera.top.time_offset = {late_s:.2f})"
    )


# By suspect: what makes all other measurements agree. The argument is the suspect's own error,
# where the adjustment estimated it
SUSPECTS: Mapping[str, Callable[[float | None], str]] = {
    "pressure": lambda _: "without the depths of the pressure sensor",
    "pressure-scale": _deeper,
    "dvl-velocities": lambda _: "without the DVL's velocities",
    "dvl-scale": _scaled,
    "dvl-mount": _turned("dvl.mount"),
    "dvl-clock": _dvl_clock,
    "dvl-ranges": lambda _: "without the DVL's ranges",
    "imu": _turned("the IMU"),
    "imu-turns": lambda _: "without the IMU's turns",
    "tray": lambda _: "without the tray's angles",
    "positions": lambda _: "without the positions from outside",
    "camera-mount": _turned("camera.top.mount"),
    "focal-length": _focal_ratio(""),
    "focal-length-top": _focal_ratio("the top camera's "),
    "focal-length-bottom": _focal_ratio("the bottom camera's "),
    "principal-point": _center_shift("the"),
    "principal-point-bottom": _center_shift("the bottom camera's"),
    "distortion": _distortion,
    "stereo-rig": _baseline,
    "readout": _readout(""),
    "readout-top": _readout(" of the top camera"),
    "readout-bottom": _readout(" of the bottom camera"),
}
# Suspects whose own error the adjustment estimates and corrects, up to a largest believable size
CORRECTED = frozenset({"dvl-scale", "dvl-mount", "imu", "camera-mount", "stereo-rig", "distortion"})
# What the user can do where one suspect alone explains a contradiction
REMEDIES: Mapping[str, str] = {
    "pressure": "name the topic of the water's pressure, or leave topics.pressure away",
    "pressure-scale": "leave topics.pressure away",
    "positions": "leave topics.position away",
    "readout": "give that time, in s, as readout_s of camera.top and camera.bottom",
    "readout-top": "give that time, in s, as readout_s of camera.top",
    "readout-bottom": "give that time, in s, as readout_s of camera.bottom",
}


def _other_beams(beams: Sequence[int], before_mm: float, after_mm: float) -> str:
    order = ", ".join(str(beam) for beam in beams)
    return (
        f"DVL: its ranges are those of beams {order}, in another order than its beams have: so "
        f"their ends lie {after_mm:.0f} mm from the CAD model (root mean square), and "
        f"{before_mm:.0f} mm as they are"
    )


TRAY_READINGS = {
    "sign": 'grow the other way (give the other tray.positive, "up" or "down")',
    "rad": 'are in radians (tray.joint_unit = "rad")',
    "deg": 'are in degrees (tray.joint_unit = "deg")',
}


def _other_tray(reading: str, before_mm: float, after_mm: float) -> str:
    """Say that the CAD model fits where the tray's angles are read otherwise.

    reading: a key of TRAY_READINGS. before_mm, after_mm: RMS distance of the beams' ends from the
    CAD model, as read and read otherwise.
    """
    return (
        f"the tray's angles {TRAY_READINGS[reading]}: so the ends of the DVL's beams lie "
        f"{after_mm:.0f} mm from the CAD model (root mean square), and {before_mm:.0f} mm as they "
        "are"
    )


def _contradiction(beyond: str, explanations: Sequence[Sequence[object]]) -> str:
    """Tell which suspects, left out or freed, make all other measurements agree.

    Parameters
    ----------
    beyond
        The correction that is too large to be believed, in words, "" without one.
    explanations
        Suspect (a key of SUSPECTS) and its own error or None, the best first.
    """
    what = "the measurements contradict each other"
    if beyond:
        what += f" by more than a correction may take out ({beyond})"
    if not explanations:
        return f"{what}, and no one sensor explains it"
    phrases = [SUSPECTS[str(name)](_number(found)) for name, found in explanations]
    if len(phrases) > 1:
        return f"{what}; all else agrees {', or as well '.join(phrases)}"
    remedy = REMEDIES.get(str(explanations[0][0]))
    return f"{what}; all else agrees {phrases[0]}{f': {remedy}' if remedy else ''}"


def _number(value: object) -> float | None:
    return float(value) if isinstance(value, int | float) else None


def _explained_as_well(explanations: Sequence[Sequence[object]]) -> str:
    """Warn that others explain as well what was corrected: pairs of suspect and estimated error."""
    return (
        f"What was taken out is explained as well {_others(explanations)}: which of them is wrong "
        "is not known, and if it is not what was corrected, the result is wrong by as much."
    )


def _explained_better(explanations: Sequence[Sequence[object]]) -> str:
    """Warn of errors that are not corrected: pairs of suspect and estimated error."""
    return (
        f"The measurements agree better {_others(explanations)}. That is not taken out: the result "
        "is wrong by as much, and so is what else was found to be off."
    )


def _others(explanations: Sequence[Sequence[object]]) -> str:
    """Join the words of explanations: pairs of suspect (a key of SUSPECTS) and estimated error."""
    return " or ".join(SUSPECTS[str(name)](_number(found)) for name, found in explanations)


def _scale_untold(per_cent: float | None) -> str:
    """Say that nothing in a dive tells its CAD model's scale.

    per_cent: one sigma of the scale by the surveyed shape. None where that is as plain as a plane.
    """
    if per_cent is None:
        text = (
            "Nothing in this dive tells the CAD model's scale, or whether it is of this ship: the "
            "surveyed part of the hull is too plain to tell. Where on the hull the dive was is "
            "what hull.pose says. The sigmas of the position hold for a model that is right and "
            "to scale"
        )
    else:
        text = (
            "The surveyed part tells the CAD model's proportions and scale to "
            f"{per_cent:.0f} % (one sigma), and nothing else in this dive does: the sigmas of the "
            "position on the hull hold for a model that is to scale"
        )
    return f"{text}. With hull.length_overall, from the ship's papers, the scale is checked."


ERRORS: dict[str, Words] = {
    "contradiction": _contradiction,
    "other-beams": _other_beams,
    "other-tray": _other_tray,
    "tray-offset": "the tray's angles are off by {offset_deg:+.0f} degrees, or hull.pose is turned "
    "by as much about the tray's axis: with angles put right by that the ends of the DVL's beams "
    "lie {after_mm:.0f} mm from the CAD model (root mean square) where hull.pose has it; add "
    "{add_deg:+.1f} to tray.offset_deg, or correct hull.pose",
}
WARNINGS: dict[str, Words] = {
    "cad-scale-untold": _scale_untold,
    "cad-model-untold": "The surveyed part of the hull is too plain to tell whether the CAD model "
    "is of this ship: another of her length would fit as well, and where on the hull the dive was "
    "is what hull.pose says. The sigmas of the position hold for a model that is right.",
    "lengths-untold": "Nothing in this dive but the DVL tells how long distances are. The sigmas "
    "hold for a speed of sound that is right to {per_cent:.2g} % (dvl.scale_sigma): set for sea "
    "water, a DVL measures 3 % too long in fresh water.",
    "explained-as-well": _explained_as_well,
    "explained-better": _explained_better,
}
