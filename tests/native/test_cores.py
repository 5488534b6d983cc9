# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The Schur core against Ceres: the same steps to the same optimum, whatever the problem holds."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
from drafts import Draft, clear, solve

from hullrecon.errors import StageError
from hullrecon.geometry.poses import Poses, exp, tray_poses
from hullrecon.native import LinkKernel, MotionPrior, Options, Result

Survey = Callable[..., Draft]
Change = Callable[[Draft], None]
BLOCKS = (
    "T_g_M",
    "T_s_ct",
    "T_ct_cb",
    "T_s_d",
    "navigation",
    "deviation",
    "intrinsics_top",
    "intrinsics_bottom",
    "tray",
)


def leave(*names: str) -> Change:
    """Leaves these tables of measurements alone."""

    def change(p: Draft) -> None:
        clear(
            p,
            *({"attitude", "tray", "odometry", "stereo", "mono", "ranges", "surface"} - set(names)),
        )

    return change


def hold(*names: str) -> Change:
    def change(p: Draft) -> None:
        p.constant = (*p.constant, *names)

    return change


def free(*names: str) -> Change:
    """With priors, so that nothing is undetermined."""

    def change(p: Draft) -> None:
        p.constant = tuple(name for name in p.constant if name not in names)
        p.priors.T_ct_cb = MotionPrior(
            value=p.unknowns.T_ct_cb.copy(), sqrt_information=np.eye(6) / 1e-3
        )
        p.priors.T_s_d = MotionPrior(
            value=p.unknowns.T_s_d.copy(), sqrt_information=np.eye(6) / 1e-2
        )
        p.priors.navigation_sigma = np.full(6, 0.01)
        p.priors.intrinsics_sigma = np.r_[5.0, 5, 5, 5, 0.01, 0.01, 0.001, 0.001, 0.01]

    return change


def field(p: Draft) -> None:
    """A field of five nodes, met by landmarks and beams; some rows name a node twice, some weights
    are nothing.
    """
    free("deviation")(p)
    rng = np.random.default_rng(3)
    p.unknowns.deviation = 0.01 * rng.normal(size=5)
    for nodes, rows in (
        (p.surface.field, len(p.surface.landmark)),
        (p.ranges.field, len(p.ranges.node)),
    ):
        nodes.index = rng.integers(0, 5, (rows, 4)).astype(np.int32)
        nodes.weight = np.where(rng.random((rows, 4)) < 0.2, 0.0, 0.25)
    p.priors.deviation.start, p.priors.deviation.index = (
        np.arange(0, 11, 2, dtype=np.int32),
        rng.integers(0, 5, 10).astype(np.int32),
    )
    p.priors.deviation.value = rng.uniform(20, 50, 10)


def mono(p: Draft) -> None:
    """The pairs' images one by one, a third of them left out."""
    keep = np.random.default_rng(1).random(2 * len(p.stereo.node)) < 0.67
    node, landmark = np.tile(p.stereo.node, 2)[keep], np.tile(p.stereo.landmark, 2)[keep]
    camera = np.repeat([0, 1], len(p.stereo.node)).astype(np.int32)[keep]
    p.mono.pixel = np.vstack([p.stereo.pixel[:, :2], p.stereo.pixel[:, 2:]])[keep]
    leave("attitude", "tray", "odometry", "mono", "ranges", "surface")(p)
    p.mono.node, p.mono.landmark, p.mono.camera = node, landmark, camera


