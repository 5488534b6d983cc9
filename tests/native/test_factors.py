# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One value worked out by hand for each residual, through the tables, whitening included."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from drafts import Draft, evaluate
from scipy.stats import chi2, norm

from hullrecon.native import FACTORS, MotionPrior, Options

Empty = Callable[[int], Draft]
UP = np.array([0.0, 0, 0, 0, 0, 0, 1])


def residuals(p: Draft, factor: str, options: Options = Options()) -> np.ndarray:  # noqa: B008
    e = evaluate(p, options)
    return np.asarray(e.residual[e.factor == FACTORS.index(factor)])


def turned(axis: int, angle: float) -> np.ndarray:
    q = np.zeros(4)
    q[axis], q[3] = np.sin(angle / 2), np.cos(angle / 2)
    return q


def test_a_prior_reads_in_its_own_axes(empty: Empty) -> None:
    p = empty(1)
    p.unknowns.pose[0, :3] = [1.0, 2.0, 3.0]
    p.priors.pose.node, p.priors.pose.value = (
        np.zeros(1, np.int32),
        np.array([[1.0, 1.0, 3.0, *turned(2, np.pi / 2)]]),
    )
    p.priors.pose.sqrt_information = np.diag([2.0, 1, 1, 1, 1, 10])[None]
    # the pose lies 1 m along y of g, which is the turned prior's x; its heading is a quarter turn
    # less
    np.testing.assert_allclose(residuals(p, "prior"), [2, 0, 0, 0, 0, -5 * np.pi], atol=1e-12)


def test_depth_is_that_of_the_sensor_and_biases_add(empty: Empty) -> None:
    p = empty(1)
    p.unknowns.pose[0, 2], p.unknowns.pose[0, 3:7] = 2.0, turned(0, np.pi / 2)
    p.lever_arms.pressure, p.unknowns.navigation = (
        np.array([0, 0.5, 0.0]),
        np.array([0, 0, 0.01, 0.02, 0.03, 0]),
    )
    p.attitude.node, p.attitude.measured = np.zeros(1, np.int32), np.array([[2.0, 1.5, 0.0]])
    p.attitude.sigma = np.array([[0.1, 1.0, 0.01]])
    # rolled a quarter turn, y of the vehicle points down: the sensor is 0.5 m deeper
    np.testing.assert_allclose(
        residuals(p, "attitude"), [5.3, np.pi / 2 + 0.01 - 1.5, 2.0], atol=1e-12
    )


def test_the_trays_backlash_adds_along_the_direction_of_motion(empty: Empty) -> None:
    p = empty(2)
    p.unknowns.pose[:, 7], p.unknowns.navigation = 0.2, np.array([0, 0, 0, 0, 0, 0.01])
    p.tray.node, p.tray.measured = np.arange(2, dtype=np.int32), np.full(2, 0.15)
    p.tray.direction, p.tray.sigma = np.array([1.0, -1.0]), np.full(2, 0.02)
    np.testing.assert_allclose(residuals(p, "tray"), [3.0, 2.0])


def test_odometry_is_in_the_first_vehicle_less_systematic_part(
    empty: Empty,
) -> None:
    p = empty(2)
    p.unknowns.pose[:, 3:7] = turned(2, np.pi / 2)
    p.unknowns.pose[1, :3], p.unknowns.pose[1, 7] = [0, 1.0, 0], 0.2
    p.unknowns.navigation[0] = 0.1
    p.odometry.first, p.odometry.second = np.zeros(1, np.int32), np.ones(1, np.int32)
    p.odometry.measured, p.odometry.sqrt_information = (
        np.array([[0.7, 0, 0, *turned(2, 0.1)]]),
        np.eye(6)[None],
    )
    p.odometry.by_navigation, p.odometry.by_mount = np.zeros((1, 6, 2)), np.zeros((1, 6, 3))
    p.odometry.by_navigation[0, 0, 0] = 0.7  # a scale of 0.1 lengthens the measured 0.7 m by 0.07 m
    p.odometry.by_tray, p.odometry.tray = np.array([[0, 0, 2.0, 0, 0, 0]]), np.array([0.05])
    p.odometry.by_mount[0, 1, 2] = 3.0
    p.unknowns.T_s_d = np.array([0, 0, 0, *turned(2, 0.01)])
    # 1 m along g's y is 1 m ahead; e = (0.3, 0, 0, 0, 0, -0.1)
    np.testing.assert_allclose(
        residuals(p, "odometry"), [0.3 - 0.07, -0.03, -0.1, 0, 0, -0.1], atol=1e-12
    )


def cameras(p: Draft) -> None:
    p.unknowns.landmark = np.array([[0.2, 0.1, 2.0]])
    p.unknowns.T_ct_cb = np.array([0, 0.1, 0, 0, 0, 0, 1.0])
    p.unknowns.intrinsics_top = np.array([500.0, 400, 320, 240, 0.1, 0, 0, 0, 0])
    p.unknowns.intrinsics_bottom = np.array([500.0, 400, 320, 240, 0, 0, 0.01, 0, 0])
    p.sigma_px = 0.5


