# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Links between cameras: values by hand, against a twin in NumPy, what they are blind to, truth
from noisy ones.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from drafts import Draft, clear, evaluate, solve
from native.test_cores import camera_poses, links
from native.test_factors import residuals, turned
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import Poses, exp
from hullrecon.native import LinkKernel, MotionPrior, Options, Problem, Unknowns, bearing_basis

Empty = Callable[[int], Draft]
Survey = Callable[..., Draft]


def one_link(
    p: Draft, measured: np.ndarray, *, scaled: bool, kernel: LinkKernel = LinkKernel.NONE
) -> None:
    """Between the top cameras of the first two nodes, sigmas of one."""
    p.links.first, p.links.second = np.zeros(1, np.int32), np.ones(1, np.int32)
    p.links.camera_first = p.links.camera_second = np.zeros(1, np.int32)
    p.links.measured, p.links.sqrt_information = measured[None], np.eye(6)[None]
    p.links.scaled, p.links.kernel = np.array([scaled]), np.array([kernel], np.int32)
    p.unknowns.link_switch = np.ones(int(kernel == LinkKernel.SWITCH))


def test_scaled_link_is_read_in_the_axes_of_its_first_camera(empty: Empty) -> None:
    p = empty(2)
    p.unknowns.pose[:, 3:7] = turned(2, np.pi / 2)
    p.unknowns.pose[1, :3] = [0, 2.0, 0]
    # the cameras stand upright in g, 1 m above the nodes
    p.unknowns.T_s_ct = np.array([0, 0, 1.0, *turned(2, -np.pi / 2)])
    # the second tray turns about y of the vehicle, -x of g: its camera is at -y and ahead
    p.unknowns.pose[1, 7] = np.pi / 2
    one_link(p, np.array([0.1, 0.5, -0.5, *turned(0, -0.2)]), scaled=True)
    p.links.sqrt_information = np.diag([1, 2, 1, 1, 1, 1.0])[None]
    # T_g_c1 = (0, 0, 1); the second: z of the tray is x of the vehicle, y of g, so its camera is 1
    # m beyond: (0, 3, 0)
    np.testing.assert_allclose(
        residuals(p, "link"), [-0.1, 5.0, -0.5, -np.pi / 2 + 0.2, 0, 0], atol=1e-12
    )


def test_bearing_residual_is_the_angle_whatever_the_length(empty: Empty) -> None:
    p = empty(2)
    p.unknowns.pose[1, :3] = [3.0, 0, 4.0]
    one_link(p, np.array([0, 0, 7.0, *turned(1, 0.3)]), scaled=False)
    p.links.sqrt_information = np.diag([2.0, 2, 1, 1, 1, 99.0])[None]
    # the measured direction is z; it leans least to x, so b1 = z x x = y and b2 = z x y = -x
    angle = np.arctan2(3, 4)
    np.testing.assert_allclose(residuals(p, "link"), [0, -2 * angle, 0, -0.3, 0], atol=1e-12)
    np.testing.assert_allclose(
        bearing_basis(np.array([0, 0, 7.0])).T, [[0, 1, 0], [-1, 0, 0]], atol=1e-15
    )


