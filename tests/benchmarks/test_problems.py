# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from benchmarks.problems import _pairs, make
from benchmarks.start import dead_reckoned, measure, steps, triangulate
from benchmarks.survey import (
    BEAMS,
    LEG_SPACING_M,
    SIZES,
    STEP_M,
    TRAY_FROM_TOP,
    TRAY_ORIGIN,
    fly,
    hull_mesh,
    normals,
    side,
    tracks,
)
from hullrecon.geometry import poses
from hullrecon.native import FACTORS, MeshIndex, Options, evaluate, solve
from hullrecon.records.serialisation import to_arrays


def mean_squares(problem):
    """Of the whitened rows of each factor, without the robust loss."""
    found = evaluate(problem, Options(method="maxmix"))
    chosen = {name: found.residual[found.factor == k] for k, name in enumerate(FACTORS)}
    return {
        name: (float(np.mean(rows**2)), len(rows)) for name, rows in chosen.items() if len(rows)
    }


@pytest.mark.parametrize("factor", ["attitude", "odometry", "stereo", "mono", "range"])
def test_at_the_truth_the_residuals_of_a_factor_are_its_noise(at_truth, factor):
    by_factor = mean_squares(at_truth)
    if factor not in by_factor:
        pytest.skip("the size has the other kind of images")
    value, count = by_factor[factor]
    assert abs(value - 1) < 5 * np.sqrt(2 / count)


def test_truth_leaves_backlash_and_mount_priors_as_residuals(at_truth):
    by_factor = mean_squares(at_truth)
    assert by_factor["tray"][0] < 1.1
    assert by_factor["prior"][0] < 3


def test_true_landmarks_are_5_mm_off_the_cad_model_or_well_off(small):
    problem, truth = small
    in_hull = truth.global_from_hull.inverse().apply(truth.landmark)
    distance = (
        MeshIndex(problem.cad_mesh.vertices, problem.cad_mesh.faces, threads=1)
        .closest(in_hull)
        .distance
    )
    assert np.std(distance[~truth.off_hull]) == pytest.approx(0.005, rel=0.1)
    assert distance[truth.off_hull].min() > 0.03
    assert truth.off_hull.mean() == pytest.approx(0.05, abs=0.015)


@pytest.mark.parametrize(
    ("name", "imaged", "landmarks", "views", "ranges"),
    [("stereo", 22434, 243536, 487072, 96944), ("mono", 9249, 100597, 201194, 36996)],
)
def test_the_field_sizes_are_those_of_the_published_table(name, imaged, landmarks, views, ranges):
    size = SIZES[name]
    first, second = _pairs(size, np.random.default_rng(0))
    assert (4 * size.poses, size.imaged, size.landmarks) == (ranges, imaged, landmarks)
    assert len(first) + len(second) == views
    assert len(size.images()) == imaged == len(np.unique(size.images()))
    assert set(np.r_[first, second]) <= set(size.images())
    assert (first != second).all()


def test_a_small_problem_has_the_tables_of_its_size(small, size_name):
    problem, size = small[0], SIZES[size_name]
    assert (
        len(problem.unknowns.pose),
        len(problem.unknowns.landmark),
        len(problem.ranges.node),
    ) == (400, 4000, 1600)
    views = problem.stereo.pixel if size.stereo else problem.mono.pixel
    assert views.shape == (8000, 4 if size.stereo else 2)
    assert len(problem.surface.landmark) == 4000


def test_poses_with_images_of_a_field_problem_see_landmarks():
    size = SIZES["mono"]
    first, second = _pairs(size, np.random.default_rng(0))
    assert len(np.unique(np.r_[first, second])) > 0.999 * size.imaged


def test_loop_closure_joins_one_place_of_neighbouring_legs():
    size = SIZES["stereo"]
    first, second = _pairs(size, np.random.default_rng(0))
    x, z = tracks(size)
    leg_of = np.arange(size.poses) // size.per_leg
    apart = leg_of[second] - leg_of[first]
    assert set(apart) == {0, 1}
    across = second - first > 2
    assert across.mean() == pytest.approx(0.125 * 39 / 40, abs=0.005)
    assert np.abs(x[first] - x[second])[across].max() < 2 * STEP_M
    assert np.abs(np.abs(z[first] - z[second])[across] - LEG_SPACING_M).max() < 0.05


def test_every_landmark_lies_in_the_images_that_see_it(small, size_name):
    problem = small[0]
    pixels = problem.stereo.pixel if SIZES[size_name].stereo else problem.mono.pixel
    assert pixels.min() > 0
    assert (pixels[:, ::2] < 1360).all()
    assert (pixels[:, 1::2] < 1024).all()


