# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.geometry.poses import identity
from hullrecon.geometry.rotations import roll_pitch_yaw
from hullrecon.synthetic.dive import Dive
from hullrecon.synthetic.options import Survey, with_options
from hullrecon.synthetic.vehicle import TRAY_ORIGIN, leg_corners, simulate_path


def test_legs_go_back_and_forth_and_step_down() -> None:
    corners = leg_corners(Survey(legs=3, leg_length_m=4.0, leg_spacing_m=0.5), 30.0, 6.0)
    np.testing.assert_allclose(corners, [[32, 6], [28, 6], [28, 5.5], [32, 5.5], [32, 5], [28, 5]])


def test_sensors_keep_their_standoff(dive: Dive) -> None:
    t = np.arange(2.0, dive.motion.t_s[-1] - 2.0, 0.5)
    tray = dive.motion.in_hull(dive.motion.on_tray(t, identity(), TRAY_ORIGIN))
    from hullrecon.geometry.meshes.casting import Scene

    distance = Scene(dive.cad_model).closest(tray.translation).distance
    np.testing.assert_allclose(distance, dive.spec.survey.standoff_m, atol=0.08)


def test_tray_looks_at_steel_squarely(dive: Dive) -> None:
    t = np.arange(2.0, dive.motion.t_s[-1] - 2.0, 0.5)
    tray = dive.motion.in_hull(dive.motion.on_tray(t, identity(), TRAY_ORIGIN))
    forward = tray.rotation.apply([1.0, 0, 0])
    hits = dive.hull.near(0.0).rays.cast(tray.translation, forward)
    normal = (
        dive.hull.near(0.0).built.normal[dive.hull.near(0.0).built.mesh.faces[hits.face]].mean(1)
    )
    incidence = np.degrees(np.arccos(-(normal * forward).sum(1) / np.linalg.norm(normal, axis=1)))
    assert hits.hit.all()
    assert np.median(incidence) < 4


def test_global_frame_starts_at_first_pose_on_water_surface(dive: Dive) -> None:
    first = dive.motion.vehicle(np.array([0.0]))
    np.testing.assert_allclose(first.translation[0, :2], 0, atol=0.02)
    assert abs(roll_pitch_yaw(first.rotation)[0, 2]) < 0.01
    surface = dive.motion.global_from_hull.apply(np.array([[30.0, 0.0, dive.spec.ship.draught_m]]))
    assert abs(surface[0, 2]) < 0.4  # the ship has a little trim


def test_speed_along_leg_is_as_asked(dive: Dive) -> None:
    t = np.arange(
        2.2, 1.0 + dive.spec.survey.leg_length_m / dive.spec.survey.speed_m_per_s - 1.2, 0.1
    )
    place = dive.motion.in_hull(dive.motion.vehicle(t)).translation[:, 0]
    assert abs(np.ptp(place) / np.ptp(t)) == pytest.approx(dive.spec.survey.speed_m_per_s, rel=0.2)


def test_motion_is_smooth(dive: Dive) -> None:
    t = np.arange(0.5, dive.motion.t_s[-1] - 0.5, 0.05)
    assert np.linalg.norm(dive.motion.acceleration(t), axis=1).max() < 0.5
    assert np.abs(dive.motion.rates(t)).max() < 0.3


def test_true_tray_differs_from_encoder_by_backlash(dive: Dive) -> None:
    gap = np.degrees(dive.motion.tray - dive.motion.encoder)
    assert np.abs(gap).max() == pytest.approx(dive.spec.errors.backlash_deg, rel=1e-6)
    corners = leg_corners(dive.spec.survey, float(dive.hull.skin.along_m.mean()), 0.0)
    rigid = simulate_path(with_options(dive.spec, backlash_deg=0.0), dive.hull.skin, corners)
    np.testing.assert_array_equal(rigid.tray, rigid.encoder)
