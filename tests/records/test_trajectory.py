# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.geometry.frames import Frame
from hullrecon.geometry.poses import Poses
from hullrecon.records.serialisation import from_arrays, to_arrays
from hullrecon.records.trajectory import (
    Odometry,
    Trajectory,
    TrajectoryErrorModel,
    VehiclePath,
    VehicleTrack,
)

N = 4
T = np.arange(N, dtype=np.int64) * 1_000_000_000


def poses() -> Poses:
    """Along x at 1 m/s, turning by 10 degrees a second about z."""
    turn = Rotation.from_euler("z", 10.0 * np.arange(N)[:, None], degrees=True)
    return Poses(turn.as_quat(), np.column_stack([np.arange(N), np.zeros(N), np.full(N, 2.0)]))


def covariance() -> np.ndarray:
    """Sigmas of 1 to 6 cm and mrad, correlated between x and y."""
    sigma = 0.01 * np.arange(1, 7)
    matrix = np.diag(sigma**2)
    matrix[0, 1] = matrix[1, 0] = 0.5 * sigma[0] * sigma[1]
    return np.tile(matrix, (N, 1, 1))


def track() -> VehicleTrack:
    return VehicleTrack(
        t_ns=T,
        poses=poses(),
        tray=0.1 * np.arange(N),
        covariance=covariance(),
        image=np.full((N, 2), -1),
        frame=Frame.HULL,
    )


def trajectory() -> Trajectory:
    p = poses()
    return Trajectory(
        t_ns=T,
        quaternion=p.quaternion,
        translation=p.translation,
        covariance=covariance(),
        tray=0.1 * np.arange(N),
        image=np.column_stack([np.arange(N), np.full(N, -1)]),
    )


@pytest.mark.parametrize(
    "rows", [slice(1, 3), np.array([1, 2]), np.array([False, True, True, False])]
)
def test_a_path_is_cut_by_slice_rows_or_mask(rows: slice | np.ndarray) -> None:
    path = VehiclePath(poses=poses(), tray=np.arange(float(N)))
    part = path[rows]
    assert (len(path), len(part)) == (N, 2)
    np.testing.assert_array_equal(part.tray, [1.0, 2.0])
    np.testing.assert_array_equal(part.poses.translation[:, 0], [1.0, 2.0])


def test_sigmas_are_the_roots_of_the_diagonal() -> None:
    np.testing.assert_allclose(track().sigma, np.tile(0.01 * np.arange(1, 7), (N, 1)))


def test_the_sigma_along_an_axis_is_that_of_the_axis() -> None:
    for axis in range(3):
        along = track().sigma_towards(np.tile(np.eye(3)[axis], (N, 1)))
        np.testing.assert_allclose(along, track().sigma[:, axis])


def test_the_sigma_between_axes_takes_their_correlation() -> None:
    """(x + y)/sqrt 2: half of 1 + 4 + 2 * 0.5 * 1 * 2 cm2 is 3.5 cm2; (x - y)/sqrt 2: 1.5 cm2."""
    diagonal = np.tile([1.0, 1.0, 0.0], (N, 1)) / np.sqrt(2)
    across = np.tile([1.0, -1.0, 0.0], (N, 1)) / np.sqrt(2)
    np.testing.assert_allclose(track().sigma_towards(diagonal), 0.01 * np.sqrt(3.5))
    np.testing.assert_allclose(track().sigma_towards(across), 0.01 * np.sqrt(1.5))


def test_the_vehicle_between_two_nodes_is_between_their_poses() -> None:
    between = track().vehicle_at(np.array([500_000_000, 2_250_000_000]))
    np.testing.assert_allclose(between.translation[:, 0], [0.5, 2.25])
    np.testing.assert_allclose(between.rotation.as_euler("ZYX", degrees=True)[:, 0], [5.0, 22.5])


def test_vehicle_is_held_before_first_and_after_last_node() -> None:
    held = track().vehicle_at(np.array([-5_000_000_000, 9_000_000_000]))
    np.testing.assert_allclose(held.translation[:, 0], [0.0, 3.0])


def test_the_path_of_a_track_has_its_poses_and_its_tray() -> None:
    path = track().path
    np.testing.assert_array_equal(path.tray, track().tray)
    np.testing.assert_array_equal(path.poses.translation, track().poses.translation)


def test_the_track_of_a_trajectory_is_in_the_global_frame() -> None:
    dead_reckoned = trajectory()
    found = dead_reckoned.track()
    assert found.frame is Frame.GLOBAL
    np.testing.assert_array_equal(found.poses.quaternion, dead_reckoned.quaternion)
    np.testing.assert_array_equal(found.image, dead_reckoned.image)
    np.testing.assert_array_equal(found.covariance, dead_reckoned.covariance)


def random_record(kind: type, shapes: dict[str, tuple[int, ...]]) -> object:
    rng = np.random.default_rng(3)
    return kind(**{name: rng.normal(size=shape) for name, shape in shapes.items()})


@pytest.mark.parametrize(
    "record",
    [
        trajectory(),
        random_record(
            TrajectoryErrorModel,
            {
                "by_error": (N, 6, 0),
                "error_covariance": (0, 0),
                "walk": (N, 6, 6),
                "white": (N, 6, 6),
            },
        ),
        random_record(
            Odometry,
            {
                "first": (3,),
                "second": (3,),
                "quaternion": (3, 4),
                "translation": (3, 3),
                "covariance": (3, 6, 6),
                "by_navigation": (3, 6, 2),
                "by_mount": (3, 6, 3),
                "by_tray": (3, 6),
                "from_images": (3,),
            },
        ),
    ],
    ids=lambda record: type(record).__name__,
)
def test_record_with_empty_axes_reads_back(record: object) -> None:
    again = from_arrays(type(record), to_arrays(record))
    for field in fields(record):  # type: ignore[arg-type]
        before, after = getattr(record, field.name), getattr(again, field.name)
        assert np.shape(after) == np.shape(before)
        np.testing.assert_array_equal(after, before)
