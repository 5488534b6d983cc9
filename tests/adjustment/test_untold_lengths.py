# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace

import numpy as np
from adjustment.solved_dives import solved

from hullrecon.adjustment.bundle_adjustment import Adjusted
from hullrecon.adjustment.results.summary import summarise_adjustment
from hullrecon.adjustment.results.untold_lengths import only_dvl_tells_lengths


def with_depth_sigma(adjusted: Adjusted, sigma_m: float) -> Adjusted:
    attitude = adjusted.problem.attitude
    sigma = attitude.sigma.copy()
    sigma[:, 0] = sigma_m
    problem = replace(adjusted.problem, attitude=replace(attitude, sigma=sigma))
    return replace(adjusted, problem=problem)


def test_two_cameras_tell_lengths():
    assert not only_dvl_tells_lengths(with_depth_sigma(solved().adjusted, 1.0))


def test_a_good_depth_tells_lengths_where_the_vehicle_climbs():
    assert not only_dvl_tells_lengths(solved(stereo=False).adjusted)


def test_with_one_camera_and_a_poor_depth_the_dvl_alone_tells_lengths():
    found = solved(stereo=False)
    adjusted = with_depth_sigma(found.adjusted, 1.0)
    assert only_dvl_tells_lengths(adjusted)
    said = summarise_adjustment(found.dive.measured, adjusted, found.options).warnings
    (sentence,) = (line for line in said if "speed of sound" in line)
    assert "1 % (dvl.scale_sigma)" in sentence


def test_without_a_dvl_nothing_is_said_of_it():
    adjusted = with_depth_sigma(solved(stereo=False).adjusted, 1.0)
    odometry = adjusted.problem.odometry
    by_other = replace(odometry, by_navigation=np.zeros_like(odometry.by_navigation))
    assert not only_dvl_tells_lengths(
        replace(adjusted, problem=replace(adjusted.problem, odometry=by_other))
    )
