# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Dives without a camera, at the level of poses and beams: what planes take out of the drift, and
when they are left out.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from navigation.planar_dive import aligned, simulate

from hullrecon import native
from hullrecon.geometry.poses import tray_poses
from hullrecon.navigation.planes.planar_graph import PlanarGraph, PlanarSolution, planar_graph
from hullrecon.navigation.pose_graph.graph import GraphSolution, PoseGraph
from hullrecon.records.links import CameraLinks, no_links
from hullrecon.studies.scenes.ellipsoid_dive import (
    STEP_S,
    EllipsoidDive,
    reckoned,
    spiral_around_a_sphere,
)


def graph(dive: EllipsoidDive) -> PoseGraph:
    return PoseGraph(
        trajectory=dive.trajectory, odometry=dive.odometry, attitude=dive.attitude, rig=dive.rig
    )


def solve(dive: EllipsoidDive) -> tuple[GraphSolution, PlanarSolution]:
    """Without planes and with them."""
    alone = graph(dive)
    return alone.solve(no_links()), planar_graph(alone, dive.returns, None).solve(no_links())


def rms_m(dive: EllipsoidDive, solved: GraphSolution) -> float:
    error = aligned(solved.path.poses.translation, dive.truth.translation)
    return float(np.sqrt(np.mean(np.sum(error**2, axis=1))))


@pytest.fixture(scope="module")
def drifting() -> tuple[EllipsoidDive, GraphSolution, PlanarSolution]:
    dive = simulate(2, drift_deg_per_hour=100.0, legs=3)
    return dive, *solve(dive)


def test_planes_take_a_heading_drift_out_of_the_path(drifting) -> None:
    dive, alone, planar = drifting
    assert planar.refusal is None
    assert planar.planes is not None
    assert len(planar.planes) > 50
    assert rms_m(dive, planar) < 0.3 * rms_m(dive, alone)


def test_planes_improve_across_hull_and_heading_but_not_along(drifting) -> None:
    """x points into the hull, y along it: a patch slid along a smooth hull is the same."""
    dive, alone, planar = drifting
    before, after = (
        np.sqrt(np.mean(aligned(s.path.poses.translation, dive.truth.translation) ** 2, axis=0))
        for s in (alone, planar)
    )
    assert after[0] < 0.15 * before[0]
    assert after[1] > 0.5 * before[1]
    was, found = (s.problem.unknowns.navigation[1] for s in (alone, planar))
    true = np.radians(100) / 3600
    assert abs(found - true) < 0.25 * true
    assert abs(was) < 0.1 * true


def test_errors_lie_within_a_few_of_the_sigmas_of_the_solve(drifting) -> None:
    dive, _, planar = drifting
    sigma = np.sqrt(np.einsum("nii->ni", native.covariance(planar.problem).pose))
    error = planar.path.poses.translation - dive.truth.translation
    turn = (dive.truth.rotation.inv() * planar.path.poses.rotation).as_rotvec()
    ratio = np.sqrt(np.mean((np.hstack([error, turn]) / sigma[:, :6])[20:] ** 2, axis=0))
    assert (ratio < 2.5).all()


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    ("kind", "drift"),
    [({}, 1.0), ({"semi_axes_m": (3.0, 30.0, 4.0)}, 40.0), ({"spacing_m": 1.5}, 100.0)],
)
def test_they_never_make_a_path_worse(seed: int, kind: dict, drift: float) -> None:
    dive = simulate(seed, drift_deg_per_hour=drift, legs=2, leg_m=8.0, **kind)
    alone, planar = solve(dive)
    assert rms_m(dive, planar) <= 1.05 * rms_m(dive, alone)


def with_outage(dive: EllipsoidDive, off_m: float, sigma_m: float) -> EllipsoidDive:
    """The dive with one step in its middle that nothing measured, of a minute more: off along the
    hull.
    """
    step = len(dive.odometry) // 2
    odometry = dive.odometry
    translation, covariance = odometry.translation.copy(), odometry.covariance.copy()
    translation[step, 1] += off_m
    covariance[step, [0, 1, 2], [0, 1, 2]] = sigma_m**2
    odometry = replace(odometry, translation=translation, covariance=covariance)
    later = 60 * 10**9 * (np.arange(len(dive.truth)) > step)
    trajectory = reckoned(dive.truth.matrix()[0], odometry, STEP_S)
    return replace(
        dive,
        odometry=odometry,
        trajectory=replace(trajectory, t_ns=trajectory.t_ns + later),
        returns=replace(dive.returns, t_ns=dive.returns.t_ns + later[dive.returns.node]),
    )