def mono_beside_stereo(p: Draft) -> None:
    half = len(p.stereo.node) // 2
    p.mono.node, p.mono.landmark = p.stereo.node[half:], p.stereo.landmark[half:]
    p.mono.camera, p.mono.pixel = (
        (np.arange(len(p.mono.node)) % 2).astype(np.int32),
        np.zeros((len(p.mono.node), 2)),
    )
    p.mono.pixel[:] = np.where(
        p.mono.camera[:, None] == 0, p.stereo.pixel[half:, :2], p.stereo.pixel[half:, 2:]
    )
    p.stereo.node, p.stereo.landmark, p.stereo.pixel = (
        p.stereo.node[:half],
        p.stereo.landmark[:half],
        p.stereo.pixel[:half],
    )
    again = np.arange(10)  # and some twice
    p.mono.node, p.mono.landmark = (
        np.r_[p.mono.node, p.stereo.node[again]],
        np.r_[p.mono.landmark, p.stereo.landmark[again]],
    )
    p.mono.camera, p.mono.pixel = (
        np.r_[p.mono.camera, np.zeros(10, np.int32)],
        np.r_[p.mono.pixel, p.stereo.pixel[again, :2]],
    )
    for table in (p.stereo, p.mono):
        table.sigma_ratio = np.geomspace(0.3, 3.0, len(table.node))


def outliers(p: Draft) -> None:
    p.stereo.pixel[::9] += 40.0
    p.unknowns.landmark[3] = p.unknowns.pose[0, :3] - [0, 0, 3.0]  # behind its camera
    p.ranges.beam[3] = [0, 0, -1.0]


def two_surfaces(p: Draft) -> None:
    p.surface.landmark = np.r_[p.surface.landmark, p.surface.landmark[:20]]
    p.surface.weight = np.r_[p.surface.weight, np.full(20, 0.03)]
    p.surface.weight[5:9] = 0.0


def isolated(p: Draft) -> None:
    """A landmark that nothing sees, one that only the hull holds, a pose without images, a loose
    pose's tray.
    """
    p.unknowns.landmark = np.vstack([p.unknowns.landmark, p.unknowns.landmark[:2] + 0.01])
    p.surface.landmark, p.surface.weight = (
        np.r_[p.surface.landmark, 60].astype(np.int32),
        np.r_[p.surface.weight, 0.1],
    )
    seen = p.stereo.node != 3
    p.stereo.node, p.stereo.landmark, p.stereo.pixel = (
        p.stereo.node[seen],
        p.stereo.landmark[seen],
        p.stereo.pixel[seen],
    )


def no_landmarks(p: Draft) -> None:
    leave("attitude", "tray", "odometry", "ranges")(p)
    p.unknowns.landmark = p.unknowns.landmark[:0]


