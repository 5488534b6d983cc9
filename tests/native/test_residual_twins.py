# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Every residual of a whole survey, shaken, against a twin that multiplies frames out in NumPy."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
import pytest
from drafts import Draft, evaluate
from native.test_cores import field, free, mono_beside_stereo
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import Poses, tray_poses
from hullrecon.native import FACTORS, MeshIndex, Options

Survey = Callable[..., Draft]
NAIVE = Options(method="naive")


def poses_of(seven: np.ndarray) -> Poses:
    rows = np.atleast_2d(seven)
    return Poses(rows[:, 3:7], rows[:, :3])


def got(p: Draft, table: str, options: Options = NAIVE) -> np.ndarray:
    e = evaluate(p, options)
    return np.asarray(e.residual[e.factor == FACTORS.index(table)])


@pytest.fixture
def dive(make_survey: Survey, shaken: Survey) -> Draft:
    """Everything free and off its place, biases and field not zero."""
    p = shaken(make_survey(pixel_noise=0.5))
    free(
        "T_g_M",
        "T_s_ct",
        "T_ct_cb",
        "T_s_d",
        "navigation",
        "deviation",
        "intrinsics_top",
        "intrinsics_bottom",
    )(p)
    field(p)
    mono_beside_stereo(p)
    rng = np.random.default_rng(8)
    p.unknowns.navigation = 0.02 * rng.normal(size=6)
    for name in ("T_s_ct", "T_ct_cb", "T_s_d"):
        moved = getattr(p.unknowns, name).copy()
        moved[:3] += 0.01 * rng.normal(size=3)
        moved[3:] = (
            Rotation.from_quat(moved[3:]) * Rotation.from_rotvec(0.01 * rng.normal(size=3))
        ).as_quat()
        setattr(p.unknowns, name, moved)
    return p


def motion_prior(x: np.ndarray, prior: np.ndarray, root: np.ndarray) -> np.ndarray:
    gap = poses_of(prior).inverse() @ poses_of(x)
    return np.asarray(root @ np.r_[gap.translation[0], gap.rotation.as_rotvec()[0]])


def test_priors(dive: Draft) -> None:
    p = dive
    p.priors.pose.node, p.priors.pose.value = (
        np.array([0, 3], np.int32),
        p.unknowns.pose[[1, 2], :7].copy(),
    )
    p.priors.pose.sqrt_information = np.random.default_rng(0).normal(size=(2, 6, 6))
    expected = [
        motion_prior(p.unknowns.pose[n], z, w)
        for n, z, w in zip(
            p.priors.pose.node, p.priors.pose.value, p.priors.pose.sqrt_information, strict=True
        )
    ]
    for name in ("T_g_M", "T_s_ct", "T_ct_cb", "T_s_d"):
        prior = getattr(p.priors, name)
        expected.append(
            motion_prior(getattr(p.unknowns, name), prior.value, prior.sqrt_information)
        )
    expected.append(p.unknowns.navigation / p.priors.navigation_sigma)
    expected.append(np.zeros(18))  # intrinsics, about their start
    np.testing.assert_allclose(got(p, "prior"), np.concatenate(expected), atol=1e-10)


def test_depths_rolls_and_pitches(dive: Draft) -> None:
    p = dive
    at = poses_of(p.unknowns.pose)
    rpy = at.rotation.as_euler("xyz")
    predicted = np.c_[
        at.apply(p.lever_arms.pressure)[:, 2] + p.unknowns.navigation[4],
        rpy[:, 0] + p.unknowns.navigation[2],
        rpy[:, 1] + p.unknowns.navigation[3],
    ]
    np.testing.assert_allclose(
        got(p, "attitude").reshape(-1, 3),
        (predicted - p.attitude.measured) / p.attitude.sigma,
        atol=1e-10,
    )


def test_tray_angles(dive: Draft) -> None:
    p = dive
    predicted = p.unknowns.pose[p.tray.node, 7] + p.unknowns.navigation[5] * p.tray.direction
    np.testing.assert_allclose(
        got(p, "tray"), (predicted - p.tray.measured) / p.tray.sigma, atol=1e-12
    )