def test_patches_of_unknown_place_along_hull_are_not_compared() -> None:
    """After a minute without a DVL the hull's form, taken as known where it is not, pulled the path
    1.7 m along to where it fits as well, and was sure of it to 0.24 m.
    """
    dive = simulate(2, drift_deg_per_hour=60.0, legs=2, semi_axes_m=(5.0, 60.0, 6.0))
    lost = with_outage(dive, 0.2, 2.3)
    alone, planar = solve(lost)
    assert rms_m(lost, planar) <= 1.05 * rms_m(lost, alone)
    sigma = np.sqrt(np.einsum("nii->ni", native.covariance(planar.problem).pose))[:, :3]
    error = planar.path.poses.translation - dive.truth.translation
    ratio = np.sqrt(np.mean((error / np.maximum(sigma, 1e-3))[20:] ** 2, axis=0))
    assert (ratio < 2.5).all()


@pytest.mark.parametrize("kind", [{"off_m": 0.3}, {"bumps_m": 0.1}])
def test_changed_surface_ties_little_and_does_no_harm(kind: dict) -> None:
    """Something hung before the hull on every other leg; a rough rock."""
    dive = simulate(7, drift_deg_per_hour=20.0, legs=3, leg_m=8.0, **kind)
    alone, planar = solve(dive)
    assert (
        planar.refusal is not None
        or planar.planes is None
        or rms_m(dive, planar) <= rms_m(dive, alone)
    )
    assert rms_m(dive, planar) <= 1.05 * rms_m(dive, alone)


def test_a_dive_of_one_leg_has_nothing_to_tie() -> None:
    dive = simulate(1, drift_deg_per_hour=20.0, legs=1)
    alone, planar = solve(dive)
    assert (planar.offered, planar.planes, planar.refusal) == (0, None, None)
    np.testing.assert_array_equal(planar.path.poses.translation, alone.path.poses.translation)


def test_planes_say_nothing_where_links_know_better() -> None:
    """Links of millimetres between neighbours and across legs: no patch could add to that."""
    dive = simulate(3, drift_deg_per_hour=50.0, legs=2, leg_m=6.0)
    links = exact_links(dive)
    alone = graph(dive).solve(links)
    planar = planar_graph(graph(dive), dive.returns, None).solve(links)
    assert planar.patches > 10
    assert (planar.offered, planar.planes) == (0, None)
    np.testing.assert_array_equal(planar.path.poses.translation, alone.path.poses.translation)


def test_the_same_dive_gives_the_same_bytes(drifting) -> None:
    dive, _, planar = drifting
    again = planar_graph(graph(dive), dive.returns, None).solve(no_links())
    np.testing.assert_array_equal(again.problem.unknowns.pose, planar.problem.unknowns.pose)


def test_solution_with_planes_starts_next_round_of_links(drifting) -> None:
    dive, _, planar = drifting
    again = planar_graph(graph(dive), dive.returns, None).solve(no_links(), planar)
    np.testing.assert_allclose(
        again.path.poses.translation, planar.path.poses.translation, atol=2e-3
    )


def test_sphere_is_mapped_alike_for_characteristic_radii() -> None:
    """[Ozog2016 C]: a spiral around a sphere of 8 m. What counts is how well a sphere fits the
    path.
    """
    dive, radius = spiral_around_a_sphere(5, radius_m=8.0, turns=2.0, drift_deg_per_hour=60.0), 9.2
    odd = {}
    for characteristic in (4.0, 8.0, 20.0):
        curvature = np.array([1.0, 0.3, 1.0]) / characteristic
        planar = PlanarGraph(graph=graph(dive), returns=dive.returns, curvature=curvature).solve(
            no_links()
        )
        odd[characteristic] = sphere_error_m(planar.path.poses.translation, radius)
    alone = sphere_error_m(graph(dive).solve(no_links()).path.poses.translation, radius)
    assert max(odd.values()) < 0.4 * alone
    assert max(odd.values()) - min(odd.values()) < 0.25 * max(odd.values()) + 0.002


def sphere_error_m(at: np.ndarray, radius: float) -> float:
    """Root mean square distance from the sphere that fits best."""
    solution = np.linalg.lstsq(np.c_[2 * at, np.ones(len(at))], np.sum(at**2, axis=1), rcond=None)[
        0
    ]
    assert abs(np.sqrt(solution[3] + solution[:3] @ solution[:3]) - radius) < 0.5 * radius
    return float(np.std(np.linalg.norm(at - solution[:3], axis=1)))


def exact_links(dive: EllipsoidDive) -> CameraLinks:
    n = len(dive.truth)
    k = np.arange(n // 2 - 2)
    pairs = np.vstack([np.c_[np.arange(n - 1), np.arange(1, n)], np.c_[k, n - 1 - k]])
    camera = dive.truth @ tray_poses(dive.rig.tray_origin, 0.0)
    motion = camera[pairs[:, 1]].inverse() @ camera[pairs[:, 0]]
    return CameraLinks(
        first=pairs[:, 0],
        second=pairs[:, 1],
        translation=motion.translation,
        quaternion=motion.quaternion,
        covariance=np.tile(np.diag(np.r_[np.full(3, 1e-8), np.full(3, 1e-10)]), (len(pairs), 1, 1)),
        scaled=np.ones(len(pairs), bool),
        bottom=np.zeros((len(pairs), 2), bool),
    )
