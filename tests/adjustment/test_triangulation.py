# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace

import numpy as np

from hullrecon.adjustment.problem.state import State
from hullrecon.adjustment.problem.triangulation import (
    camera_poses,
    reprojection_errors,
    triangulate,
)


def test_landmarks_are_found_where_they_are(scene):
    position, _ = triangulate(scene.tracks, len(scene.points), scene.top, scene.bottom, scene.rig)
    seen = np.isfinite(position[:, 0])
    assert seen.mean() > 0.9
    np.testing.assert_allclose(position[seen], scene.points[seen], atol=1e-6)


def test_a_single_ray_gives_no_landmark(scene):
    t = scene.tracks
    first = np.flatnonzero(np.isfinite(t.top[:, 0]))[:1]
    alone = replace(
        t,
        landmark=t.landmark[first],
        node=t.node[first],
        top=t.top[first],
        bottom=np.full((1, 2), np.nan),
    )
    position, spread = triangulate(alone, len(scene.points), scene.top, scene.bottom, scene.rig)
    assert np.isnan(position).all()
    assert spread[t.landmark[first[0]]] == 0.0


def test_two_rays_spread_by_the_angle_between_them(scene):
    t = scene.tracks
    row = np.flatnonzero(np.isfinite(t.top[:, 0]) & np.isfinite(t.bottom[:, 0]))[:1]
    pair = replace(
        t, landmark=t.landmark[row], node=t.node[row], top=t.top[row], bottom=t.bottom[row]
    )
    _, spread = triangulate(pair, len(scene.points), scene.top, scene.bottom, scene.rig)
    node, number = t.node[row[0]], t.landmark[row[0]]
    rays = [scene.points[number] - pose.translation[node] for pose in (scene.top, scene.bottom)]
    angle = np.arccos(rays[0] @ rays[1] / np.linalg.norm(rays[0]) / np.linalg.norm(rays[1]))
    np.testing.assert_allclose(spread[number], angle, rtol=1e-6)


def test_the_camera_hangs_on_the_tray(scene):
    state = State(
        nodes=scene.nodes,
        tray=scene.tray,
        landmark=scene.points,
        mounts=scene.rig.mounts,
        navigation=np.zeros(6),
        hull=None,
    )
    top, bottom = camera_poses(scene.rig, state)
    np.testing.assert_allclose(top.matrix(), scene.top.matrix(), atol=1e-12)
    np.testing.assert_allclose(bottom.matrix(), scene.bottom.matrix(), atol=1e-12)


def test_reprojection_errors_are_pixel_distances(scene):
    t = scene.tracks
    moved = replace(t, top=t.top + np.array([3.0, 4.0]))
    top, bottom = reprojection_errors(moved, scene.points, scene.top, scene.bottom, scene.rig)
    np.testing.assert_allclose(top[np.isfinite(top)], 5.0, atol=1e-6)
    np.testing.assert_allclose(bottom[np.isfinite(bottom)], 0.0, atol=1e-6)
