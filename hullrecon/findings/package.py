# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Words: what a dive package holds, what it lacks for a run, and what is left to fill in.

Functions here take the values of a finding by name and return its sentence, or a part of it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from hullrecon.findings.logs import Words, count_noun

WITHOUT_CAMERAS = (
    "take [camera.top] and [camera.bottom] out of dive.toml (a lone camera is the top one)"
)
DVL_ALONE = (
    "a dive with a DVL is mapped by that alone, without [camera.top] and [camera.bottom] in "
    "dive.toml"
)
A_RUN_NEEDS = "a run needs a DVL with an IMU, or two cameras"
MOST_SHOWN = 2  # topics of unread DVLs in one line

_IN_VEHICLE = "x, y, z in m in the vehicle's frame (x forward, y starboard, z down)"
_MOUNT = "x, y, z in m, roll, pitch, yaw in degrees"
MEANING = {  # of the keys that no log can tell
    "tray.origin": f"where the tray turns, {_IN_VEHICLE}",
    "pressure.origin": f"the pressure sensor, {_IN_VEHICLE}",
    "dvl.mount": f"the DVL on the tray, {_MOUNT}",
    "camera.top.mount": f"the camera on the tray, {_MOUNT}",
    "camera.bottom.pose_in_top": "the lower camera in the upper one's frame, from the stereo "
    f"calibration, {_MOUNT}",
    "sonar.origin": f"where the sonar's servo turns, {_IN_VEHICLE}",
    "sonar.mount": f"the sonar on its servo, {_MOUNT}",
    "position.origin": f"transponder of USBL or antenna of GPS, {_IN_VEHICLE}",
    "hull.pose": f"first guess of the CAD model in the global frame, {_MOUNT}",
}


def _numbers(values: object) -> str:
    """List numbers, or write a value that is no list as it is."""
    return ", ".join(f"{v:g}" for v in values) if isinstance(values, list | tuple) else str(values)


def _unusable(what: str, where: str, remedy: str) -> str:
    """Say why something cannot be used. where, remedy: as of a HullreconError, may be empty."""
    place = f" ({where})" if where else ""
    return f"{what}{place}{f': {remedy}' if remedy else ''}"


def _needs_second_camera(camera: str, imu: bool, unread_dvls: Sequence[str]) -> str:
    dvl = "a DVL" if imu else "a DVL with an IMU"
    return f"missing: {camera} (a second camera), or {dvl}{_unread(unread_dvls)}"


def _needs_sensors(imu: bool, unread_dvls: Sequence[str]) -> str:
    dvl = "a DVL" if imu else "a DVL with an IMU"
    return f"missing: {dvl}, or two cameras{_unread(unread_dvls)}"


def _unread(topics: Sequence[str]) -> str:
    """Add that topics are of a DVL whose type is not read. "" without any."""
    if not topics:
        return ""
    shown = ", ".join(topics[:MOST_SHOWN]) + (", ..." if len(topics) > MOST_SHOWN else "")
    return (
        f"; {shown} is a DVL's but of a type that is not read: log one of those in "
        "docs/dive_package.md"
    )


def _no_velocity(pings: int, stereo: bool) -> str:
    """Say that a DVL has no velocity. stereo: there are two cameras, which can do without."""
    other = "give two cameras instead"
    if stereo:
        other = "leave the DVL away (topics.dvl, or its file in logs.files)"
    return f"the DVL's {pings} pings have no velocity over ground: log its bottom track, or {other}"


