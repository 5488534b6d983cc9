# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from drafts import Draft, change, clear, covariance, evaluate, solve
from scipy.sparse import csr_matrix
from scipy.spatial.transform import Rotation

from hullrecon.errors import StageError
from hullrecon.native import FACTORS, Evaluation, MotionPrior, Options

Survey = Callable[..., Draft]


def jacobian(e: Evaluation) -> np.ndarray:
    matrix = csr_matrix(
        (e.jacobian_value, e.jacobian_column, e.jacobian_start), shape=(len(e.residual), e.width)
    )
    return np.asarray(matrix.toarray())


def dense_covariance(p: Draft, options: Options) -> tuple[np.ndarray, dict[str, tuple[int, int]]]:
    """The twin: the whole information, inverted."""
    e = evaluate(p, options)
    rows = jacobian(e) * e.weight[:, None]
    scale = 1 / np.linalg.norm(rows, axis=0)
    rows = rows * scale
    return np.linalg.inv(rows.T @ rows) * np.outer(scale, scale), e.columns


def everything_free(p: Draft) -> Draft:
    p.constant = ()
    p.priors.T_ct_cb = MotionPrior(
        value=p.unknowns.T_ct_cb.copy(), sqrt_information=np.eye(6) / 1e-3
    )
    p.priors.T_s_d = MotionPrior(value=p.unknowns.T_s_d.copy(), sqrt_information=np.eye(6) / 1e-2)
    p.priors.navigation_sigma = np.full(6, 0.01)
    p.unknowns.deviation = np.array([0.001, -0.002, 0.003])
    rows = len(p.surface.landmark)
    p.surface.field.index = np.tile(np.array([0, 1, 2, 2], np.int32), (rows, 1))
    p.surface.field.weight = np.random.default_rng(3).uniform(size=(rows, 4))
    p.priors.deviation.start, p.priors.deviation.index = (
        np.arange(4, dtype=np.int32),
        np.arange(3, dtype=np.int32),
    )
    p.priors.deviation.value = np.full(3, 1 / 0.02)
    return p


