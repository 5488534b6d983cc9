# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np

from hullrecon import native
from hullrecon.adjustment.problem.pruning import result_without, without


def problem():
    """Three landmarks; the middle one is seen from one node alone."""
    p = native.Problem(pose=np.tile([0.0, 0, 0, 0, 0, 0, 1, 0], (2, 1)))
    p.landmark = np.array([[0.0, 0, 1], [9, 9, 9], [0, 0, 2]])
    p.stereo_node, p.stereo_landmark = np.array([0, 1, 0], np.int32), np.array([0, 0, 2], np.int32)
    p.stereo_pixel = np.arange(12.0).reshape(3, 4)
    p.mono_node, p.mono_landmark = np.array([1, 1], np.int32), np.array([1, 2], np.int32)
    p.mono_camera, p.mono_pixel = np.array([0, 1], np.int32), np.array([[1.0, 1], [2, 2]])
    p.surface_landmark, p.surface_weight = np.arange(3, dtype=np.int32), np.array([0.1, 0.2, 0.3])
    return p


def test_a_landmark_goes_with_all_its_factors_and_the_rest_is_numbered_anew() -> None:
    before = problem()
    after = without(before, np.array([True, False, True]))
    assert after.landmark[:, 2].tolist() == [1, 2]
    assert after.stereo_landmark.tolist() == [0, 0, 1]
    assert after.mono_landmark.tolist() == [1]
    assert (after.mono_node.tolist(), after.mono_camera.tolist(), after.mono_pixel.tolist()) == ([1], [1], [[2.0, 2.0]])
    assert after.surface_landmark.tolist() == [0, 1]
    assert after.surface_weight.tolist() == [0.1, 0.3]
    assert len(before.landmark) == 3


def test_tables_that_are_empty_stay_so() -> None:
    after = without(problem(), np.array([True, False, True]))
    assert after.surface_field_index.shape == (0, 4)
    assert len(after.pose) == 2


def test_labels_and_distances_go_with_their_rows() -> None:
    def result(label):
        return native.Result({}, np.array(label), np.arange(float(len(label))), np.ones(0, bool), None, True, "", {})

    kept = result_without(result([1, 0, 1]), np.array([True, False, True]))
    assert (kept.label.tolist(), kept.distance.tolist()) == ([1, 1], [0.0, 2.0])
    assert result_without(result([]), np.array([True, False, True])).label.tolist() == []