def _absent(sensor: str, dvl: bool, stereo: bool) -> str:
    """Say what the absence of a sensor means, with or without a DVL and two cameras."""
    imu = "there is no attitude: no run is possible"
    if dvl:
        imu = "the DVL's velocities have no heading: no run is possible"
        if stereo:
            imu += "; without the DVL it could take motion and attitude from stereo images"
    elif stereo:
        imu = "attitude comes from stereo images and drifts"
    consequences: Mapping[str, str] = {
        "dvl": "motion comes from stereo images"
        if stereo
        else "and no stereo images either: no motion, no run is possible",
        "imu": imu,
        "pressure": "depth comes from dead reckoning and drifts",
        "joints": "the tray is taken as fixed at 0 degrees",
        "camera_top": "there will be no images, landmarks or optical mosaic",
        "camera_bottom": "one camera: "
        + ("scale and depth come from the DVL" if dvl else "no scale without a DVL"),
        "sonar": "there will be no sonar mosaic",
        "hull": "without a CAD model the run maps onto its own surface, in the frame global",
    }
    return f"no {sensor}: {consequences[sensor]}"


def _open_key(key: str, default: object, log_first: bool) -> str:
    """Ask for a key that has a default. log_first: the log's tf_static comes before it."""
    until = "what the log's tf_static says, else " if log_first else ""
    return f"to fill in: {key}: {MEANING[key]}; until then {until}[{_numbers(default)}] is used"


def _open_calibration(key: str, camera: str) -> str:
    section = key.rpartition(".")[0]
    return (
        f"to fill in: {key}: the camera_info YAML of {camera}, or [{section}] alone where the log "
        "has its CameraInfo; until then its images are not used"
    )


def _not_chosen(topics: Mapping[str, Sequence[str]]) -> str:
    """Name topics that were not chosen, each with the sensors that it could be."""
    shown = ", ".join(f"{name} (could be {' or '.join(kinds)})" for name, kinds in topics.items())
    return f"not chosen, though of a type that is read: {shown}; name it in [topics] to use it"


def _mount(key: str, value: object, source: str) -> str:
    return f"{key} = [{_numbers(value)}] by {source}"


def _bow(axis: str, bow_m: float, given: bool, zero_m: float, ahead_m: float) -> str:
    """Say where the bow is taken to be, and where stations count from.

    axis: of the CAD model, along which bow_m and zero_m count: the bow, and station 0. given: by
    hull.bow. ahead_m: station 0 ahead of the hull's aft end.
    """
    why = "hull.bow" if given else f"where {axis} grows, as hull.bow is not given"
    counted = f"its {axis} = {_coordinate(zero_m)}{' m' if zero_m else ''}"
    return (
        f"bow: at {axis} = {bow_m:+.1f} m of the CAD model ({why}); stations count from {counted}, "
        f"{_from_aft_end(ahead_m)}"
    )


def _stations(axis: str, zero_m: float, ahead_m: float) -> str:
    """Doubt where stations count from, far from the aft end. Arguments as of `_bow`."""
    return (
        f"stations and frames count from {axis} = {_coordinate(zero_m)} m of the CAD model, "
        f"{_from_aft_end(ahead_m)}: if its bow is the other end, give hull.bow; if its aft "
        "perpendicular lies elsewhere, hull.aft_perpendicular"
    )


def _coordinate(value_m: float) -> str:
    """Format a coordinate. Those of a map, with more than five digits, are not rounded to six."""
    return f"{value_m:g}" if abs(value_m) < 1e5 else f"{value_m:.1f}"


def _from_aft_end(ahead_m: float) -> str:
    return f"{abs(ahead_m):.1f} m {'forward' if ahead_m >= 0 else 'aft'} of its aft end"


def _removed(count: int, kind: str) -> str:
    return f"{count} {kind} faces were removed" if count > 1 else f"1 {kind} face was removed"


def _span(limits_m: Sequence[float]) -> str:
    return f"{limits_m[0]:.1f} to {limits_m[1]:.1f} m"


def _empty_region(region: str, along_m: Sequence[float], girth_m: Sequence[float]) -> str:
    return (
        f"hull.region {region} holds no hull: the CAD model reaches from {_span(along_m)} along, "
        f"{_span(girth_m)} in girth"
    )