def links(p: Draft) -> None:
    """Links of both forms between all cameras, under each kernel, every seventh of them wrong."""
    rng = np.random.default_rng(6)
    m, n = 28, len(p.unknowns.pose)
    first = rng.integers(0, n, m)
    second = (first + rng.integers(1, n, m)) % n
    camera = rng.integers(0, 2, (2, m))
    place = [
        camera_poses(p, node, which) for node, which in zip((first, second), camera, strict=True)
    ]
    noise = rng.normal(size=(m, 6)) * np.repeat([0.02, 0.005], 3)
    noise[::7] *= 40
    measured = place[0].inverse() @ place[1] @ exp(noise)
    p.links.first, p.links.second = first.astype(np.int32), second.astype(np.int32)
    p.links.camera_first, p.links.camera_second = camera.astype(np.int32)
    p.links.measured = np.hstack([measured.translation, measured.quaternion])
    p.links.sqrt_information = np.diag([50.0] * 3 + [200.0] * 3) + rng.normal(size=(m, 6, 6))
    p.links.scaled, p.links.kernel = np.arange(m) % 2 == 0, (np.arange(m) // 2 % 3).astype(np.int32)
    p.unknowns.link_switch = rng.uniform(
        0.5, 1, np.count_nonzero(p.links.kernel == LinkKernel.SWITCH)
    )


def camera_poses(p: Draft, node: np.ndarray, camera: np.ndarray) -> Poses:
    """T_g_c of the top (0) or bottom (1) cameras."""
    pose, mount, bottom = p.unknowns.pose[node], p.unknowns.T_s_ct, p.unknowns.T_ct_cb
    top = (
        Poses(pose[:, 3:7], pose[:, :3])
        @ tray_poses(p.lever_arms.tray, pose[:, 7])
        @ Poses(mount[None, 3:], mount[None, :3])
    )
    below = top @ Poses(bottom[None, 3:], bottom[None, :3])
    choose = np.asarray(camera == 1)[:, None]
    return Poses(
        np.where(choose, below.quaternion, top.quaternion),
        np.where(choose, below.translation, top.translation),
    )


def planes(p: Draft) -> None:
    """Planes below the nodes, some of them seen from several, ranges to them, pairs of them, and
    velocities.
    """
    rng = np.random.default_rng(7)
    n, count = len(p.unknowns.pose), 6
    at = Poses(p.unknowns.pose[:, 3:7], p.unknowns.pose[:, :3])
    p.planes.anchor = (np.arange(count) % 4).astype(np.int32)
    p.unknowns.plane = np.array([0.1, 0.05, -1.6]) + 0.2 * rng.normal(size=(count, 3))
    sightings = np.r_[np.arange(count), rng.integers(0, count, 14)]
    node = np.r_[p.planes.anchor, rng.integers(0, n, 14)]
    p.plane_sightings.plane, p.plane_sightings.node = (
        sightings.astype(np.int32),
        node.astype(np.int32),
    )
    predicted = planes_seen(at, p.unknowns.plane[sightings], p.planes.anchor[sightings], node)
    p.plane_sightings.measured = predicted + 0.02 * rng.normal(size=predicted.shape)
    p.plane_sightings.sqrt_information = 50 * np.eye(3) + 5 * rng.normal(size=(len(node), 3, 3))
    p.plane_pairs.first, p.plane_pairs.second = (
        np.array([0, 1, 2, 4], np.int32),
        np.array([1, 2, 3, 0], np.int32),
    )
    p.plane_pairs.measured = 0.05 * rng.normal(size=(4, 3))
    p.plane_pairs.sqrt_information = 10 * np.eye(3) + rng.normal(size=(4, 3, 3))
    by_place = np.random.default_rng(9)  # apart, so that what follows is drawn as before
    p.plane_pairs.point, p.plane_pairs.place = by_place.normal(size=(2, 4, 3))
    p.plane_pairs.by_place = 0.2 * by_place.normal(size=(4, 3, 3))
    m = 12
    p.plane_ranges.node, p.plane_ranges.plane = (
        rng.integers(0, k, m).astype(np.int32) for k in (n, count)
    )
    offset = exp(0.02 * rng.normal(size=(m, 6)))
    p.plane_ranges.offset = np.hstack([offset.translation, offset.quaternion])
    p.plane_ranges.tray_offset, p.plane_ranges.beam = (
        0.01 * rng.normal(size=m),
        np.tile([[0.5, 0, 0.75**0.5]], (m, 1)),
    )
    p.plane_ranges.measured, p.plane_ranges.sigma = rng.uniform(1.5, 2, m), np.full(m, 0.05)
    p.velocities.first, p.velocities.second, p.velocities.third = (
        np.arange(3) + k for k in np.arange(3, dtype=np.int32)[:, None]
    )
    p.velocities.before, p.velocities.after = np.array([1.0, 1.5, 2.0]), np.array([1.5, 2.0, 1.0])
    p.velocities.sigma = np.tile(np.repeat([0.1, 0.05], 3), (3, 1))


def positions(p: Draft) -> None:
    """A position at most nodes, some at two, every fifth of them wrong."""
    rng = np.random.default_rng(8)
    m, n = 14, len(p.unknowns.pose)
    p.positions.node, p.positions.antenna = (
        (np.arange(m) % (n - 1)).astype(np.int32),
        0.3 * rng.normal(size=(m, 3)),
    )
    p.unknowns.world, heading = np.array([10.0, -4.0, 2.3]), 2.2
    turn = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
    at = Poses(p.unknowns.pose[p.positions.node, 3:7], p.unknowns.pose[p.positions.node, :3]).apply(
        p.positions.antenna
    )
    p.positions.measured = (
        np.array([9.5, -4.2]) + at[:, :2] @ turn.T + 0.05 * rng.normal(size=(m, 2))
    )
    p.positions.measured[::5] += 5.0
    p.positions.sigma = rng.uniform(0.03, 0.1, m)


def planes_seen(at: Poses, plane: np.ndarray, anchor: np.ndarray, node: np.ndarray) -> np.ndarray:
    """Planes of their anchors in the vehicle frames of nodes: the foot of each node's origin on the
    plane, turned about.
    """
    distance = np.linalg.norm(plane, axis=1, keepdims=True)
    normal = at[anchor].rotation.apply(plane / distance)
    height = (
        np.sum(normal * (at[node].translation - at[anchor].translation), axis=1, keepdims=True)
        + distance
    )
    return np.asarray(at[node].rotation.inv().apply(height * normal))


CASES: dict[str, tuple[Change, ...]] = {
    "as it is": (),
    "mono": (mono,),
    "mono beside stereo": (mono_beside_stereo,),
    "outliers": (outliers,),
    "field": (field,),
    "field and mono": (field, mono),
    "everything free": (free(*BLOCKS), field),
    "everything free, mono": (free(*BLOCKS), field, mono_beside_stereo),
    "bottom camera free": (free("T_ct_cb"),),
    "bottom intrinsics free": (free("intrinsics_bottom"), mono_beside_stereo),
    "navigation free": (free("navigation", "T_s_d"),),
    "tray held": (hold("tray"),),
    "hull held": (hold("T_g_M"), field),
    "mount held": (hold("T_s_ct"), field),
    "both held": (hold("T_s_ct", "T_g_M"),),
    "images alone": (leave("stereo", "odometry"),),
    "two surfaces": (two_surfaces, field),
    "isolated": (isolated,),
    "no landmarks": (no_landmarks,),
    "no landmarks, field": (field, no_landmarks),
    "links": (links,),
    "everything free, links": (free(*BLOCKS), field, mono_beside_stereo, links),
    "links, tray held": (hold("tray"), links),
    "planes": (planes,),
    "everything free, planes": (free(*BLOCKS), field, mono_beside_stereo, planes, links),
    "planes, tray held": (hold("tray"), planes, no_landmarks),
    "positions": (positions,),
    "everything free, positions": (free(*BLOCKS), field, mono_beside_stereo, planes, positions),
    "positions alone": (hold("T_g_M"), positions, no_landmarks),
    "world held": (hold("world"), positions),
    "links alone": (hold("T_g_M"), links, no_landmarks, leave("attitude", "tray")),
}


def problem(case: str, make_survey: Survey, shaken: Survey, seed: int = 5) -> Draft:
    p = shaken(make_survey(pixel_noise=0.5), 0.02, 0.005, seed)
    for change in CASES[case]:
        change(p)
    return p


def both(p: Draft, options: Options) -> tuple[Result, Result]:
    return solve(p, dataclasses.replace(options, core="schur")), solve(
        p, dataclasses.replace(options, core="ceres")
    )


@pytest.mark.parametrize(
    ("case", "method"),
    # geva has no rest among outliers: it ends in neither core
    [(c, m) for c in CASES for m in ("naive", "geva", "maxmix") if (c, m) != ("outliers", "geva")],
)
def test_both_cores_come_to_one_optimum(
    case: str, method: str, make_survey: Survey, shaken: Survey
) -> None:
    schur, ceres = both(
        problem(case, make_survey, shaken), Options(method=method, function_tolerance=1e-10)
    )
    assert schur.converged == ceres.converged
    assert schur.iterations.cost[0] == pytest.approx(ceres.iterations.cost[0], rel=1e-12)
    assert schur.iterations.cost[-1] == pytest.approx(ceres.iterations.cost[-1], rel=1e-6)
    np.testing.assert_array_equal(schur.label, ceres.label)


@pytest.mark.parametrize(
    "case",
    [
        "as it is",
        "outliers",
        "everything free, mono",
        "tray held",
        "no landmarks",
        "links",
        "links alone",
        "planes",
        "positions",
    ],
)
def test_both_cores_take_the_same_steps(case: str, make_survey: Survey, shaken: Survey) -> None:
    schur, ceres = (
        r.iterations for r in both(problem(case, make_survey, shaken), Options(max_iterations=4))
    )
    rows = min(len(schur.cost), len(ceres.cost))
    for name in ("cost", "cost_change", "step_norm", "gradient_norm", "radius"):
        np.testing.assert_allclose(
            getattr(schur, name)[:rows],
            getattr(ceres, name)[:rows],
            rtol=1e-5,
            atol=1e-9,
            err_msg=name,
        )
    for name in ("accepted", "on_surface", "label_changes", "rays_missed"):
        np.testing.assert_array_equal(
            getattr(schur, name)[:rows], getattr(ceres, name)[:rows], err_msg=name
        )
    for name, cost in schur.cost_by_factor.items():
        np.testing.assert_allclose(
            cost[:rows], ceres.cost_by_factor[name][:rows], rtol=1e-6, atol=1e-9, err_msg=name
        )


@pytest.mark.parametrize("seed", [2, 4])
def test_steps_that_fail_shrink_the_radius_alike(
    seed: int, make_survey: Survey, shaken: Survey
) -> None:
    p = shaken(make_survey(pixel_noise=0.5), 0.3, 0.1, seed)
    schur, ceres = (
        r.iterations for r in both(p, Options(function_tolerance=1e-10, initial_radius=1e8))
    )
    assert (~schur.accepted).sum() >= 8
    np.testing.assert_array_equal(schur.accepted, ceres.accepted)
    np.testing.assert_allclose(schur.radius, ceres.radius, rtol=1e-3)
    assert schur.cost[-1] == pytest.approx(ceres.cost[-1], rel=1e-6)


@pytest.mark.parametrize(
    "case", ["as it is", "everything free, mono", "two surfaces", "everything free, planes"]
)
def test_the_bytes_do_not_depend_on_the_threads(
    case: str, make_survey: Survey, shaken: Survey
) -> None:
    p = problem(case, make_survey, shaken)
    one, two, three = (solve(p, Options(threads=threads)) for threads in (1, 2, 3))
    for other in (two, three):
        for name, value in vars(one.unknowns).items():
            assert value.tobytes() == getattr(other.unknowns, name).tobytes()
        assert one.iterations.cost.tobytes() == other.iterations.cost.tobytes()


@pytest.mark.slow
def test_large_survey_is_equal_for_any_threads_and_for_ceres(
    make_survey: Survey, shaken: Survey
) -> None:
    p = shaken(make_survey(poses=90, landmarks=2500, pixel_noise=0.5))
    one, two = (solve(p, Options(threads=threads)) for threads in (1, 2))
    assert one.unknowns.landmark.tobytes() == two.unknowns.landmark.tobytes()
    ceres = solve(p, Options(core="ceres"))
    assert one.iterations.cost[-1] == pytest.approx(ceres.iterations.cost[-1], rel=1e-6)
    assert len(one.iterations.cost) == len(ceres.iterations.cost)


@pytest.mark.parametrize("core", ["schur", "ceres"])
def test_a_start_that_cannot_be_evaluated_is_refused_by_both(
    core: str, make_survey: Survey
) -> None:
    p = make_survey()
    p.unknowns.pose[3, 3:7] = [0, np.sqrt(0.5), 0, np.sqrt(0.5)]  # bow straight up: no roll
    with pytest.raises(StageError, match="solver failed"):
        solve(p, Options(core=core))


def test_no_iterations_leave_the_start(make_survey: Survey, shaken: Survey) -> None:
    p = shaken(make_survey())
    got = solve(p, Options(max_iterations=0))
    np.testing.assert_array_equal(got.unknowns.pose, p.unknowns.pose)
    assert (len(got.iterations.cost), got.converged) == (1, False)