def assert_equal(got: np.ndarray, expected: np.ndarray) -> None:
    np.testing.assert_allclose(got, expected, rtol=1e-6, atol=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize("method", ["naive", "maxmix"])
@pytest.mark.parametrize("threads", [1, 2])
def test_every_block_equals_that_of_the_dense_inverse(
    method: str, threads: int, make_survey: Survey
) -> None:
    p = everything_free(make_survey(pixel_noise=1.0))
    p.unknowns.landmark[:5, 2] -= 0.1  # labelled 0
    options = Options(method=method, threads=threads)
    dense, columns = dense_covariance(p, options)
    got = covariance(p, options)

    def block(a: str, b: str) -> np.ndarray:
        (i, n), (j, m) = columns[a], columns[b]
        return np.asarray(dense[i : i + n, j : j + m])

    for k in range(8):
        assert_equal(got.pose[k], block(f"pose {k}", f"pose {k}"))
        assert_equal(got.pose_T_g_M[k], block(f"pose {k}", "T_g_M"))
    for k in range(60):
        assert_equal(got.landmark[k], block(f"landmark {k}", f"landmark {k}"))
        assert_equal(got.landmark_T_g_M[k], block(f"landmark {k}", "T_g_M"))
    for name in (
        "T_g_M",
        "T_s_ct",
        "T_ct_cb",
        "T_s_d",
        "navigation",
        "intrinsics_top",
        "intrinsics_bottom",
    ):
        assert_equal(getattr(got, name), block(name, name))
    for k in range(3):
        assert_equal(got.deviation[k : k + 1, None], block(f"deviation {k}", f"deviation {k}"))
        assert_equal(got.deviation_T_g_M[k : k + 1], block(f"deviation {k}", "T_g_M"))


@pytest.mark.parametrize("method", ["naive", "maxmix"])
def test_leverage_of_factors_equals_that_of_the_dense_inverse(
    method: str, make_survey: Survey
) -> None:
    p, options = everything_free(make_survey(pixel_noise=1.0)), Options(method=method)
    dense, _ = dense_covariance(p, options)
    e = evaluate(p, options)
    rows = jacobian(e) * e.weight[:, None]
    by_row = np.einsum("ri,ij,rj->r", rows, dense, rows)
    got = covariance(p, options).leverage_by_factor
    assert set(got) == set(FACTORS)
    for kind in ("prior", "attitude", "tray", "odometry", "range", "deviation"):
        assert (
            0 < got[kind] == pytest.approx(by_row[e.factor == FACTORS.index(kind)].sum(), rel=1e-6)
        ), kind
    assert got["stereo"] == got["mono"] == got["surface"] == 0


def test_held_blocks_have_no_variance_the_rest_the_dense_one(
    make_survey: Survey,
) -> None:
    p = make_survey()
    p.constant = (*p.constant, "tray", "T_g_M")
    dense, columns = dense_covariance(p, Options())
    got = covariance(p)
    assert (got.T_g_M == 0).all()
    assert (got.pose_T_g_M == 0).all()
    assert (got.landmark_T_g_M == 0).all()
    assert (got.pose[:, 6] == 0).all()
    start, width = columns["pose 3"]
    assert width == 6
    assert_equal(got.pose[3, :6, :6], dense[start : start + 6, start : start + 6])


def test_marginals_are_symmetric_and_positive(make_survey: Survey) -> None:
    got = covariance(make_survey(poses=20, landmarks=300))
    for blocks in (got.pose, got.landmark, got.T_g_M[None]):
        np.testing.assert_allclose(blocks, blocks.transpose(0, 2, 1), rtol=1e-9, atol=1e-18)
        assert (np.linalg.eigvalsh(blocks) > 0).all()


def spread(seven: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """x [+] noise in the axes of x: a draw of a prior's or of odometry's mean."""
    at = Rotation.from_quat(seven[..., 3:7])
    turned = (at * Rotation.from_rotvec(noise[..., 3:])).as_quat()
    return np.concatenate([seven[..., :3] + at.apply(noise[..., :3]), turned], axis=-1)


def measured_again(p: Draft, rng: np.random.Generator) -> Draft:
    """Every measurement and every prior with a draw of its own noise."""
    p.priors.T_g_M.sqrt_information = np.eye(6) / 0.01
    for name, sigma in (("T_g_M", 0.01), ("T_s_ct", 0.02)):
        change(
            p.priors, f"{name}.value", spread(getattr(p.unknowns, name), sigma * rng.normal(size=6))
        )
    p.priors.pose.value = spread(p.priors.pose.value, 1e-3 * rng.normal(size=(1, 6)))
    p.attitude.measured += p.attitude.sigma * rng.normal(size=p.attitude.measured.shape)
    p.tray.measured += p.tray.sigma * rng.normal(size=len(p.tray.measured))
    p.ranges.measured += p.ranges.sigma * rng.normal(size=len(p.ranges.measured))
    p.stereo.pixel += rng.normal(size=p.stereo.pixel.shape)
    p.odometry.measured[:, :3] += 0.01 * rng.normal(size=(7, 3))
    turned = Rotation.from_quat(p.odometry.measured[:, 3:]) * Rotation.from_rotvec(
        0.001 * rng.normal(size=(7, 3))
    )
    p.odometry.measured[:, 3:] = turned.as_quat()
    return p


PLAIN = Options(
    method="naive",
    huber_stereo=np.inf,
    huber_mono=np.inf,
    huber_range=np.inf,
    function_tolerance=1e-9,
)
ROBUST = Options(method="naive", function_tolerance=1e-9)


def test_errors_of_noisy_dives_are_as_the_covariance_says(make_survey: Survey) -> None:
    truth, landmark, hull = make_survey(), [], []
    for seed in range(20):
        p = measured_again(make_survey(), np.random.default_rng(seed))
        p.unknowns = solve(p, PLAIN).unknowns
        sigma, error = covariance(p, PLAIN), p.unknowns.landmark - truth.unknowns.landmark
        landmark.append(
            np.einsum("ki,kij,kj->k", error, np.linalg.inv(sigma.landmark), error).mean()
        )
        moved = p.unknowns.T_g_M[:3] - truth.unknowns.T_g_M[:3]
        hull.append(moved @ np.linalg.inv(sigma.T_g_M[:3, :3]) @ moved)
    # of three degrees of freedom each; twenty dives scatter the mean by 0.2
    assert 2.6 < np.mean(landmark) < 3.4
    assert 1.6 < np.mean(hull) < 4.6


def images_at_known_poses(p: Draft, mono: bool) -> Draft:
    """Leaves the cameras' noise as the one cause of the landmarks' errors."""
    p.constant = (*p.constant, "T_s_ct", "tray")
    n = len(p.unknowns.pose)
    p.priors.pose.node, p.priors.pose.value, p.priors.pose.sqrt_information = (
        np.arange(n),
        p.unknowns.pose[:, :7].copy(),
        np.tile(np.eye(6) * 1e6, (n, 1, 1)),
    )
    if mono:
        rows = len(p.stereo.node)
        p.mono.node, p.mono.landmark = np.tile(p.stereo.node, 2), np.tile(p.stereo.landmark, 2)
        p.mono.camera, p.mono.pixel = (
            np.repeat([0, 1], rows),
            np.vstack([p.stereo.pixel[:, :2], p.stereo.pixel[:, 2:]]),
        )
        clear(p, "stereo")
    return p


@pytest.mark.parametrize("mono", [False, True], ids=["stereo", "mono"])
def test_hubers_loss_widens_sigmas_by_less_than_3_percent(mono: bool, make_survey: Survey) -> None:
    p = images_at_known_poses(make_survey(poses=20, landmarks=300, pixel_noise=1.0), mono)
    robust, plain = (
        np.sqrt(np.trace(covariance(p, o).landmark, axis1=1, axis2=2)) for o in (ROBUST, PLAIN)
    )
    assert 1.005 < np.median(robust / plain) < 1.03


@pytest.mark.parametrize("mono", [False, True], ids=["stereo", "mono"])
def test_landmark_errors_under_huber_are_as_the_covariance_says(
    mono: bool, make_survey: Survey
) -> None:
    p = images_at_known_poses(make_survey(poses=20, landmarks=2000, pixel_noise=1.0), mono)
    truth = p.unknowns.landmark
    p.unknowns.landmark = solve(p, ROBUST).unknowns.landmark
    error, sigma = p.unknowns.landmark - truth, covariance(p, ROBUST).landmark
    squared = np.einsum("ki,kij,kj->k", error, np.linalg.inv(sigma), error)
    # two thousand landmarks scatter the mean by 0.055
    assert np.mean(squared) == pytest.approx(3, abs=0.25)


def test_a_hull_that_nothing_ties_is_named(make_survey: Survey) -> None:
    p = make_survey()
    clear(p, "ranges")
    p.priors.T_g_M = None
    with pytest.raises(StageError, match="T_g_M x"):
        covariance(p, Options(method="naive"))


def test_a_dive_that_floats_in_the_plane_is_named(make_survey: Survey) -> None:
    p = make_survey()
    p.priors.T_g_M = None
    p.priors.pose.node, p.priors.pose.value, p.priors.pose.sqrt_information = (
        p.priors.pose.node[:0],
        p.priors.pose.value[:0],
        p.priors.pose.sqrt_information[:0],
    )
    with pytest.raises(StageError, match=r"undetermined.*(pose|T_g_M)"):
        covariance(p)


def test_a_landmark_without_views_is_named(make_survey: Survey) -> None:
    p = make_survey()
    p.unknowns.landmark = np.vstack([p.unknowns.landmark, [[0.0, 0, 0]]])
    with pytest.raises(StageError, match="landmark 60"):
        covariance(p)


def test_landmark_in_one_mono_image_is_named_with_its_ray(
    make_survey: Survey,
) -> None:
    p = make_survey()
    p.unknowns.landmark = np.vstack([p.unknowns.landmark, p.unknowns.landmark[:1]])
    p.mono.node, p.mono.landmark = np.zeros(1, np.int32), np.full(1, 60, np.int32)
    p.mono.camera, p.mono.pixel = np.zeros(1, np.int32), np.array([[320.0, 240.0]])
    with pytest.raises(StageError, match="landmark 60") as caught:
        covariance(p)
    assert "along" in caught.value.what


def test_jacobian_rows_and_columns_follow_the_layout(make_survey: Survey) -> None:
    p = make_survey()
    e = evaluate(p)
    full = jacobian(e)
    assert e.columns["pose 0"] == (0, 7)
    assert e.columns["landmark 0"] == (7 * 8, 3)
    assert e.columns["T_g_M"] == (7 * 8 + 3 * 60, 6)
    assert e.columns["T_s_ct"] == (7 * 8 + 3 * 60 + 6, 6)
    assert e.width == 7 * 8 + 3 * 60 + 12
    assert "navigation" not in e.columns
    row = np.flatnonzero((e.factor == FACTORS.index("stereo")) & (e.table_row == 10))[0]
    touched = np.zeros(e.width, bool)
    for name in (f"pose {p.stereo.node[10]}", f"landmark {p.stereo.landmark[10]}", "T_s_ct"):
        start, width = e.columns[name]
        touched[start : start + width] = True
    assert (full[row][touched] != 0).sum() >= 14
    assert (full[row][~touched] == 0).all()


def test_evaluating_on_two_threads_gives_the_same_bytes(make_survey: Survey) -> None:
    p = make_survey(poses=30, landmarks=400)
    one, two = evaluate(p, Options(threads=1)), evaluate(p, Options(threads=2))
    assert one.jacobian_value.tobytes() == two.jacobian_value.tobytes()
    assert one.residual.tobytes() == two.residual.tobytes()
    assert one.cost_by_factor == two.cost_by_factor
