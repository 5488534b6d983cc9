# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np

from hullrecon import native
from hullrecon.adjustment.problem.selection import drop_label_rows, drop_landmarks


def problem():
    """Three landmarks; the middle one is seen from one node alone."""

    def row(*numbers):
        return np.array(numbers, np.int32)

    return native.Problem(
        unknowns=native.Unknowns(
            pose=np.tile([0.0, 0, 0, 0, 0, 0, 1, 0], (2, 1)),
            landmark=np.array([[0.0, 0, 1], [9, 9, 9], [0, 0, 2]]),
        ),
        stereo=native.StereoTable(
            node=row(0, 1, 0),
            landmark=row(0, 0, 2),
            pixel=np.arange(12.0).reshape(3, 4),
            sigma_ratio=np.array([0.5, 1.0, 2.0]),
        ),
        mono=native.MonoTable(
            node=row(1, 1), landmark=row(1, 2), camera=row(0, 1), pixel=np.array([[1.0, 1], [2, 2]])
        ),
        surface=native.SurfaceTable(landmark=row(0, 1, 2), weight=np.array([0.1, 0.2, 0.3])),
    )


def test_dropped_landmark_takes_its_factors() -> None:
    before = problem()
    after = drop_landmarks(before, np.array([True, False, True]))
    assert after.unknowns.landmark[:, 2].tolist() == [1, 2]
    assert after.stereo.landmark.tolist() == [0, 0, 1]
    assert after.stereo.sigma_ratio.tolist() == [0.5, 1.0, 2.0]
    assert after.mono.landmark.tolist() == [1]
    assert len(after.mono.sigma_ratio) == 0
    assert (after.mono.node.tolist(), after.mono.camera.tolist(), after.mono.pixel.tolist()) == (
        [1],
        [1],
        [[2.0, 2.0]],
    )
    assert after.surface.landmark.tolist() == [0, 1]
    assert after.surface.weight.tolist() == [0.1, 0.3]
    assert len(before.unknowns.landmark) == 3


def test_tables_that_are_empty_stay_so() -> None:
    after = drop_landmarks(problem(), np.array([True, False, True]))
    assert after.surface.field.index.shape == (0, 4)
    assert len(after.unknowns.pose) == 2


def test_labels_and_distances_go_with_their_rows() -> None:
    def result(label):
        return native.Result(
            unknowns=problem().unknowns,
            label=np.array(label),
            distance=np.arange(float(len(label))),
            ray_hit=np.ones(0, bool),
            iterations=None,
            converged=True,
            message="",
            seconds={},
        )

    kept = drop_label_rows(result([1, 0, 1]), np.array([True, False, True]))
    assert (kept.label.tolist(), kept.distance.tolist()) == ([1, 1], [0.0, 2.0])
    assert drop_label_rows(result([]), np.array([True, False, True])).label.tolist() == []