def test_odometry(dive: Draft) -> None:
    p = dive
    at, z = poses_of(p.unknowns.pose), poses_of(p.odometry.measured)
    step = at[p.odometry.first].inverse() @ at[p.odometry.second]
    e = np.c_[step.translation - z.translation, (z.rotation.inv() * step.rotation).as_rotvec()]
    tilt = (
        Rotation.from_quat(p.odometry.mount[3:]).inv() * Rotation.from_quat(p.unknowns.T_s_d[3:])
    ).as_rotvec()
    angle = (
        0.5 * (p.unknowns.pose[p.odometry.first, 7] + p.unknowns.pose[p.odometry.second, 7])
        - p.odometry.tray
    )
    e -= (
        p.odometry.by_navigation @ p.unknowns.navigation[:2]
        + p.odometry.by_mount @ tilt
        + p.odometry.by_tray * angle[:, None]
    )
    expected = np.einsum("kij,kj->ki", p.odometry.sqrt_information, e)
    np.testing.assert_allclose(got(p, "odometry").reshape(-1, 6), expected, atol=1e-9)


def pixels(intrinsics: np.ndarray, points: np.ndarray) -> np.ndarray:
    fx, fy, cx, cy, k1, k2, p1, p2, k3 = intrinsics
    x, y = points[:, 0] / points[:, 2], points[:, 1] / points[:, 2]
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    u = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    v = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    return np.c_[fx * u + cx, fy * v + cy]