@pytest.mark.parametrize("name", ["stereo", "mono"])
def test_dead_reckoning_drifts_by_decimetres_over_the_survey(name):
    nodes, _ = fly(SIZES[name])
    random = np.random.default_rng(0)
    start = dead_reckoned(nodes, measure(nodes, random), random)
    error = np.linalg.norm((start.translation - nodes.translation)[:, :2], axis=1)
    assert 0.3 < error.max() < 5
    assert np.abs(start.translation[:, 2] - nodes.translation[:, 2]).max() < 0.05
    down = [p.rotation.inv().apply([0.0, 0.0, 1.0]) for p in (start, nodes)]
    assert np.linalg.norm(down[0] - down[1], axis=1).max() < np.radians(0.3)


def test_noiseless_dead_reckoning_has_systematic_errors_only():
    size = SIZES["small"]
    nodes, _ = fly(size)
    start = dead_reckoned(nodes, steps(nodes), np.random.default_rng(0))
    leg = size.per_leg - 1
    there, gone = (p.translation[leg] - p.translation[0] for p in (start, nodes))
    assert np.linalg.norm(there) / np.linalg.norm(gone) == pytest.approx(1.003, abs=0.001)


def test_the_camera_looks_down_the_normal_from_a_metre():
    size = SIZES["stereo"]
    hull_from_vehicle, tray = fly(size)
    x, z = tracks(size)
    camera = hull_from_vehicle @ poses.tray_poses(TRAY_ORIGIN, tray) @ TRAY_FROM_TOP
    ahead = camera.rotation.apply([0.0, 0.0, 1.0])
    assert (np.einsum("ij,ij->i", ahead, normals(x, z)) < np.cos(np.radians(174))).all()
    hits = MeshIndex(*hull_mesh(), threads=1).cast(camera.translation, ahead)
    assert hits.range.min() > 0.9
    assert hits.range.max() < 1.15


def test_the_hull_curves_both_ways_and_faces_outward():
    x, z = np.array([0.0, 60.0]), np.array([7.0, 7.0])
    assert side(x, z)[0] - side(x, z)[1] > 3
    assert side(x[:1], np.array([12.0]))[0] - side(x[:1], np.array([2.0]))[0] > 3
    vertices, faces = hull_mesh()
    corners = vertices[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert len(faces) == 20000
    assert (normal[:, 1] > 0).all()
    assert np.allclose(np.linalg.norm(BEAMS, axis=1), 1)


def test_rays_crossing_behind_are_replaced_by_the_range():
    origins = np.array([[[0.0, 0, 0], [1.0, 0, 0]], [[0.0, 0, 0], [1.0, 0, 0]]])
    inward = np.array([[1.0, 0, 1], [-1.0, 0, 1]]) / np.sqrt(2)
    rays = np.stack([inward, inward[::-1]])
    points = triangulate(origins, rays, np.array([0.7, 0.7]))
    np.testing.assert_allclose(points[0], [0.5, 0, 0.5], atol=1e-5)
    np.testing.assert_allclose(points[1], 0.7 * rays[1, 0], atol=1e-12)


def test_seed_alone_determines_the_bytes(small, size_name):
    again, other = make(SIZES[size_name]), make(SIZES[size_name], seed=1)
    expected = to_arrays(small[0])
    for name, array in to_arrays(again).items():
        assert np.array_equal(array, expected[name]), name
    assert not np.array_equal(again.unknowns.landmark, other.unknowns.landmark)


def test_a_part_keeps_the_density():
    whole = SIZES["stereo"]
    part = whole.part(16)
    assert (part.poses, part.legs) == (1514, 10)
    assert part.landmarks / part.poses == pytest.approx(whole.landmarks / whole.poses, rel=1e-3)
    with pytest.raises(ValueError, match="square"):
        whole.part(15)


@pytest.mark.parametrize("method", ["naive", "maxmix"])
def test_the_solver_comes_back_to_the_truth(small, method):
    problem, truth = small
    result = solve(problem, Options(method=method))
    assert result.converged
    position = result.unknowns.pose[:, :3] - result.unknowns.pose[:, :3].mean(0)
    expected = truth.nodes.translation - truth.nodes.translation.mean(0)
    # To the millimetres that a rotation about the middle of a 20 m survey may still hide.
    assert np.sqrt(((position - expected) ** 2).sum(1).mean()) < 0.08
    if method == "maxmix":
        assert np.mean((result.label == 0) == truth.off_hull) > 0.99