def test_stereo_pixels_are_those_of_the_distorted_pinhole(empty: Empty) -> None:
    p = empty(1)
    cameras(p)
    p.stereo.node = p.stereo.landmark = np.zeros(1, np.int32)
    p.stereo.pixel = np.array([[370.0, 260.0, 370.0, 240.0]])
    # top: (x, y) = (0.1, 0.05), r2 = 0.0125, radial 1.00125; bottom: (0.1, 0), r2 = 0.01,
    # tangential y: 0.01 r2 = 1e-4
    expected = np.array([500 * 0.1 * 0.00125, 400 * 0.05 * 0.00125, 0.0, 400 * 1e-4]) / 0.5
    np.testing.assert_allclose(residuals(p, "stereo"), expected, atol=1e-9)


def test_bottom_camera_pixels_are_shifted_by_the_baseline(empty: Empty) -> None:
    p = empty(1)
    cameras(p)
    p.mono.node = p.mono.landmark = np.zeros(2, np.int32)
    p.mono.camera, p.mono.pixel = (
        np.array([0, 1], np.int32),
        np.array([[370.0, 260.0], [370.0, 240.0]]),
    )
    expected = np.array([500 * 0.1 * 0.00125, 400 * 0.05 * 0.00125, 0.0, 400 * 1e-4]) / 0.5
    np.testing.assert_allclose(residuals(p, "mono"), expected, atol=1e-9)


def test_the_tray_tilts_the_camera_about_its_y_axis(empty: Empty) -> None:
    p = empty(1)
    cameras(p)
    p.unknowns.pose[0, 7], p.lever_arms.tray = np.pi / 2, np.array([0.5, 0, 0])
    # tilted up a quarter turn the camera looks along the vehicle's x
    p.unknowns.landmark = np.array([[2.5, 0.0, -0.4]])
    p.unknowns.intrinsics_top[4] = 0
    p.mono.node = p.mono.landmark = p.mono.camera = np.zeros(1, np.int32)
    p.mono.pixel = np.array([[320.0, 240.0]])
    # the camera's x points down to -z of v: 0.4 m over 2 m
    np.testing.assert_allclose(residuals(p, "mono"), np.array([500 * 0.2, 0]) / 0.5, atol=1e-9)


def floor(p: Draft) -> None:
    """z = 3 of M, its outward side up, towards the vehicle (z is down)."""
    p.cad_mesh.vertices = np.array([[-9.0, -9, 3], [9, -9, 3], [9, 9, 3], [-9, 9, 3]])
    p.cad_mesh.faces = np.array([[0, 2, 1], [0, 3, 2]], np.int32)


@pytest.mark.parametrize(("field", "shorter"), [(0.0, 0.0), (0.1, 0.2)])
def test_a_beam_is_shortened_by_the_field_over_the_cosine(
    field: float, shorter: float, empty: Empty
) -> None:
    p = empty(1)
    floor(p)
    p.unknowns.deviation = np.array([field])
    p.ranges.node, p.ranges.offset, p.ranges.tray_offset = (
        np.zeros(1, np.int32),
        np.array([[0, 0, 0.5, 0, 0, 0, 1]]),
        np.zeros(1),
    )
    # 60 degrees off the normal
    p.ranges.beam, p.ranges.sigma = np.array([[np.sqrt(0.75), 0, 0.5]]), np.array([0.1])
    p.ranges.measured = np.array([4.0])
    p.ranges.field.index, p.ranges.field.weight = np.zeros((1, 4), np.int32), np.full((1, 4), 0.25)
    np.testing.assert_allclose(residuals(p, "range"), [(2.5 / 0.5 - shorter - 4.0) / 0.1])


def test_surface_residual_is_distance_less_deviation_field(
    empty: Empty,
) -> None:
    p = empty(1)
    floor(p)
    p.unknowns.landmark, p.unknowns.T_g_M = (
        np.array([[1.0, 1.0, 2.9]]),
        np.array([0, 0, 0.05, 0, 0, 0, 1]),
    )
    p.unknowns.deviation, p.surface.landmark, p.surface.weight = (
        np.array([0.03, 9.0]),
        np.zeros(1, np.int32),
        np.array([0.25]),
    )
    p.surface.field.index, p.surface.field.weight = (
        np.zeros((1, 4), np.int32),
        np.full((1, 4), 0.25),
    )
    np.testing.assert_allclose(residuals(p, "surface"), [(0.15 - 0.03) / 0.02])


@pytest.mark.parametrize(("h", "label"), [(0.0559, 1), (0.0560, 0)])
def test_label_changes_at_56_mm_and_cost_is_the_winners(h: float, label: int, empty: Empty) -> None:
    p = empty(1)
    floor(p)
    p.unknowns.landmark, p.surface.landmark, p.surface.weight = (
        np.array([[0, 0, 3 - h]]),
        np.zeros(1, np.int32),
        np.array([0.25]),
    )
    e = evaluate(p)
    on, off = h**2 / (2 * 0.02**2), h**2 / 2 + np.log(1 / 0.02)
    assert e.cost_by_factor["surface"] == pytest.approx(0.25 * min(on, off))
    row = e.factor == FACTORS.index("surface")
    np.testing.assert_allclose(e.weight[row], [0.5 if label else 0.5 * 0.02])


