# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Every record that goes to disk, in the shapes that its comments give, of random values."""

from __future__ import annotations

import types
import typing
from collections.abc import Mapping
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.poses import Poses
from hullrecon.native import PlanePairTable, PlaneRangeTable, PlaneTable
from hullrecon.records.planes import TiedPlanes
from hullrecon.records.sensors import (
    DvlPings,
    ImageIndex,
    ImuSamples,
    JointSamples,
    PositionFixes,
    PressureSamples,
    SensorRecords,
    SonarPings,
)
from hullrecon.records.solution import DeviationField, HullPose, Landmarks, Mounts, Solution
from hullrecon.records.surface import DeviationSplit, Surface
from hullrecon.records.tracks import Tracks
from hullrecon.records.trajectory import (
    Attitude,
    Exposures,
    Odometry,
    PositionTies,
    Returns,
    Trajectory,
    TrajectoryErrorModel,
    VehiclePath,
)

Record = TypeVar("Record")

# Members by shape; a letter is a number of rows that several members share. Of a part: which
# letters it calls otherwise.
SHAPES: dict[type, dict[str, str | dict[str, str]]] = {
    Poses: {"quaternion": "p 4", "translation": "p 3"},
    DvlPings: {
        "t_ns": "n",
        "velocity": "n 3",
        "velocity_sigma": "n",
        "ranges": "n b",
        "beams": "b 3",
        "range_scale_sigma": "",
    },
    ImuSamples: {
        "t_ns": "n",
        "quaternion": "n 4",
        "angular_velocity": "n 3",
        "acceleration": "n 3",
    },
    PressureSamples: {"t_ns": "n", "depth": "n"},
    JointSamples: {"t_ns": "n", "angle": "n"},
    ImageIndex: {"t_ns": "n", "file": "n", "offset": "n", "size": "n", "usable": "n", "bits": ""},
    SonarPings: {"t_ns": "n", "image": "n b r", "directions": "b 3", "range_m": "r"},
    PositionFixes: {"t_ns": "n", "north_east": "n 2", "exchanged": "n 2", "sigma": "n"},
    SensorRecords: {
        "dvl": {},
        "imu": {},
        "pressure": {},
        "tray": {"n": "m"},
        "sonar_tray": {"n": "k"},
        "sonar": {},
        "position": {},
    },
    VehiclePath: {"poses": {"p": "n"}, "tray": "n"},
    Trajectory: {
        "t_ns": "n",
        "quaternion": "n 4",
        "translation": "n 3",
        "covariance": "n 6 6",
        "tray": "n",
        "image": "n 2",
        "exposures": {},
    },
    Exposures: {"late_s": "n 2", "twist": "n 6", "depth_m": "n", "readout_s": "2"},
    TrajectoryErrorModel: {
        "by_error": "n 6 k",
        "error_covariance": "k k",
        "walk": "n 6 6",
        "white": "n 6 6",
    },
    Odometry: {
        "first": "m",
        "second": "m",
        "quaternion": "m 4",
        "translation": "m 3",
        "covariance": "m 6 6",
        "by_navigation": "m 6 2",
        "by_mount": "m 6 3",
        "by_tray": "m 6",
        "from_images": "m",
    },
    Returns: {
        "t_ns": "m",
        "node": "m",
        "quaternion": "m 4",
        "translation": "m 3",
        "tray_offset": "m",
        "beam": "m 3",
        "range_m": "m",
        "flagged": "m",
        "scale_sigma": "",
    },
    PositionTies: {"t_ns": "m", "node": "m", "antenna": "m 3", "north_east": "m 2", "sigma": "m"},
    PlaneTable: {"anchor": "p"},
    PlaneRangeTable: {
        "node": "r",
        "plane": "r",
        "offset": "r 7",
        "tray_offset": "r",
        "beam": "r 3",
        "measured": "r",
        "sigma": "r",
    },
    PlanePairTable: {
        "first": "m",
        "second": "m",
        "measured": "m 3",
        "sqrt_information": "m 3 3",
        "point": "m 3",
        "place": "m 3",
        "by_place": "m 3 3",
    },
    TiedPlanes: {"plane": "p 3", "table": {}, "ranges": {}, "pairs": {}},
    Attitude: {
        "node": "m",
        "depth": "m",
        "roll": "m",
        "pitch": "m",
        "sigma": "m 3",
        "nodes_per_reading": "m",
        "tray_direction": "n",
        "tray_sigma": "n",
    },
    Tracks: {
        "landmark": "m",
        "node": "m",
        "top": "m 2",
        "bottom": "m 2",
        "response": "m",
        "color": "k 3",
    },
    Surface: {"vertices": "n 3", "faces": "m 3", "deviation": "n", "sigma": "n", "support": "n"},
    DeviationSplit: {
        "offset": "",
        "offset_sigma": "",
        "tilt": "2",
        "tilt_sigma": "2",
        "form": "n",
        "form_sigma": "n",
    },
    Landmarks: {
        "position": "m 3",
        "covariance": "m 3 3",
        "label": "m",
        "deviation": "m",
        "views": "m",
        "color": "m 3",
    },
    HullPose: {"global_from_hull": {"p": "1"}, "covariance": "6 6", "survey_center": "3"},
    Mounts: {
        "tray_from_dvl": {"p": "1"},
        "tray_from_top": {"p": "1"},
        "top_from_bottom": {"p": "1"},
    },
    DeviationField: {"origin": "2", "step": "2", "value": "b r", "sigma": "b r"},
    Solution: {
        "t_ns": "n",
        "image": "n 2",
        "global_from_vehicle": {"p": "n"},
        "tray": "n",
        "tray_sigma": "n",
        "pose_covariance": "n 6 6",
        "landmarks": {},
        "mounts": {},
        "navigation_errors": "6",
        "hull_pose": {},
        "deviation_field": {},
        "exposures": {},
    },
}