def in_cameras(p: Draft, node: np.ndarray, landmark: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    at = poses_of(p.unknowns.pose)[node] @ tray_poses(p.lever_arms.tray, p.unknowns.pose[node, 7])
    top = (at @ poses_of(p.unknowns.T_s_ct)).inverse().apply(p.unknowns.landmark[landmark])
    return top, poses_of(p.unknowns.T_ct_cb).inverse().apply(top)


def test_stereo_pairs(dive: Draft) -> None:
    p = dive
    p.sigma_px = 0.7
    top, bottom = in_cameras(p, p.stereo.node, p.stereo.landmark)
    predicted = np.hstack(
        [pixels(p.unknowns.intrinsics_top, top), pixels(p.unknowns.intrinsics_bottom, bottom)]
    )
    np.testing.assert_allclose(
        got(p, "stereo").reshape(-1, 4),
        (predicted - p.stereo.pixel) / (0.7 * p.stereo.sigma_ratio[:, None]),
        atol=1e-8,
    )


def test_rows_without_a_ratio_have_the_common_sigma(dive: Draft) -> None:
    p = dive
    own = {name: got(p, name).reshape(-1, rows) for name, rows in (("stereo", 4), ("mono", 2))}
    for table, name in ((p.stereo, "stereo"), (p.mono, "mono")):
        ratio, table.sigma_ratio = table.sigma_ratio, np.zeros(0)
        np.testing.assert_allclose(
            got(p, name).reshape(own[name].shape), own[name] * ratio[:, None], rtol=1e-12
        )


def test_single_images(dive: Draft) -> None:
    p = dive
    top, bottom = in_cameras(p, p.mono.node, p.mono.landmark)
    of_bottom = p.mono.camera[:, None] == 1
    predicted = np.where(
        of_bottom,
        pixels(p.unknowns.intrinsics_bottom, bottom),
        pixels(p.unknowns.intrinsics_top, top),
    )
    np.testing.assert_allclose(
        got(p, "mono").reshape(-1, 2),
        (predicted - p.mono.pixel) / p.mono.sigma_ratio[:, None],
        atol=1e-8,
    )


def field_value(p: Draft, table: str) -> np.ndarray:
    index, weight = getattr(p, table).field.index, getattr(p, table).field.weight
    return np.asarray((p.unknowns.deviation[index] * weight).sum(axis=1))


def test_ranges(dive: Draft) -> None:
    p = dive
    n = p.ranges.node
    instrument = (
        poses_of(p.unknowns.T_g_M).inverse()
        @ poses_of(p.unknowns.pose)[n]
        @ poses_of(p.ranges.offset)
        @ tray_poses(p.lever_arms.tray, p.unknowns.pose[n, 7] + p.ranges.tray_offset)
        @ poses_of(p.unknowns.T_s_d)
    )
    along = instrument.rotation.apply(p.ranges.beam)
    hit = MeshIndex(p.cad_mesh.vertices, p.cad_mesh.faces).cast(instrument.translation, along)
    assert np.isfinite(hit.range).all()
    predicted = hit.range + field_value(p, "ranges") / (hit.normal * along).sum(axis=1)
    np.testing.assert_allclose(
        got(p, "range"), (predicted - p.ranges.measured) / p.ranges.sigma, atol=1e-8
    )


@pytest.mark.parametrize("sigma_on", [0.02, 0.005])
def test_distances_to_the_hull(sigma_on: float, dive: Draft) -> None:
    p = dive
    in_hull = poses_of(p.unknowns.T_g_M).inverse().apply(p.unknowns.landmark[p.surface.landmark])
    expected = (
        MeshIndex(p.cad_mesh.vertices, p.cad_mesh.faces).closest(in_hull).distance
        - field_value(p, "surface")
    ) / sigma_on
    np.testing.assert_allclose(got(p, "surface", Options(sigma_on=sigma_on)), expected, atol=1e-9)


def test_the_fields_prior(dive: Draft) -> None:
    p = dive
    start = p.priors.deviation.start
    expected = [
        p.priors.deviation.value[a:b] @ p.unknowns.deviation[p.priors.deviation.index[a:b]]
        for a, b in itertools.pairwise(start)
    ]
    np.testing.assert_allclose(got(p, "deviation"), expected, atol=1e-12)


def huber(s: np.ndarray, threshold: float) -> np.ndarray:
    if not np.isfinite(threshold):
        return s
    root = np.sqrt(s)
    return np.where(root <= threshold, s, 2 * threshold * root - threshold**2)


@pytest.mark.parametrize("threshold", [0.5, 1.345, 2.508, np.inf])
@pytest.mark.parametrize(
    ("table", "rows", "option"),
    [("stereo", 4, "huber_stereo"), ("mono", 2, "huber_mono"), ("range", 1, "huber_range")],
)
def test_hubers_cost_and_weight_by_the_norm_of_a_factors_rows(
    table: str, rows: int, option: str, threshold: float, dive: Draft
) -> None:
    e = evaluate(dive, Options(method="naive", **{option: threshold}))
    mine = e.factor == FACTORS.index(table)
    s = (e.residual[mine].reshape(-1, rows) ** 2).sum(axis=1)
    assert e.cost_by_factor[table] == pytest.approx(0.5 * huber(s, threshold).sum(), rel=1e-12)
    expected = np.minimum(1, threshold / np.sqrt(s)) if np.isfinite(threshold) else np.ones(len(s))
    np.testing.assert_allclose(e.weight[mine] ** 2, np.repeat(expected, rows), rtol=1e-12)


@pytest.mark.parametrize(("sigma_on", "sigma_off"), [(0.02, 1.0), (0.01, 0.3), (0.05, 0.06)])
@pytest.mark.parametrize("method", ["geva", "maxmix"])
def test_mixture_cost_is_the_likelier_labels_times_the_weight(
    method: str, sigma_on: float, sigma_off: float, dive: Draft
) -> None:
    p = dive
    p.unknowns.landmark[:20, 2] -= 0.1
    p.surface.weight = np.random.default_rng(4).uniform(0.01, 1, len(p.surface.weight))
    e = evaluate(p, Options(method=method, sigma_on=sigma_on, sigma_off=sigma_off))
    mine = e.factor == FACTORS.index("surface")
    h = e.residual[mine] * sigma_on
    on = (h / sigma_on) ** 2
    off = (h / sigma_off) ** 2 + 2 * np.log(sigma_off / sigma_on)
    label = (on <= off) | (method == "geva")
    assert label.any()
    cost = np.where(label, on, off)
    assert e.cost_by_factor["surface"] == pytest.approx(
        0.5 * (p.surface.weight * cost).sum(), rel=1e-12
    )
    slope = np.where(label, 1.0, (sigma_on / sigma_off) ** 2)
    np.testing.assert_allclose(e.weight[mine] ** 2, p.surface.weight * slope, rtol=1e-12)


def test_rows_of_a_table_stand_in_its_order(dive: Draft) -> None:
    e = evaluate(dive, NAIVE)
    for table, node, rows in (("stereo", "node", 4), ("mono", "node", 2), ("odometry", "first", 6)):
        mine = e.factor == FACTORS.index(table)
        np.testing.assert_array_equal(
            e.table_row[mine], np.repeat(np.arange(len(getattr(getattr(dive, table), node))), rows)
        )
    assert (np.diff(e.factor) >= 0).all()