def test_huber_acts_once_on_the_four_rows_of_a_pair(empty: Empty) -> None:
    p = empty(1)
    cameras(p)
    p.stereo.node = p.stereo.landmark = np.zeros(1, np.int32)
    p.unknowns.intrinsics_top[4] = p.unknowns.intrinsics_bottom[6] = 0
    p.stereo.pixel = np.array([[370.0 - 2, 260.0, 370.0, 240.0 - 2]])  # 4 sigma in two rows
    e = evaluate(p)
    length = np.sqrt(32)
    assert e.cost_by_factor["stereo"] == pytest.approx(2.508 * length - 0.5 * 2.508**2)
    np.testing.assert_allclose(
        e.weight[e.factor == FACTORS.index("stereo")] ** 2, np.full(4, 2.508 / length)
    )
    plain = evaluate(p, Options(huber_stereo=np.inf, huber_mono=np.inf))
    assert plain.cost_by_factor["stereo"] == pytest.approx(16.0)


def of_normal_noise(p: Draft, table: str, rows: int) -> None:
    """`rows` measurements of one point straight ahead, each with normal noise of one sigma."""
    rng, zeros = np.random.default_rng(2), np.zeros(rows, np.int32)
    floor(p)
    p.unknowns.landmark = np.array([[0.0, 0.0, 3.0]])
    p.unknowns.intrinsics_top = p.unknowns.intrinsics_bottom = np.array(
        [500.0, 500, 320, 240, 0, 0, 0, 0, 0]
    )
    p.sigma_px = 0.5
    if table == "stereo":
        p.stereo.node, p.stereo.landmark = zeros, zeros
        p.stereo.pixel = [320.0, 240, 320, 240] + 0.5 * rng.normal(size=(rows, 4))
    elif table == "mono":
        p.mono.node, p.mono.landmark, p.mono.camera = zeros, zeros, zeros
        p.mono.pixel = [320.0, 240] + 0.5 * rng.normal(size=(rows, 2))
    else:
        p.ranges.node, p.ranges.offset, p.ranges.tray_offset = (
            zeros,
            np.tile(UP, (rows, 1)),
            np.zeros(rows),
        )
        p.ranges.beam, p.ranges.sigma = np.tile([0.0, 0, 1], (rows, 1)), np.full(rows, 0.1)
        p.ranges.measured = 3 + 0.1 * rng.normal(size=rows)


@pytest.mark.parametrize(
    ("threshold", "rows"), [("huber_stereo", 4), ("huber_mono", 2), ("huber_range", 1)]
)
def test_huber_thresholds_are_chi_quantiles_of_their_rows(threshold: str, rows: int) -> None:
    assert chi2.sf(getattr(Options(), threshold) ** 2, rows) == pytest.approx(
        2 * norm.sf(1.345), abs=1e-3
    )


@pytest.mark.parametrize("table", ["stereo", "mono", "range"])
def test_share_beyond_hubers_threshold_is_equal_for_all_rows(table: str, empty: Empty) -> None:
    p = empty(1)
    of_normal_noise(p, table, 20000)
    e = evaluate(p)
    weight = e.weight[e.factor == FACTORS.index(table)]
    expected = 2 * norm.sf(1.345)
    # twenty thousand draws scatter the share by 0.0027
    assert np.mean(weight < 1) == pytest.approx(expected, abs=0.01)


def test_the_fields_prior_is_a_row_times_the_nodes(empty: Empty) -> None:
    p = empty(1)
    p.constant = tuple(name for name in p.constant if name != "deviation")
    p.unknowns.deviation = np.array([0.1, 0.2, 0.4])
    p.priors.deviation.start, p.priors.deviation.index = (
        np.array([0, 2, 5], np.int32),
        np.array([0, 2, 1, 1, 0], np.int32),
    )
    p.priors.deviation.value = np.array([10.0, -5, 1, 1, 3])
    np.testing.assert_allclose(residuals(p, "deviation"), [-1.0, 0.7])


def test_free_numbers_have_priors_about_zero_or_the_start(empty: Empty) -> None:
    p = empty(1)
    p.constant = ()
    p.unknowns.navigation, p.priors.navigation_sigma = np.arange(6.0), np.full(6, 2.0)
    p.priors.T_s_d = MotionPrior(
        value=np.array([0, 0, -1.0, 0, 0, 0, 1]), sqrt_information=3 * np.eye(6)
    )
    np.testing.assert_allclose(
        residuals(p, "prior"), [0, 0, 3, 0, 0, 0, *np.arange(6) / 2, *np.zeros(18)]
    )
    p.constant = ("navigation", "T_s_d", "intrinsics_top", "intrinsics_bottom")
    assert len(residuals(p, "prior")) == 0
