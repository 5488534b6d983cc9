# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.geometry.poses import from_mount
from hullrecon.synthetic.options import spec_from
from hullrecon.synthetic.vehicle import BOTTOM_IN_TOP, CAMERA_MOUNT, DVL_MOUNT, true_rig


def test_rig_is_off_nominal_by_little_and_by_its_seed_alone() -> None:
    a, b = true_rig(spec_from(seed=1)), true_rig(spec_from(seed=1, legs=9))
    np.testing.assert_array_equal(a.tray_from_top.matrix(), b.tray_from_top.matrix())
    assert (true_rig(spec_from(seed=2)).tray_from_top.matrix() != a.tray_from_top.matrix()).any()


def test_camera_looks_through_pixels_as_wide_as_asked() -> None:
    rig = true_rig(spec_from(image_width=800, image_height=600))
    assert (rig.camera_top.width, rig.camera_top.height) == (800, 600)
    assert rig.camera_top.fx == pytest.approx(824)
    assert true_rig(spec_from(cameras="mono")).camera_bottom is None


@pytest.mark.parametrize("seed", range(5))
def test_true_mounts_are_near_nominal_mounts(seed: int) -> None:
    rig = true_rig(spec_from(seed=seed))
    for nominal, true in ((DVL_MOUNT, rig.tray_from_dvl), (CAMERA_MOUNT, rig.tray_from_top)):
        off = (from_mount(nominal).inverse() @ true).log()[0]
        assert 0 < np.linalg.norm(off[:3]) < 0.015
        assert 0 < np.degrees(np.linalg.norm(off[3:])) < 1.3


def test_stereo_pair_is_as_calibrated() -> None:
    np.testing.assert_array_equal(
        true_rig(spec_from()).top_from_bottom.matrix(), from_mount(BOTTOM_IN_TOP).matrix()
    )
