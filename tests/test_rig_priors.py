# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The rig with its priors, from the sections of dive.toml."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.dive.config.schema import (
    RIG_SECTIONS,
    CameraBottom,
    CameraTop,
    Dvl,
    Imu,
    Pressure,
    Tray,
)
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses, from_mount
from hullrecon.rig import mount_prior, rig_with_priors

MODEL = CameraModel(640, 512, 650.0, 651.0, 322.0, 255.0)
MOUNT, SIGMA = (0.1, 0.2, -0.05, 90.0, 0.0, 90.0), (0.01, 0.02, 0.03, 0.5, 1.0, 2.0)


def sections(**changed):
    """A stereo rig as dive.toml may have it."""
    return {
        "tray": Tray(origin=(0.4, 0.0, 0.1), sigma_deg=0.8),
        "imu": Imu(heading_drift_deg_per_hour=7.2, bias_sigma_deg=0.2),
        "pressure": Pressure(origin=(-0.3, 0.0, 0.1), bias_sigma_m=0.05),
        "dvl": Dvl(
            mount=(0, 0, 0.08, 0, 90, 0),
            mount_sigma=(0.01, 0.01, 0.02, 0.5, 0.5, 0.5),
            scale_sigma=0.004,
        ),
        "camera.top": CameraTop(calibration="t", mount=MOUNT, mount_sigma=SIGMA, sigma_px=0.7),
        "camera.bottom": CameraBottom(
            calibration="b", pose_in_top=(0, 0.1, 0, 0, 0, 0), pose_sigma=(0.0,) * 6
        ),
    } | changed


def rig_of(**changed):
    cameras = {Camera.TOP: MODEL, Camera.BOTTOM: MODEL}
    return rig_with_priors(sections(**changed), cameras)


def test_the_sections_named_are_those_that_are_read():
    assert set(sections()) == set(RIG_SECTIONS)


def test_lengths_stay_metres_and_angles_become_radians():
    rig = rig_of()
    np.testing.assert_array_equal(rig.tray_origin, [0.4, 0, 0.1])
    np.testing.assert_array_equal(rig.pressure_origin, [-0.3, 0, 0.1])
    assert rig.priors.tray_sigma_rad == pytest.approx(np.radians(0.8))
    assert rig.priors.pixel_sigma_px == 0.7
    wanted = [
        0.004,
        np.radians(7.2) / 3600,
        np.radians(0.2),
        np.radians(0.2),
        0.05,
        np.radians(0.8),
    ]
    np.testing.assert_allclose(rig.priors.navigation_sigma, wanted)


def test_the_densitys_sigma_becomes_a_share_of_the_density():
    assert rig_of().priors.density_sigma == pytest.approx(2.05 / 1025)
    fresh = Pressure(origin=(0, 0, 0), density=998.0, density_sigma=0.3)
    assert rig_of(pressure=fresh).priors.density_sigma == pytest.approx(0.3 / 998.0)


def test_zero_sigma_of_error_stays_divisible():
    rig = rig_of(
        pressure=Pressure(origin=(0, 0, 0), bias_sigma_m=0.0),
        dvl=Dvl(mount=(0, 0, 0, 0, 90, 0), scale_sigma=0.0),
    )
    assert rig.priors.navigation_sigma[0] == rig.priors.navigation_sigma[4] == 1e-9


def test_mount_prior_whitens_motions_in_parent_axes():
    """A shift of one sigma along an axis of the tray, or a turn of one about it, costs one."""
    nominal = from_mount(MOUNT)
    rows = mount_prior(nominal, SIGMA)
    for axis in range(3):
        e = np.eye(3)[axis]
        shifted = Poses(nominal.quaternion, nominal.translation + SIGMA[axis] * e)
        turn = Rotation.from_rotvec(np.radians(SIGMA[3 + axis]) * e)
        turned = Poses((turn * nominal.rotation).as_quat(), nominal.translation)
        for moved in (shifted, turned):
            row = rows @ (nominal.inverse() @ moved).log()[0]
            assert np.linalg.norm(row) == pytest.approx(1.0, rel=1e-9)
            assert np.abs(row).max() == pytest.approx(1.0, rel=1e-9)


def test_a_mount_without_any_sigma_is_held():
    assert mount_prior(from_mount(MOUNT), (0.0,) * 6) is None
    assert rig_of().priors.top_from_bottom is None


def test_a_single_sigma_of_zero_is_all_but_held():
    rows = mount_prior(from_mount([0] * 6), (0.0, 0.01, 0.01, 0.5, 0.5, 0.5))
    assert rows[0, 0] == pytest.approx(1e6)
    assert np.isfinite(rows).all()


def test_dvl_position_is_held_and_its_sigma_kept():
    held = rig_of().priors
    np.testing.assert_array_equal(held.dvl_position_sigma_m, [0.01, 0.01, 0.02])
    assert np.linalg.norm(held.tray_from_dvl[0, :3]) == pytest.approx(1e6)


def test_both_cameras_stand_where_dive_toml_has_them():
    rig = rig_of()
    np.testing.assert_allclose(rig.tray_from_top.matrix(), from_mount(MOUNT).matrix())
    np.testing.assert_allclose(rig.top_from_bottom.translation, [[0, 0.1, 0]])
    assert rig.top is MODEL


@pytest.mark.parametrize(
    ("absent", "top", "bottom"),
    [(("camera.bottom",), True, False), (("camera.top", "camera.bottom"), False, False)],
)
def test_a_camera_that_was_not_carried_has_no_mount(absent, top, bottom):
    rig = rig_with_priors(sections(**dict.fromkeys(absent)), {})
    assert (rig.tray_from_top is not None, rig.top_from_bottom is not None) == (top, bottom)
    assert rig.top is None


def test_a_section_of_another_kind_is_named():
    with pytest.raises(TypeError, match=r"section imu is .*, where Imu is expected"):
        rig_of(imu=Tray())


def test_each_camera_has_the_displacement_that_its_calibration_leaves():
    assert rig_of().priors.calibration_sigma_px == (0.1, 0.1)
    exact = CameraBottom(calibration="b", pose_in_top=(0, 0.1, 0, 0, 0, 0), calibration_sigma_px=0)
    assert rig_of(**{"camera.bottom": exact}).priors.calibration_sigma_px == (0.1, 0.0)
