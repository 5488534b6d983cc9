# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np

from benchmarks.legs import nearest_frames


def test_a_node_stamped_a_rounding_after_its_frame_is_of_that_frame() -> None:
    frame_s = 1777887000.0 + 0.5 * np.arange(4)
    found = nearest_frames(frame_s, frame_s + np.array([-3e-7, 3e-7, 3e-7, 3e-7]))
    np.testing.assert_array_equal(found, [0, 1, 2, 3])


def test_times_before_and_behind_the_frames_are_of_the_outermost() -> None:
    np.testing.assert_array_equal(nearest_frames(np.array([1.0, 2.0, 4.0]), np.array([-5.0, 2.9, 3.1, 9.0])), [0, 1, 2, 2])
