# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.geometry.frames import Frame
from hullrecon.geometry.poses import Poses
from hullrecon.records.serialisation import from_arrays, to_arrays
from hullrecon.records.solution import HullPose, Landmarks, Mounts, Solution
from hullrecon.records.surface import Surface
from hullrecon.records.tracks import Tracks

N, L = 3, 2
HULL_TURN = Rotation.from_euler("x", 180, degrees=True)
HULL_AT = np.array([1.0, 2.0, 3.0])


def hull_pose() -> HullPose:
    """The hull upside down in g, as z is up in M, at (1, 2, 3)."""
    return HullPose(
        global_from_hull=Poses(HULL_TURN.as_quat()[None], HULL_AT[None]),
        covariance=np.eye(6),
        survey_center=np.zeros(3),
    )


def solution(pose: HullPose | None) -> Solution:
    still = np.tile([0.0, 0.0, 0.0, 1.0], (N, 1))
    return Solution(
        t_ns=np.arange(N, dtype=np.int64),
        image=np.column_stack([np.arange(N), np.full(N, -1)]),
        global_from_vehicle=Poses(
            still, np.column_stack([np.arange(N), np.zeros(N), np.full(N, 4.0)])
        ),
        tray=0.1 * np.arange(N),
        tray_sigma=np.full(N, 0.01),
        pose_covariance=np.tile(np.diag([0.01, 0.04, 0.09, 1e-4, 1e-4, 1e-4]), (N, 1, 1)),
        landmarks=Landmarks(
            position=np.zeros((L, 3)),
            covariance=np.zeros((L, 3, 3)),
            label=np.array([1, 0]),
            deviation=np.zeros(L),
            views=np.array([2, 3]),
            color=np.zeros((L, 3), np.uint8),
        ),
        mounts=Mounts(
            tray_from_dvl=Poses(still[:1], np.zeros((1, 3))),
            tray_from_top=None,
            top_from_bottom=None,
        ),
        navigation_errors=np.zeros(6),
        hull_pose=pose,
        deviation_field=None,
    )


def test_results_are_in_the_hulls_frame_with_a_cad_model() -> None:
    found = solution(hull_pose())
    assert found.frame is Frame.HULL
    first = found.track().poses.translation[0]
    np.testing.assert_allclose(
        first, HULL_TURN.inv().apply(np.array([0.0, 0.0, 4.0]) - HULL_AT), atol=1e-12
    )
    np.testing.assert_allclose(first, [-1.0, 2.0, -1.0], atol=1e-12)


def test_results_stay_in_the_global_frame_without_one() -> None:
    found = solution(None)
    assert found.frame is Frame.GLOBAL
    np.testing.assert_allclose(found.result_from_global().translation, np.zeros((1, 3)))
    np.testing.assert_allclose(
        found.track().poses.translation, found.global_from_vehicle.translation
    )


@pytest.mark.parametrize("pose", [hull_pose(), None], ids=["cad model", "no cad model"])
def test_track_has_sigmas_and_frame_of_result(pose: HullPose | None) -> None:
    found = solution(pose)
    track = found.track()
    assert track.frame is found.frame
    np.testing.assert_array_equal(track.t_ns, found.t_ns)
    np.testing.assert_array_equal(track.tray, found.tray)
    np.testing.assert_array_equal(track.image, found.image)
    np.testing.assert_allclose(track.sigma[:, :3], np.tile([0.1, 0.2, 0.3], (N, 1)))


def test_landmarks_are_counted() -> None:
    assert len(solution(None).landmarks) == L


def test_a_surface_gives_its_mesh() -> None:
    surface = Surface(
        vertices=np.eye(3),
        faces=np.array([[0, 1, 2]], np.int32),
        deviation=np.full(3, np.nan),
        sigma=np.ones(3),
        support=np.array([0, 1, 2]),
    )
    np.testing.assert_array_equal(surface.mesh().vertices, surface.vertices)
    np.testing.assert_array_equal(surface.mesh().faces, surface.faces)


def test_tracks_read_back_with_unseen_pixels() -> None:
    tracks = Tracks(
        landmark=np.array([0, 0, 1]),
        node=np.array([0, 1, 1]),
        top=np.arange(6.0).reshape(3, 2),
        bottom=np.array([[1.0, 2.0], [np.nan, np.nan], [3.0, 4.0]]),
        response=np.array([0.02, 0.03, np.nan]),
        color=np.array([[1, 2, 3], [4, 5, 6]], np.uint8),
    )
    again = from_arrays(Tracks, to_arrays(tracks))
    np.testing.assert_array_equal(again.bottom, tracks.bottom)
    np.testing.assert_array_equal(again.response, tracks.response)
    np.testing.assert_array_equal(again.color, tracks.color)
    assert again.color.dtype == np.uint8
