# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Intrinsics as unknowns: poses known to a millimetre look at points from two distances, so the
focal length shows.
"""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest

from hullrecon import native
from hullrecon.adjustment.options import AdjustOptions
from hullrecon.adjustment.problem import intrinsics
from hullrecon.geometry import poses
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import identity
from hullrecon.rig import Rig

TRUE = CameraModel(640, 480, 505.0, 504.0, 322.0, 241.0, -0.05)
CALIBRATED = CameraModel(640, 480, 500.0, 500.0, 320.0, 240.0, -0.05)
ASKED = AdjustOptions(refine_intrinsics=True, focal_sigma=0.01)


def rig_of(top, bottom):
    return Rig(
        tray_origin=np.zeros(3),
        pressure_origin=np.zeros(3),
        tray_from_dvl=identity(),
        camera_models={Camera.TOP: top, Camera.BOTTOM: bottom},
    )


@dataclass(frozen=True)
class Measured:
    rig: Rig


@pytest.fixture
def rig():
    return rig_of(CALIBRATED, CALIBRATED)


@pytest.fixture
def problem():
    """Ten nodes, 80 points, the true camera's pixels with a tenth of a pixel of noise; all but
    intrinsics as it is.
    """
    rng = np.random.default_rng(2)
    at = np.c_[rng.uniform(-0.3, 0.3, (10, 2)), np.tile([0.0, 0.4], 5)]
    nodes = poses.from_rpy(at, 0.1 * rng.standard_normal((10, 3)))
    points = np.c_[rng.uniform(-0.5, 0.5, (80, 2)), rng.uniform(1.4, 1.8, 80)]
    pose = np.hstack([nodes.translation, nodes.quaternion])
    node, landmark = np.repeat(np.arange(10), 80), np.tile(np.arange(80), 10)
    pixel = TRUE.project(nodes.inverse()[node].apply(points[landmark])) + 0.1 * rng.standard_normal(
        (800, 2)
    )
    return native.Problem(
        unknowns=native.Unknowns(pose=np.hstack([pose, np.zeros((10, 1))]), landmark=points),
        constant=(
            "T_s_ct",
            "T_ct_cb",
            "T_s_d",
            "T_g_M",
            "navigation",
            "intrinsics_top",
            "intrinsics_bottom",
            "tray",
            "deviation",
        ),
        priors=native.Priors(
            pose=native.PosePriors(
                node=np.arange(10, dtype=np.int32),
                value=pose,
                sqrt_information=np.tile(np.eye(6) / 1e-3, (10, 1, 1)),
            )
        ),
        mono=native.MonoTable(
            node=node.astype(np.int32),
            landmark=landmark.astype(np.int32),
            camera=np.zeros(800, np.int32),
            pixel=pixel,
        ),
        sigma_px=0.1,
    )


def test_nothing_is_freed_unless_asked_for(problem, rig) -> None:
    assert intrinsics.free_intrinsics(problem, rig, AdjustOptions()) is problem


def test_only_a_camera_that_saw_something_is_freed(problem, rig) -> None:
    constant = intrinsics.free_intrinsics(problem, rig, ASKED).constant
    assert "intrinsics_top" not in constant
    assert "intrinsics_bottom" in constant


def test_a_wrong_focal_length_is_found(problem, rig) -> None:
    free = intrinsics.free_intrinsics(problem, rig, ASKED)
    result = native.solve(free, native.Options(function_tolerance=1e-12))
    found = intrinsics.apply_intrinsics(Measured(rig), free, result).rig
    assert found.top.fx == pytest.approx(TRUE.fx, abs=0.7)
    assert found.top.fy == pytest.approx(TRUE.fy, abs=0.7)
    assert found.bottom is CALIBRATED
    assert rig.top.fx == 500.0


def test_every_round_starts_from_the_calibration(problem, rig) -> None:
    found_before = replace(problem.unknowns, intrinsics_top=TRUE.parameters())
    problem = problem.started_from(found_before)
    free = intrinsics.free_intrinsics(problem, rig, ASKED)
    np.testing.assert_array_equal(free.unknowns.intrinsics_top, CALIBRATED.parameters())
    np.testing.assert_array_equal(problem.unknowns.intrinsics_top, TRUE.parameters())


def test_priors_are_shares_of_the_focal_length_and_pixels() -> None:
    sigma = intrinsics.prior_sigma(
        CALIBRATED, AdjustOptions(focal_sigma=0.01, center_sigma_px=4, distortion_sigma=0.02)
    )
    np.testing.assert_allclose(sigma, [5, 5, 4, 4, 0.02, 0.02, 0.002, 0.002, 0.02])


def test_intrinsics_moved_far_are_warned_of(rig) -> None:
    found = rig_of(replace(CALIBRATED, fx=520.0, cx=321.0), CALIBRATED)
    nothing = np.zeros((9, 9))
    marginals = SimpleNamespace(intrinsics_top=np.diag(np.full(9, 0.04)), intrinsics_bottom=nothing)
    figures = intrinsics.summarise_intrinsics(rig, found, marginals, ASKED)
    assert list(figures) == ["top"]
    assert figures["top"]["fx"] == {
        "calibrated": 500.0,
        "found": 520.0,
        "sigma": 0.2,
        "moved_in_prior_sigma": 4.0,
    }
    said = intrinsics.intrinsics_warnings(figures)
    assert len(said) == 1
    assert "camera.top" in said[0]
    assert "fx from 500 to 520" in said[0]
    assert "cx" not in said[0]


def test_held_cameras_have_no_figures_and_no_warning(rig) -> None:
    marginals = SimpleNamespace(intrinsics_top=np.zeros((9, 9)), intrinsics_bottom=np.zeros((9, 9)))
    assert intrinsics.summarise_intrinsics(rig, rig, marginals, ASKED) == {}
    assert intrinsics.intrinsics_warnings({}) == []


def test_a_camera_is_written_as_it_is_read() -> None:
    assert CameraModel(**intrinsics.camera_fields(TRUE)) == TRUE