def _point(place: Sequence[float]) -> str:
    return "(" + ", ".join(f"{c:.2f}" for c in place) + ")"


def _mesh(file: str, faces: int, low_m: Sequence[float], high_m: Sequence[float]) -> str:
    size = " x ".join(f"{high - low:.2f}" for low, high in zip(low_m, high_m, strict=True))
    return f"{file}: {faces} faces, {size} m, from {_point(low_m)} to {_point(high_m)}"


def _unused(reason: str) -> str:
    """Make the template of a sentence on topics that a run would not use, for this reason."""
    return "a run would not use {topics}: " + reason


def _costs(
    seconds: float, memory_mb: float, step: str, disk_mb: float, steps: Sequence[object]
) -> str:
    """Say what a run costs. step: that which takes the most memory. steps: for the JSON alone."""
    return (
        f"a run takes about {_duration(seconds)} on two cores, {_amount(memory_mb)} of memory "
        f"({step}) and {_amount(disk_mb)} of disk"
    )


def _over_memory(step: str, needed_gb: float, allowed_gb: float, least_gb: float) -> str:
    """Say that a step needs too much memory. least_gb: what it needs for the shortest dive."""
    parts = ", or map a part of the dive (dive.from, dive.to)" if least_gb < allowed_gb else ""
    return (
        f"{step} needs about {needed_gb:.3g} GB of memory, and a run may take {allowed_gb:.3g} GB: "
        f"give it more with --memory{parts}"
    )


def _duration(seconds: float) -> str:
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


def _amount(megabytes: float) -> str:
    return f"{megabytes:.0f} MB" if megabytes < 950 else f"{megabytes / 1000:.1f} GB"


