# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import pytest

from hullrecon.dive.config.mounts import guess_sigma

Z_UP = [1, 1, 0.3, 1, 1, 5]
Y_UP = [1, 0.3, 1, 1, 5, 1]
X_UP = [0.3, 1, 1, 5, 1, 1]


@pytest.mark.parametrize(
    ("roll_pitch_yaw_deg", "sigma"),
    [
        ((180, 0, 0), Z_UP),
        ((178, 3, 140), Z_UP),
        ((0, 0, 30), Z_UP),  # z of the file down, as that of the dive's frame
        ((-90, 0, 0), Y_UP),
        ((90, 0, 75), Y_UP),
        ((0, 90, 0), X_UP),
        ((0, -88, 20), X_UP),
    ],
)
def test_height_heel_and_trim_get_small_sigmas_for_any_up_axis(roll_pitch_yaw_deg, sigma):
    assert guess_sigma((20, -3, 1, *roll_pitch_yaw_deg), None).tolist() == sigma


def test_what_is_given_is_by_the_axes_of_the_file():
    assert guess_sigma((0, 0, 0, -90, 0, 0), Z_UP).tolist() == Z_UP