def random_record(kind: type[Record], rng: np.random.Generator, sizes: Mapping[str, int]) -> Record:
    """Return a record of that kind with so many rows for each letter; each part that may be missing
    is, half the time.
    """
    values: dict[str, object] = {}
    hints = typing.get_type_hints(kind)
    for name, shape in SHAPES[kind].items():
        if isinstance(shape, str):
            values[name] = _random_array(
                hints[name], rng, tuple(_size(letter, sizes) for letter in shape.split())
            )
            continue
        if isinstance(hints[name], types.UnionType) and rng.random() < 0.5:
            values[name] = None
            continue
        part = next(hint for hint in (hints[name], *typing.get_args(hints[name])) if hint in SHAPES)
        values[name] = random_record(
            part, rng, {**sizes, **{a: _size(b, sizes) for a, b in shape.items()}}
        )
    return kind(**values)


def _size(letter: str, sizes: Mapping[str, int]) -> int:
    return int(letter) if letter.isdigit() else sizes[letter]


def _random_array(
    hint: object, rng: np.random.Generator, shape: tuple[int, ...]
) -> NDArray[np.generic]:
    """Return an array of the type that the field is annotated with: times of today's size, and
    floats of which some are NaN.
    """
    scalar = typing.get_args(typing.get_args(hint)[1])[0]
    if scalar is np.str_:
        return np.array(
            rng.choice(["", "images/top_0001.png", "images/bild-ü.jpg"], shape), np.str_
        )
    if scalar is np.bool_:
        return rng.random(shape) < 0.5
    if issubclass(scalar, np.integer):
        limits = np.iinfo(scalar)
        return rng.integers(limits.min, limits.max, shape, dtype=scalar, endpoint=True)
    values = rng.normal(scale=1e3, size=shape)
    return np.where(rng.random(shape) < 0.1, np.nan, values).astype(scalar)
