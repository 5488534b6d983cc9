# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Points of one image above water in another."""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.geometry.poses import exp
from hullrecon.studies.sessions.periscope import (
    CALIBRATION,
    HEIGHT,
    WALL_M,
    WIDTH,
    inside,
    transfer_of,
    transferred,
    unscented,
)

POSE = np.array([0.8, -0.1, 0.3, 0.02, -0.15, 0.03])
PLANE = np.array([0.6, 0.3, -WALL_M])
PIXEL = np.array([400.0, 300.0])


def test_a_point_of_the_wall_is_seen_where_it_is_transferred_to() -> None:
    found = transferred(np.r_[POSE, PLANE, PIXEL][None])[0]
    ray = np.linalg.inv(CALIBRATION) @ np.r_[PIXEL, 1.0]
    point = -(PLANE @ PLANE) / (ray @ PLANE) * ray
    assert abs(PLANE @ (point + PLANE)) < 1e-9
    there = CALIBRATION @ exp([POSE]).inverse().apply(point)[0]
    np.testing.assert_allclose(found, there[:2] / there[2], atol=1e-9)


def test_ellipses_hold_what_is_drawn() -> None:
    share, _, spread, _ = inside(transfer_of(np.array([700.0, 500.0])), np.random.default_rng(0))
    assert 0.98 < share < 0.996
    assert np.sqrt(spread[1, 1] / spread[0, 0]) < 0.3  # similar rows


def test_sigma_points_carry_a_linear_function_exactly() -> None:
    rng = np.random.default_rng(0)
    linear, root = rng.normal(size=(2, 4)), rng.normal(size=(4, 4))
    covariance = root @ root.T
    mean, spread = unscented(lambda x: x @ linear.T, np.arange(4.0), covariance)
    np.testing.assert_allclose(mean, linear @ np.arange(4.0))
    np.testing.assert_allclose(spread, linear @ covariance @ linear.T)


def test_the_middle_of_the_image_stays_when_nothing_moves() -> None:
    middle = np.array([WIDTH / 2, HEIGHT / 2])
    np.testing.assert_allclose(transferred(transfer_of(middle).mean[None])[0], middle)


def test_a_column_and_a_row_of_two_images_as_printed_lead_elsewhere() -> None:
    """[Ozog2016 D.3] prints <u_i, v_j>, the row of the image that is looked for."""
    found = transferred(np.r_[POSE, PLANE, PIXEL][None])[0]
    as_printed = transferred(np.r_[POSE, PLANE, PIXEL[0], found[1]][None])[0]
    assert np.abs(as_printed - found).max() > 10


def test_the_covariance_of_all_as_printed_is_none_of_a_pose() -> None:
    """[Ozog2016 D.3] prints Sigma_0 of pose, plane and pixel for the pose's alone, too."""
    transfer, rng = transfer_of(PIXEL), np.random.default_rng(0)
    pose, pose_alone = transfer.mean[:6], transfer.covariance[:6, :6]
    assert rng.multivariate_normal(pose, pose_alone).shape == (6,)
    with pytest.raises(ValueError, match="same length"):
        rng.multivariate_normal(pose, transfer.covariance)