ERRORS: dict[str, Words] = {
    "memory-over-budget": _over_memory,
    "file-missing": "missing: {file} ({key})",
    "unusable": _unusable,
    "needs-attitude": "missing: an IMU with attitude, for the DVL's velocities",
    "needs-second-camera": _needs_second_camera,
    "needs-sensors": _needs_sensors,
    "dvl-without-velocity": _no_velocity,
    "stereo-rig": "{problem}",
    "hull-unmeasured": "nothing measures the hull: the DVL gives no ranges, and no image was "
    "logged; `hullrecon run --to navigate` gives the path alone",
    "images-not-named": "no image of camera.top was logged; beside the tables lie {what}: {remedy}",
    "images-not-logged": "no image of camera.top was logged: " + WITHOUT_CAMERAS,
}
WARNINGS: dict[str, Words] = {
    "memory-tight": _over_memory,
    "date-differs": "the log begins at {start}, dive.date is {date}: times of day in what is "
    "delivered are those of the log",
    "key-open": _open_key,
    "calibration-open": _open_calibration,
    "question": "to fill in: {question}",
    "mount-of-dvl-open": "to fill in: imu.mount_deg: roll, pitch, yaw in degrees of the frame dvl "
    "in the vehicle: the only attitude is that of the DVL's own sensors",
    "log-outside": "outside the package: {file}; put it there, or give --allow-outside to check "
    "and run",
    "calibration-in-water": "to see to: {file} is the log's CameraInfo; it has to be that of the "
    "camera in water",
    "stations-off": _stations,
    "hull-on-its-side": lambda port, pose: (
        "it is symmetric about a level plane and not from port to starboard, so hull.pose lays it "
        f"on its side: was it exported with {port} up? Then give hull.pose = [{_numbers(pose)}]"
    ),
    "hull-under-water": lambda top_m, bottom_m, up, pose: (
        f"hull.pose puts it wholly under the water, {top_m:.1f} to {bottom_m:.1f} m deep: does its "
        f"{up} point down? Then give hull.pose = [{_numbers(pose)}]. Else its origin is another "
        "point than that of hull.pose, or the depth of that is wrong, or its angles are in radians"
    ),
    "hull-out-of-reach": lambda far_m, way_m, seen_m, sigma_m: (
        f"hull.pose puts it {far_m:.0f} m from where the dive begins, at x = y = 0. By its "
        f"velocities the vehicle came at most {way_m:.0f} m far and saw {seen_m:.0f} m farther, "
        f"and hull.pose_sigma is {sigma_m:g} m: a run cannot find it there and leaves it out"
    ),
    "hull-length-differs": lambda length_m, stated_m: (
        f"it is {length_m:.2f} m long, {100 * abs(length_m / stated_m - 1):.1f} % "
        f"{'more' if length_m > stated_m else 'less'} than hull.length_overall: where that is no "
        "end left out but the scale, positions are off by as much of their distance from its origin"
    ),
    "region-empty": _empty_region,
    "regions-uncounted": lambda count, why: (
        f"{count_noun(count, 'hull.region')} cannot be counted: {why}"
    ),
    "earlier-dive-missing": "change.earlier names no folder: {folder}; the report will not say "
    "what changed",
}
NOTES: dict[str, Words] = {
    "run-costs": _costs,
    "sensor-absent": _absent,
    "mount-of-log": _mount,
    "bow": _bow,
    "region-area": "region {region}: {area_m2:.1f} m2 of the CAD model",
    # topics that no sensor was given
    "topics-not-chosen": _not_chosen,
    "topics-of-ranges": _unused(
        "ranges are taken along the beams of a DVL alone, a single beam has no mount of its own"
    ),
    "topics-of-echoes": _unused(
        "echoes of a sonar that turns beam by beam, which never saw a whole fan at one time; those "
        "of imaging sonars are read"
    ),
    "topics-of-clouds": _unused(
        "points of a 3-D sonar or another scanner, which no step takes; DVL and IMU, or cameras, "
        "measure the hull"
    ),
    "topics-of-depths": _unused(
        "a depth is read from sensor_msgs/FluidPressure, ds_sensor_msgs/DepthPressure or "
        "std_msgs/Float64: log one of these"
    ),
    "topics-of-positions": _unused(
        "positions from outside (GPS, USBL) of other types than are read"
    ),
    "topics-of-commands": _unused("by the name a command, no measurement"),
    "topics-of-other-types": _unused("of other types than it reads"),
    # the CAD model
    "mesh-read": _mesh,
    "mesh-faces-removed": _removed,
    "mesh-steps": "the CAD model's coordinates reach {farthest_m:.0f} m and are stored in steps of "
    "{step_m:.2g} m there",
    "mesh-faces-hidden": lambda hidden, count: (
        f"{hidden} of {count} faces were left out, as nothing outside sees them: inner sides of "
        "plates, tanks, structure"
    ),
    "mesh-faces-turned": "{turned} of {count} faces had their normals inward and were turned",
    "mesh-pieces-unclear": "{unclear} of {count} separate pieces have no clear outer side",
    "mesh-edges-twisted": lambda count: (
        f"{count_noun(count, 'edge')} cannot have a consistent winding on both sides"
    ),
    "mesh-open": lambda edges: f"the mesh is not watertight: {count_noun(edges, 'boundary edge')}",
    "mesh-bodies": lambda axis, gap_m, sizes_m: (
        f"the CAD model is of two bodies, {gap_m:.1f} m apart along {axis} (the one is "
        f"{sizes_m[0]:.1f} m long, the other {sizes_m[1]:.1f} m): is another ship, a quay or a "
        "dock in it? Stations, bow and regions are those of the whole"
    ),
    "mesh-cut": "the mesh ends open along a plane: what lies beyond, as a half hull's other half, "
    "is not added",
    "mesh-closed": "the mesh is watertight",
    "mesh-small": "the CAD model {file} is {length_m:.4g} m long when read in {units}; a ship hull "
    "has {shortest_m:.0f} to {longest_m:.0f} m: is it a model? hull.units says in which unit it is",
}
