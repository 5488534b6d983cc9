# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Impossible keypoints are refused, and what lies at the border is described by what is there;
tests/vision compares descriptors with OpenCV's.
"""

import numpy as np
import pytest

from hullrecon import native
from hullrecon.errors import InputError


def described(at, level=0, shape=(30, 40)):
    """Describe a keypoint in a picture that gets brighter to the right."""
    picture = np.tile(np.arange(shape[1], dtype=np.float32), (shape[0], 1))
    return native.describe_keypoints([picture], np.array([at], float), np.array([level]))


@pytest.mark.parametrize("shape", [(30, 40), (3, 10)])
@pytest.mark.parametrize("corner", [(0, 0), (1, 1)])
def test_gradients_past_the_border_do_not_count(corner, shape):
    place = np.array(corner) * [shape[1] - 1, shape[0] - 1]
    numbers = described([*place, 2.0, 0.0], shape=shape).reshape(16, 8)
    assert numbers[:, 0].any()  # along u
    assert not numbers[:, 1:].any()


def test_keypoints_that_are_not_in_a_level_are_refused():
    with pytest.raises(InputError, match="keypoints"):
        described([40.0, 3.0, 1.6, 0.0])
    with pytest.raises(InputError, match="keypoints"):
        described([3.0, 3.0, np.nan, 0.0])
    with pytest.raises(InputError, match="level"):
        described([3.0, 3.0, 1.6, 0.0], level=1)
    with pytest.raises(InputError, match="levels"):
        described([3.0, 3.0, 1.6, 0.0], shape=(30, 9))