def test_a_link_moves_with_its_own_poses_and_with_no_other(empty: Empty) -> None:
    """[KimEustice2009 II-B] measures by poses x_v, and differentiates by x_p: they are the same."""
    still = np.zeros(5)
    for node, moves in ((0, True), (1, True), (2, False)):
        p = empty(3)
        p.unknowns.pose[1:, :3] = [[3.0, 0, 4.0], [1.0, 1, 1]]
        one_link(p, np.array([0.6, 0, 0.8, *turned(1, 0.0)]), scaled=False)
        e = evaluate(p)
        np.testing.assert_allclose(e.residual, still, atol=1e-12)
        own = e.jacobian_value[e.jacobian_column // 7 == node]
        p.unknowns.pose[node, :3] += [0.1, 0.2, 0.0]
        assert np.any(np.abs(evaluate(p).residual) > 1e-3) == moves
        assert np.any(own != 0) == moves


@pytest.mark.parametrize("place", [[0, 0, 0], [0, 0, -3.0]])
def test_bearing_without_or_of_opposite_direction_costs_pi(
    place: list[float], empty: Empty
) -> None:
    p = empty(2)
    p.unknowns.pose[1, :3] = place
    one_link(p, np.array([0, 0, 1.0, *turned(2, 0.0)]), scaled=False)
    e = evaluate(p)
    np.testing.assert_allclose(e.residual, [np.pi, np.pi, 0, 0, 0], atol=1e-15)
    assert np.isfinite(e.jacobian_value).all()


def test_every_link_equals_its_twin(make_survey: Survey, shaken: Survey) -> None:
    p = shaken(make_survey())
    links(p)
    p.links.kernel[:] = LinkKernel.NONE
    p.unknowns.link_switch = np.zeros(0)
    first = camera_poses(p, p.links.first, p.links.camera_first)
    second = camera_poses(p, p.links.second, p.links.camera_second)
    z, step = Poses(p.links.measured[:, 3:], p.links.measured[:, :3]), first.inverse() @ second
    turn = (z.rotation.inv() * step.rotation).as_rotvec()
    expected = []
    for k, scaled in enumerate(p.links.scaled):
        if scaled:
            expected.append(
                p.links.sqrt_information[k] @ np.r_[step.translation[k] - z.translation[k], turn[k]]
            )
            continue
        from_, to = (v / np.linalg.norm(v) for v in (z.translation[k], step.translation[k]))
        across = np.cross(from_, to)
        angle = np.arctan2(np.linalg.norm(across), from_ @ to)
        tangent = angle * np.cross(across / np.linalg.norm(across), from_)
        expected.append(
            p.links.sqrt_information[k, :5, :5]
            @ np.r_[bearing_basis(z.translation[k]).T @ tangent, turn[k]]
        )
    np.testing.assert_allclose(residuals(p, "link"), np.concatenate(expected), atol=1e-9)


@pytest.mark.parametrize("square", [2.0, 5.0, 5.1, 80.0])
def test_dynamic_scaling_weighs_links_as_published(square: float, empty: Empty) -> None:
    p = empty(2)
    p.unknowns.pose[1, 0] = np.sqrt(square)
    one_link(p, np.array([0, 0, 0, 0, 0, 0, 1.0]), scaled=True, kernel=LinkKernel.SCALING)
    e = evaluate(p)
    weight = min(1.0, 10 / (5 + square)) ** 2
    np.testing.assert_allclose(e.weight**2, weight)
    steps = (np.arange(100000) + 0.5) * square / 100000
    integral = np.mean(np.minimum(1.0, 10 / (5 + steps)) ** 2) * square
    assert e.cost_by_factor["link"] == pytest.approx(0.5 * integral, rel=1e-6)
    assert evaluate(p, Options(link_phi=1e3)).cost_by_factor["link"] == pytest.approx(0.5 * square)


def test_scale_alone_as_printed_makes_the_worse_link_cheaper(empty: Empty) -> None:
    """[Ozog2016 eq. 2.1] prints s^2 chi^2: without what s costs itself, s = 0 costs nothing."""
    found, printed = [], []
    for square in (5.0, 20.0, 80.0):
        p = empty(2)
        p.unknowns.pose[1, 0] = np.sqrt(square)
        one_link(p, np.array([0, 0, 0, 0, 0, 0, 1.0]), scaled=True, kernel=LinkKernel.SCALING)
        e = evaluate(p)
        found.append(e.cost_by_factor["link"])
        printed.append(0.5 * float(np.sum((e.weight * e.residual) ** 2)))
        assert printed[-1] == pytest.approx(0.5 * (10 / (5 + square)) ** 2 * square)
    assert np.diff(found).min() > 0.5
    assert np.diff(printed).max() < -0.5


def test_a_switch_multiplies_its_link_and_is_drawn_to_one(empty: Empty) -> None:
    p = empty(2)
    p.unknowns.pose[1, 0] = 2.0
    one_link(p, np.array([0, 0, 0, 0, 0, 0, 1.0]), scaled=True, kernel=LinkKernel.SWITCH)
    p.unknowns.link_switch = np.array([0.4])
    np.testing.assert_allclose(residuals(p, "link"), [0.8, 0, 0, 0, 0, 0, -0.6 * np.sqrt(5)])


def test_a_solved_switch_stands_where_its_cost_is_least(empty: Empty) -> None:
    """At s = Phi / (Phi + u): the switch of a link that the rest holds apart."""
    p = empty(2)
    p.unknowns.pose[1, 0] = 10.0
    p.priors.pose.node, p.priors.pose.value = (
        np.arange(2, dtype=np.int32),
        p.unknowns.pose[:, :7].copy(),
    )
    p.priors.pose.sqrt_information = np.tile(np.eye(6) * 1e6, (2, 1, 1))
    p.constant = (*p.constant, "tray")
    one_link(p, np.array([0, 0, 0, 0, 0, 0, 1.0]), scaled=True, kernel=LinkKernel.SWITCH)
    for core in ("schur", "ceres"):
        got = solve(p, Options(core=core, function_tolerance=1e-14))
        assert got.unknowns.link_switch == pytest.approx([5 / 105], rel=1e-4)
        assert got.iterations.cost[-1] == pytest.approx(0.5 * 5 * 100 / 105, rel=1e-6)


def moved_rigidly(p: Draft, by: Poses) -> None:
    at = by @ Poses(p.unknowns.pose[:, 3:7], p.unknowns.pose[:, :3])
    p.unknowns.pose[:, :3], p.unknowns.pose[:, 3:7] = at.translation, at.quaternion


def test_links_do_not_see_where_the_whole_path_stands(make_survey: Survey, shaken: Survey) -> None:
    p = shaken(make_survey())
    links(p)
    before = residuals(p, "link")
    moved_rigidly(p, exp(np.array([[3.0, -2, 1, 0.5, 1.5, -1]])))
    np.testing.assert_allclose(residuals(p, "link"), before, atol=1e-9)


def test_bearings_do_not_see_how_large_the_path_is(empty: Empty) -> None:
    p = empty(5)
    p.unknowns.pose[:, :3] = np.random.default_rng(1).normal(size=(5, 3))
    links(p)
    p.links.scaled[:] = False
    before = residuals(p, "link")
    p.unknowns.pose[:, :3] *= 3.0
    np.testing.assert_allclose(residuals(p, "link"), before, atol=1e-9)


@pytest.mark.parametrize("coordinate", range(3))
def test_a_longer_measured_link_lowers_its_residual(coordinate: int, empty: Empty) -> None:
    p = empty(2)
    one_link(p, np.array([0.3, 0.2, 0.1, 0, 0, 0, 1.0]), scaled=True)
    before = residuals(p, "link")
    p.links.measured[0, coordinate] += 1e-3
    np.testing.assert_allclose(
        residuals(p, "link") - before, -1e-3 * np.eye(6)[coordinate], atol=1e-12
    )


def circle(n: int, rng: np.random.Generator, *, wrong: int) -> tuple[Draft, Poses]:
    """A path of n nodes twice around a circle by odometry that drifts, tied across by links; some
    link it to a wrong place.
    """
    t = np.linspace(0, 4 * np.pi, n)
    truth = Poses(
        Rotation.from_euler("z", t[:, None] + np.pi / 2).as_quat(),
        np.c_[5 * np.cos(t), 5 * np.sin(t), 0.1 * np.sin(3 * t)],
    )
    step = truth[:-1].inverse() @ truth[1:]
    noisy = step @ exp(
        rng.normal(size=(n - 1, 6)) * np.repeat([0.01, 0.003], 3) + np.r_[0, 0, 0, 0, 0, 0.004]
    )
    path = truth[:1]
    for k in range(n - 1):
        ahead = path[-1:] @ noisy[k : k + 1]
        path = Poses(
            np.vstack([path.quaternion, ahead.quaternion]),
            np.vstack([path.translation, ahead.translation]),
        )
    held = (
        "T_g_M",
        "T_s_ct",
        "T_ct_cb",
        "T_s_d",
        "navigation",
        "intrinsics_top",
        "intrinsics_bottom",
        "tray",
    )
    p = Draft(
        Problem(
            unknowns=Unknowns(pose=np.c_[path.translation, path.quaternion, np.zeros(n)]),
            constant=held,
        )
    )
    p.priors.pose.node, p.priors.pose.value = np.zeros(1, np.int32), p.unknowns.pose[:1, :7].copy()
    p.priors.pose.sqrt_information = np.eye(6)[None] * 1e3
    first = np.r_[np.arange(n - 1), np.arange(n // 2)]
    second = np.r_[np.arange(1, n), np.arange(n // 2) + n // 2]
    measured = (
        truth[first].inverse()
        @ truth[second]
        @ exp(rng.normal(size=(len(first), 6)) * np.repeat([0.005, 0.001], 3))
    )
    measured.translation[n - 1 : n - 1 + wrong] += [1.5, -1.0, 0.5]
    p.links.first, p.links.second = first.astype(np.int32), second.astype(np.int32)
    p.links.camera_first = p.links.camera_second = np.zeros(len(first), np.int32)
    p.links.measured = np.c_[measured.translation, measured.quaternion]
    p.links.sqrt_information = np.tile(np.diag([200.0] * 3 + [1000.0] * 3), (len(first), 1, 1))
    p.links.scaled = np.ones(len(first), bool)
    p.links.kernel = np.r_[np.zeros(n - 1), np.full(n // 2, LinkKernel.SCALING)].astype(np.int32)
    return p, truth


def rms_m(got: np.ndarray, truth: Poses) -> float:
    return float(np.sqrt(np.mean(np.sum((got[:, :3] - truth.translation) ** 2, axis=1))))


@pytest.mark.parametrize("core", ["schur", "ceres"])
@pytest.mark.parametrize("kernel", [LinkKernel.SCALING, LinkKernel.SWITCH])
def test_noisy_links_restore_the_path_despite_wrong_ones(core: str, kernel: LinkKernel) -> None:
    p, truth = circle(80, np.random.default_rng(2), wrong=6)
    p.links.kernel[79:] = kernel
    p.unknowns.link_switch = np.ones(np.count_nonzero(p.links.kernel == LinkKernel.SWITCH))
    assert rms_m(p.unknowns.pose, truth) > 0.5
    got = solve(p, Options(core=core, function_tolerance=1e-10, max_iterations=200))
    assert rms_m(got.unknowns.pose, truth) < 0.05
    if kernel == LinkKernel.SWITCH:
        assert got.unknowns.link_switch[:6].max() < 0.1 * got.unknowns.link_switch[6:].min()


def test_wrong_links_without_a_kernel_bend_the_path(make_survey: Survey) -> None:
    p, truth = circle(80, np.random.default_rng(2), wrong=6)
    p.links.kernel[:] = LinkKernel.NONE
    assert rms_m(solve(p).unknowns.pose, truth) > 0.15


def test_noisy_bearings_across_take_the_drift_out(make_survey: Survey) -> None:
    """Odometry has the length, links of one camera the direction and the turn."""
    rng = np.random.default_rng(7)
    p, truth = circle(80, rng, wrong=0)
    p.links.measured[:79], p.links.sqrt_information[:79] = (
        drifted(p.links.measured[:79]),
        np.diag([100.0] * 3 + [200.0] * 3),
    )
    across = np.arange(79, len(p.links.first))
    p.links.second[across] = p.links.first[across] + 35
    noise = exp(rng.normal(size=(len(across), 6)) * np.repeat([0.005, 0.001], 3))
    step = truth[p.links.first[across]].inverse() @ truth[p.links.second[across]] @ noise
    length = np.linalg.norm(step.translation, axis=1, keepdims=True)
    p.links.measured[across] = np.c_[step.translation / length, step.quaternion]
    p.links.scaled[across], p.links.kernel[across] = False, LinkKernel.NONE
    p.links.sqrt_information[across] = 0
    p.links.sqrt_information[across, :2, :2] = 200 * length[:, :, None] * np.eye(2)
    p.links.sqrt_information[across, 2:5, 2:5] = 1000 * np.eye(3)
    got = rms_m(solve(p, Options(function_tolerance=1e-10)).unknowns.pose, truth)
    for name in (
        "first",
        "second",
        "camera_first",
        "camera_second",
        "measured",
        "sqrt_information",
        "scaled",
        "kernel",
    ):
        setattr(p.links, name, getattr(p.links, name)[:79])
    alone = rms_m(solve(p).unknowns.pose, truth)
    assert alone > 0.5
    assert got < 0.1 * alone


def drifted(measured: np.ndarray) -> np.ndarray:
    """Steps with a turn of a gyro's drift added."""
    found = Poses(measured[:, 3:], measured[:, :3]) @ exp(np.r_[0, 0, 0, 0, 0, 0.004])
    return np.c_[found.translation, found.quaternion]


def test_links_tie_the_camera_to_the_vehicle(make_survey: Survey) -> None:
    """Six turned pairs tell where the camera sits, when the path is known."""
    p = make_survey()
    links(p)
    place = [
        camera_poses(p, n, c)
        for n, c in ((p.links.first, p.links.camera_first), (p.links.second, p.links.camera_second))
    ]
    exact = place[0].inverse() @ place[1]
    p.links.measured = np.c_[exact.translation, exact.quaternion]
    truth = p.unknowns.T_s_ct.copy()
    p.unknowns.T_s_ct[:3] += [0.03, -0.02, 0.01]
    p.priors.T_s_ct = MotionPrior(value=p.unknowns.T_s_ct.copy(), sqrt_information=np.eye(6))
    clear(p, "stereo", "ranges", "surface")
    p.unknowns.landmark = p.unknowns.landmark[:0]
    p.priors.pose.node, p.priors.pose.value = (
        np.arange(8, dtype=np.int32),
        p.unknowns.pose[:, :7].copy(),
    )
    p.priors.pose.sqrt_information = np.tile(np.eye(6) * 1e4, (8, 1, 1))
    got = solve(p, Options(method="naive", function_tolerance=1e-14))
    np.testing.assert_allclose(got.unknowns.T_s_ct[:3], truth[:3], atol=2e-3)
